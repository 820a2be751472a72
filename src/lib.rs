//! Etendue: a Monte Carlo renderer on Intel Embree 4 that states how wrong its image is.
//!
//! A [`Session`] holds a scene that was loaded or built in code. It renders images to a number of samples, a time or an error,
//! with error bars and layers, and answers ray queries.
//!
//! ```
//! use etendue::description::{
//!     CameraDescription, GeometryDescription, LightDescription, MaterialDescription,
//!     MaterialModel, Place, SceneDescription, ShapeDescription,
//! };
//! use etendue::vec::DVec3;
//! use etendue::{RenderOptions, Rgb, Session, NullRenderObserver, tracing};
//!
//! # fn main() -> etendue::Result<()> {
//! let eye = DVec3::new(0.0, 1.0, 4.0);
//! let camera = CameraDescription::look_at(eye, DVec3::ZERO, DVec3::Y, 40.0_f64.to_radians())?;
//! let mut scene = SceneDescription::new("ball", camera);
//! scene.film.size = (32, 24);
//! let reflectance = Rgb::grey(0.7).into();
//! let white = MaterialModel::Diffuse { reflectance };
//! scene.add_material(MaterialDescription::new("white", Place::default(), white))?;
//! let ball = GeometryDescription::Sphere { center: DVec3::ZERO, radius: 1.0 };
//! scene.add_shape(ShapeDescription::new("ball", Place::default(), ball))?;
//! scene.add_light(LightDescription::sky(Place::default(), Rgb::WHITE))?;
//!
//! let session = Session::new(scene, tracing())?;
//! let mut rendering = session.render(&RenderOptions::samples(128), &NullRenderObserver)?;
//! rendering.add_samples(&session, 128, &NullRenderObserver)?;
//! assert_eq!(rendering.spp(), 256);
//! // A white sky lights the ball evenly, and is seen beside it.
//! let middle = rendering.image().get(16, 12).to_array()[1];
//! assert!((middle - 0.7).abs() < 0.1);
//! # Ok(())
//! # }
//! ```
//!
//! `examples/` has whole programs. The command `etendue` is the package in `cli/`, the C library that in `capi/`. How the renderer
//! works is in `docs/architecture.md`; how to add a BSDF, a light or an integrator to it in `CONTRIBUTING.md`: these are
//! enumerations, so that kernels know them when they are compiled, and are extended in the source.
//!
//! No state is kept for the process but a count of sessions: any number of them may live and render at once, on threads of their
//! own. Vectors and matrices in the interface are those of glam, as [`mod@vec`] re-exports them; no other dependency shows.
//!
//! Measure: lengths in world units, images in radiance.
//! Range: any input; what is not valid gives an [`Error`].
//! Source: named in each module. Tested above and in `tests/rendering/session.rs`.
//!
//! # Features
//!
//! - `embree` (default): the Embree backend, through the system's library. Without it, rays are traced by obvhs, in Rust.
//! - `oidn` (default): Intel Open Image Denoise, where it is found when running.
//!
//! # Versions
//!
//! Rust 1.89 or newer; a minor version may require a newer one. While the major version is 0, minor versions may break
//! programs, too. Enumerations that may grow are non-exhaustive.

// Modules have more than the public interface needs: what the lab, the command and tests use of them.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unused_imports))]

mod accel;
mod bsdf;
mod camera;
mod effects;
mod error;
mod film;
mod geometry;
mod image;
mod integrator;
mod light;
mod math;
pub mod memory;
mod plan;
mod planted;
mod post;
mod render;
mod sampler;
mod sampling;
mod scene;
mod session;
mod state;

pub use accel::{AccelOptions, Backend, Precision, Quality};
pub use effects::kernel::Kernel;
pub use effects::{Effect, EffectSet};
pub use error::{Error, ErrorKind, Result};
pub use film::error_bars::ErrorBars;
pub use film::filter::FilterSampling;
pub use film::{Doubt, ErrorEstimate, Film, Window};
pub use geometry::texture::Texture;
pub use geometry::texture_image::TextureImage;
pub use image::metrics::rel_mse;
pub use image::{
    ColourSpace, Image, Layer, LayeredImage, MAX_SIDE, MetadataValue, WriteOptions, write,
};
pub use integrator::RayCounts;
pub use integrator::kind::IntegratorKind;
pub use integrator::light_paths::LightPathShare;
pub use integrator::reuse::PathReuse;
pub use integrator::roulette::{ParseRouletteError, Roulette, WeightWindow};
pub use light::types::LightChoice;
pub use math::rgb::Rgb;
pub use math::vec;
pub use render::auto::{LightPathChoice, PathChoices, PathReuseChoice, Recommendation};
pub use render::options::RenderOptions;
pub use render::settings::{Adaptive, BounceLimit, LightPathRule, PathReuseRule};
pub use render::settings::{Budget, ErrorTarget, RenderSettings, SamplerKind};
pub use render::{CONFIDENCE, NullRenderObserver, Progress, RenderObserver};
pub use render::{NonFiniteSample, Predicted, Price, Rejected, Rendered};
pub use sampling::warp::sample_hemisphere_cosine;
pub use scene::description;
pub use scene::footprint::mesh_build_memory;
pub use scene::{check, load};
pub use session::{QueryRay, Rendering, Session, SurfaceHit, Work, tracing};
pub use state::{Shard, State};

/// The parts of the renderer, for the packages of this workspace and for tests: no promise is kept of them.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub mod accel {
        pub use crate::accel::*;
    }
    pub mod bsdf {
        pub use crate::bsdf::*;
    }
    pub mod camera {
        pub use crate::camera::*;
    }
    pub mod effects {
        pub use crate::effects::*;
    }
    pub mod film {
        pub use crate::film::*;
    }
    pub mod geometry {
        pub use crate::geometry::*;
    }
    pub mod image {
        pub use crate::image::*;
    }
    pub mod integrator {
        pub use crate::integrator::*;
    }
    pub mod light {
        pub use crate::light::*;
    }
    pub mod math {
        pub use crate::math::*;
    }
    pub mod plan {
        pub use crate::plan::*;
    }
    pub mod post {
        pub use crate::post::*;
    }
    pub mod render {
        pub use crate::render::*;
    }
    pub mod sampler {
        pub use crate::sampler::*;
    }
    pub mod sampling {
        pub use crate::sampling::*;
    }
    pub mod scene {
        pub use crate::scene::*;
    }
    pub mod session {
        pub use crate::session::*;
    }
    pub mod state {
        pub use crate::state::*;
    }
}
