//! Observers of paths as they are built; without an observer they cost nothing.
//!
//! Measure: normalised scene units; radiance.
//! Range: every vertex of every path.
//! Source: none needed. Tested through `etendue render --pixel`, in `cli/tests/command/render.rs`.

use crate::accel::PrimitiveId;
use crate::bsdf::types::Lobe;
use crate::effects::Effects;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::scene::interaction::Interaction;

/// The kind of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RayKind {
    /// A camera ray, for the closest hit.
    Camera,
    /// A shadow ray to a light, for visibility.
    Shadow,
    /// An extension ray after the first scattering event, for the closest hit.
    Bounce1,
    /// An extension ray after the second scattering event.
    Bounce2,
    /// An extension ray after the third or a later scattering event.
    Bounce3,
    /// An extension ray after a delta lobe, at any scattering event.
    Specular,
}

impl RayKind {
    /// Every kind.
    pub const ALL: &'static [Self] = &[
        Self::Camera,
        Self::Shadow,
        Self::Bounce1,
        Self::Bounce2,
        Self::Bounce3,
        Self::Specular,
    ];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Shadow => "shadow",
            Self::Bounce1 => "bounce 1",
            Self::Bounce2 => "bounce 2",
            Self::Bounce3 => "bounce 3+",
            Self::Specular => "specular",
        }
    }

    /// The kind of the extension ray after scattering event number `bounce`, counted from 0.
    pub fn extension(bounce: u32, is_delta: bool) -> Self {
        match bounce {
            _ if is_delta => Self::Specular,
            0 => Self::Bounce1,
            1 => Self::Bounce2,
            _ => Self::Bounce3,
        }
    }
}

/// A vertex of a path on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathVertex {
    /// The position, in normalised scene units.
    pub p: Vec3,
    /// The geometric normal.
    pub ng: Vec3,
    /// The primitive.
    pub id: PrimitiveId,
}

impl<E: Effects> From<&Interaction<E>> for PathVertex {
    #[inline(always)]
    fn from(at: &Interaction<E>) -> Self {
        Self {
            p: at.p,
            ng: at.ng,
            id: at.id,
        }
    }
}

/// Receives the events of paths from an integrator. Every method does nothing unless it is implemented.
pub trait PathObserver {
    /// Whether anything is observed.
    #[inline(always)]
    fn is_observing(&self) -> bool {
        true
    }

    /// Whether the observer needs paths in sequence, each from its beginning to its end. Otherwise the events of a
    /// wavefront may be reported stage by stage, in the order in which the rays are traced; the visibility of a light
    /// is then reported after the scattering event that follows it.
    #[inline(always)]
    fn is_sequential(&self) -> bool {
        true
    }

    /// Called before a ray is traced. A ray that continues behind a surface with alpha is reported once.
    fn traced(&mut self, _kind: RayKind, _ray: &Ray, _time: f32) {}
    /// Called when the path arrives at a surface, with its throughput.
    fn arrived(&mut self, _at: &PathVertex, _beta: Rgb) {}
    /// Called when the path leaves the scene along this direction.
    fn escaped(&mut self, _direction: Vec3) {}
    /// Called when radiance of the environment has been added.
    fn environment(&mut self, _contribution: Rgb) {}
    /// Called when emission found by scattering has been added, with its MIS weight against light sampling.
    fn emission(&mut self, _contribution: Rgb, _weight: f32) {}
    /// Called with a contribution of light sampling, its MIS weight, and the visibility found by the shadow ray.
    fn light(&mut self, _contribution: Rgb, _weight: f32, _visible: f32) {}
    /// Called when light sampling finds no light that contributes here.
    fn unlit(&mut self) {}
    /// Called when indirect light from a cache has been added, and the path has ended.
    fn cached_indirect(&mut self, _contribution: Rgb) {}
    /// Called when the path has been scattered.
    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {}
    /// Called when Russian roulette ends the path, which had this survival probability.
    fn terminated(&mut self, _survival: f32) {}
    /// Called when the path ends at a surface: by absorption, or by the bounce limit.
    fn absorbed(&mut self) {}
    /// Called with the value of the sample, which the film adds if it is finite.
    fn sample_added(&mut self, _value: Rgb) {}
}

/// An observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullPathObserver;

impl PathObserver for NullPathObserver {
    #[inline(always)]
    fn is_observing(&self) -> bool {
        false
    }

    #[inline(always)]
    fn is_sequential(&self) -> bool {
        false
    }
}
