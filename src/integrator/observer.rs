//! Watching a path as it is built, at no cost when nobody does.
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

/// What a ray is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RayKind {
    /// From the camera, to the closest hit.
    Camera,
    /// To a light, for visibility.
    Shadow,
    /// After the first scattering event, to the closest hit.
    Bounce1,
    /// After the second.
    Bounce2,
    /// After the third and later ones.
    Bounce3,
    /// After a delta lobe, whichever event it was.
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

    /// Its name in reports.
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

    /// What the ray is that leaves scattering event number `bounce`, counted from 0.
    pub fn extension(bounce: u32, is_delta: bool) -> Self {
        match bounce {
            _ if is_delta => Self::Specular,
            0 => Self::Bounce1,
            1 => Self::Bounce2,
            _ => Self::Bounce3,
        }
    }
}

/// A point of a path on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathVertex {
    /// Where, in normalised scene units.
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

/// What an integrator tells of a path. Every method does nothing unless it is implemented.
pub trait PathObserver {
    /// Whether the observer needs paths in sequence, each from its beginning to its end. Else it may be told of the paths of a
    /// wavefront, stage by stage, in the order in which their rays are traced; the visibility of a light then comes after what
    /// follows from it.
    #[inline(always)]
    fn is_sequential(&self) -> bool {
        true
    }

    /// A ray is about to be traced. One that goes on behind a surface that is partly there is told once.
    fn traced(&mut self, _kind: RayKind, _ray: &Ray, _time: f32) {}
    /// The path came to a surface with this throughput.
    fn arrived(&mut self, _at: &PathVertex, _beta: Rgb) {}
    /// The path left the scene along this direction.
    fn escaped(&mut self, _direction: Vec3) {}
    /// What comes from beyond the scene was added.
    fn environment(&mut self, _contribution: Rgb) {}
    /// Emission found by scattering was added, with this weight against light sampling.
    fn emission(&mut self, _contribution: Rgb, _weight: f32) {}
    /// Light sampling found this contribution, with this weight; `visible` tells what the shadow ray said.
    fn light(&mut self, _contribution: Rgb, _weight: f32, _visible: f32) {}
    /// Light sampling found no light that shines here.
    fn unlit(&mut self) {}
    /// Indirect light that is known was added, and the path ended.
    fn cached_indirect(&mut self, _contribution: Rgb) {}
    /// The path was scattered.
    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {}
    /// The path ended by Russian roulette, which let it survive with this probability.
    fn terminated(&mut self, _survival: f32) {}
    /// The path ended at a surface: it absorbed everything, or the limit of bounces was reached.
    fn absorbed(&mut self) {}
    /// The sample has this value, which its pixel has taken in if it is finite.
    fn filmed(&mut self, _value: Rgb) {}
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl PathObserver for Unobserved {
    #[inline(always)]
    fn is_sequential(&self) -> bool {
        false
    }
}
