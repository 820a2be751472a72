//! The effects that a scene can require, sets of them, and the kernels compiled for some sets.
//!
//! An effect is on if the scene or the settings need it. A kernel is code for a set of effects: it renders any scene
//! that requires no other, and its results equal bit for bit those of the kernel with all effects. Effects outside the
//! set are not compiled into it, and their state takes no memory.
//!
//! Measure: none.
//! Range: at most 32 effects.
//! Source: docs/architecture.md, "Effects". Tested in `tests/rendering/effects.rs`.

pub mod kernel;
pub mod switch;

pub use kernel::Kernel;
pub use switch::{EffectState, Effects, Slot, Switch};

/// Panics where a kernel lacks an effect of the scene. `render` ensures that a scene is rendered by a kernel that has all
/// of its effects.
#[cold]
pub(crate) fn beyond_kernel() -> ! {
    unreachable!("a kernel was chosen that lacks an effect of the scene")
}

/// A feature that the renderer simulates only where a scene requires it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// Shading normals that differ from the geometric ones.
    ShadingNormals,
    /// Colours that vary over a surface.
    Textures,
    /// Shading normals from images.
    NormalMaps,
    /// Partly transparent surfaces (alpha).
    Alpha,
    /// Surfaces whose back absorbs all light.
    OneSided,
    /// Rough reflection.
    Glossy,
    /// Mirror reflection and smooth refraction: delta lobes.
    Specular,
    /// Light that passes through surfaces.
    Transmission,
    /// A lens of finite aperture.
    Lens,
    /// A moving camera, or moving objects, while the shutter is open.
    Motion,
    /// Environment light: light at infinity in all directions.
    Environment,
    /// Environment light that varies with direction.
    EnvironmentMap,
    /// Delta lights: point, spot and distant.
    DeltaLights,
    /// Shapes that emit.
    AreaLights,
    /// More than one light to select from.
    ManyLights,
    /// Groups of shapes placed several times, or moving.
    Instances,
    /// Light paths beside camera paths.
    LightPaths,
    /// Paths shared by the pixels of a group.
    Reuse,
}

impl Effect {
    /// Every effect, in the order in which they are listed.
    pub const ALL: [Self; 18] = [
        Self::ShadingNormals,
        Self::Textures,
        Self::NormalMaps,
        Self::Alpha,
        Self::OneSided,
        Self::Glossy,
        Self::Specular,
        Self::Transmission,
        Self::Lens,
        Self::Motion,
        Self::Environment,
        Self::EnvironmentMap,
        Self::DeltaLights,
        Self::AreaLights,
        Self::ManyLights,
        Self::Instances,
        Self::LightPaths,
        Self::Reuse,
    ];

    /// The name in tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ShadingNormals => "shading-normals",
            Self::Textures => "textures",
            Self::NormalMaps => "normal-maps",
            Self::Alpha => "alpha",
            Self::OneSided => "one-sided",
            Self::Glossy => "glossy",
            Self::Specular => "specular",
            Self::Transmission => "transmission",
            Self::Lens => "lens",
            Self::Motion => "motion",
            Self::Environment => "environment",
            Self::EnvironmentMap => "environment-map",
            Self::DeltaLights => "delta-lights",
            Self::AreaLights => "area-lights",
            Self::ManyLights => "many-lights",
            Self::Instances => "instances",
            Self::LightPaths => "light-paths",
            Self::Reuse => "reuse",
        }
    }

    /// The work that a kernel without the effect leaves out.
    pub const fn leaves_out(self) -> &'static str {
        match self {
            Self::ShadingNormals => "interpolating normals, and correcting those that face away",
            Self::Textures => "texture coordinates and looking colours up at every hit",
            Self::NormalMaps => "tangents, and tilting the shading frame",
            Self::Alpha => "an opacity test at every hit and along every shadow ray",
            Self::OneSided => "a test of the side at every hit",
            Self::Glossy => "microfacets and their tables",
            Self::Specular => "lobes without a density, which light sampling cannot find",
            Self::Transmission => "sides, refractive indices and their factor on roulette",
            Self::Lens => "a point on the lens for every camera ray",
            Self::Motion => "a time for every sample, and moving rays and bounds",
            Self::Environment => "light along rays that leave the scene",
            Self::EnvironmentMap => {
                "sampling an image of the sky, and its density for rays that leave"
            }
            Self::DeltaLights => "point, spot and distant lights",
            Self::AreaLights => "points on lamps, and the density of lamps that scattered rays hit",
            Self::ManyLights => "choosing a light",
            Self::Instances => "transforms of hits and rays",
            Self::LightPaths => {
                "densities of light paths along camera paths, and paths that begin at lights"
            }
            Self::Reuse => "surfaces seen and paths shared by the pixels of a group",
        }
    }
}

/// A set of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct EffectSet(u32);

impl EffectSet {
    /// No effect.
    pub const NONE: Self = Self(0);

    /// Every effect.
    pub const ALL: Self = Self((1 << Effect::ALL.len()) - 1);

    /// The set with one more effect.
    pub const fn with(self, effect: Effect) -> Self {
        Self(self.0 | 1 << effect as u32)
    }

    /// The set with one more effect if `condition` holds.
    pub const fn with_if(self, effect: Effect, condition: bool) -> Self {
        if condition { self.with(effect) } else { self }
    }

    /// The set without an effect.
    pub const fn without(self, effect: Effect) -> Self {
        Self(self.0 & !(1 << effect as u32))
    }

    /// Whether the effect is in the set.
    pub const fn has(self, effect: Effect) -> bool {
        self.0 >> effect as u32 & 1 == 1
    }

    /// Whether every effect of `other` is in the set.
    pub const fn contains(self, other: Self) -> bool {
        other.0 & !self.0 == 0
    }

    /// The number of effects in the set.
    pub const fn len(self) -> u32 {
        self.0.count_ones()
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Iterates over the effects of the set in order.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |&e| self.has(e))
    }
}

/// The union of two sets.
impl std::ops::BitOr for EffectSet {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl std::ops::BitOrAssign for EffectSet {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// Builds the set of the given effects.
impl FromIterator<Effect> for EffectSet {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> Self {
        effects.into_iter().fold(Self::NONE, Self::with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effect_sets_contain_exactly_the_inserted_effects() {
        let set: EffectSet = [Effect::Lens, Effect::Alpha].into_iter().collect();
        assert_eq!(set.len(), 2);
        assert!(set.iter().eq([Effect::Alpha, Effect::Lens]));
        assert!(EffectSet::ALL.contains(set) && !set.contains(EffectSet::ALL));
        assert!(set.without(Effect::Lens).without(Effect::Alpha).is_empty());
        for (index, effect) in Effect::ALL.into_iter().enumerate() {
            assert_eq!(effect as usize, index);
            assert!(EffectSet::ALL.has(effect) && !EffectSet::NONE.has(effect));
        }
    }
}
