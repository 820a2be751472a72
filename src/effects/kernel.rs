//! The kernels: sets of effects that code is compiled for.
//!
//! A scene is rendered by the kernel with the fewest effects that has all effects of the scene. The sets follow common
//! scenes: diffuse rooms; textures; mirrors and glass; any material, alone, with light paths or with shared paths; any
//! material with a lens, with motion, with instances. The last set has every effect.
//!
//! Measure: none.
//! Range: every set of effects has a kernel.
//! Source: docs/architecture.md, "Effects". Tested in `tests/rendering/effects.rs`, and their number in
//! `tests/layering.rs`.

use super::switch::{Off, On};
use super::{EffectSet, Effects};

/// [`On`] if the first name is among those in brackets, else [`Off`].
macro_rules! switch {
    ($effect:ident []) => { Off };
    (ShadingNormals [ShadingNormals $($rest:ident)*]) => { On };
    (Textures [Textures $($rest:ident)*]) => { On };
    (NormalMaps [NormalMaps $($rest:ident)*]) => { On };
    (Alpha [Alpha $($rest:ident)*]) => { On };
    (OneSided [OneSided $($rest:ident)*]) => { On };
    (Glossy [Glossy $($rest:ident)*]) => { On };
    (Specular [Specular $($rest:ident)*]) => { On };
    (Transmission [Transmission $($rest:ident)*]) => { On };
    (Lens [Lens $($rest:ident)*]) => { On };
    (Motion [Motion $($rest:ident)*]) => { On };
    (Environment [Environment $($rest:ident)*]) => { On };
    (EnvironmentMap [EnvironmentMap $($rest:ident)*]) => { On };
    (DeltaLights [DeltaLights $($rest:ident)*]) => { On };
    (AreaLights [AreaLights $($rest:ident)*]) => { On };
    (ManyLights [ManyLights $($rest:ident)*]) => { On };
    (Instances [Instances $($rest:ident)*]) => { On };
    (LightPaths [LightPaths $($rest:ident)*]) => { On };
    (Reuse [Reuse $($rest:ident)*]) => { On };
    ($effect:ident [$other:ident $($rest:ident)*]) => { switch!($effect [$($rest)*]) };
}

/// Declares the kernels, each as a variant, as a type, and as an arm of [`Kernel::run`].
macro_rules! kernels {
    ($($(#[$doc:meta])* $kernel:ident = $name:literal [$($effect:ident)*];)*) => {
        /// A kernel: code compiled for a set of effects.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Kernel {
            $($(#[$doc])* $kernel,)*
        }

        /// The kernels as types.
        pub mod types {
            use super::{Effects, Off, On};
            $(
                $(#[$doc])*
                #[derive(Debug, Clone, Copy)]
                pub struct $kernel;

                impl Effects for $kernel {
                    type ShadingNormals = switch!(ShadingNormals [$($effect)*]);
                    type Textures = switch!(Textures [$($effect)*]);
                    type NormalMaps = switch!(NormalMaps [$($effect)*]);
                    type Alpha = switch!(Alpha [$($effect)*]);
                    type OneSided = switch!(OneSided [$($effect)*]);
                    type Glossy = switch!(Glossy [$($effect)*]);
                    type Specular = switch!(Specular [$($effect)*]);
                    type Transmission = switch!(Transmission [$($effect)*]);
                    type Lens = switch!(Lens [$($effect)*]);
                    type Motion = switch!(Motion [$($effect)*]);
                    type Environment = switch!(Environment [$($effect)*]);
                    type EnvironmentMap = switch!(EnvironmentMap [$($effect)*]);
                    type DeltaLights = switch!(DeltaLights [$($effect)*]);
                    type AreaLights = switch!(AreaLights [$($effect)*]);
                    type ManyLights = switch!(ManyLights [$($effect)*]);
                    type Instances = switch!(Instances [$($effect)*]);
                    type LightPaths = switch!(LightPaths [$($effect)*]);
                    type Reuse = switch!(Reuse [$($effect)*]);
                }
            )*
        }

        impl Kernel {
            /// Every kernel, the one with every effect last.
            pub const ALL: &'static [Self] = &[$(Self::$kernel),*];

            /// The name in tables, JSON and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kernel => $name,)*
                }
            }

            /// The effects that the kernel is compiled for.
            pub const fn effects(self) -> EffectSet {
                match self {
                    $(Self::$kernel => types::$kernel::SET,)*
                }
            }

            /// Runs a job with the kernel as a type parameter.
            #[doc(hidden)]
            #[inline]
            pub fn run<J: KernelJob>(self, job: J) -> J::Output {
                match self {
                    $(Self::$kernel => job.run::<types::$kernel>(),)*
                }
            }
        }
    };
}

/// A job for a kernel that is known only at run time.
pub trait KernelJob {
    /// The result of the job.
    type Output;
    /// Runs the job with the kernel for the effects `E`.
    fn run<E: Effects>(self) -> Self::Output;
}

kernels! {
    /// Diffuse surfaces, also one-sided, and one area light.
    Matte = "matte" [OneSided AreaLights];
    /// Diffuse surfaces, also one-sided, and one area light, with paths shared by the pixels of a block.
    SharedMatte = "shared-matte" [OneSided AreaLights Reuse];
    /// Diffuse surfaces with textures and shading normals, area lights and a constant environment.
    Textured = "textured" [
        ShadingNormals Textures Environment AreaLights ManyLights
    ];
    /// Diffuse surfaces, mirrors and smooth glass, area lights and a constant environment.
    Specular = "specular" [
        Specular Transmission Environment AreaLights ManyLights
    ];
    /// Any BSDF, area lights and a constant environment.
    Room = "room" [
        ShadingNormals Textures Glossy Specular Transmission Environment AreaLights ManyLights
    ];
    /// Any BSDF, area lights and a constant environment, with light paths.
    Caustics = "caustics" [
        ShadingNormals Textures OneSided Glossy Specular Transmission Environment AreaLights
        ManyLights LightPaths
    ];
    /// Any BSDF, area lights and a constant environment, with paths shared by the pixels of a block.
    Shared = "shared" [
        ShadingNormals Textures OneSided Glossy Specular Transmission Environment AreaLights
        ManyLights Reuse
    ];
    /// Any BSDF, area lights and a constant environment, with a lens, motion and instances.
    Moving = "moving" [
        ShadingNormals Textures Glossy Specular Transmission Lens Motion Environment AreaLights
        ManyLights Instances
    ];
    /// Any material and any light, with a lens.
    Studio = "studio" [
        ShadingNormals Textures NormalMaps Alpha OneSided Glossy Specular Transmission Lens
        Environment EnvironmentMap DeltaLights AreaLights ManyLights
    ];
    /// Any material and any light, with a lens and instances.
    Forest = "forest" [
        ShadingNormals Textures NormalMaps Alpha OneSided Glossy Specular Transmission Lens
        Environment EnvironmentMap DeltaLights AreaLights ManyLights Instances
    ];
    /// Every effect.
    Everything = "everything" [
        ShadingNormals Textures NormalMaps Alpha OneSided Glossy Specular Transmission Lens Motion
        Environment EnvironmentMap DeltaLights AreaLights ManyLights Instances LightPaths Reuse
    ];
}

impl Kernel {
    /// The kernel with the fewest effects that has all of the given ones.
    #[doc(hidden)]
    pub fn smallest_for(effects: EffectSet) -> Self {
        Self::smallest_of(Self::ALL.iter().copied(), effects)
    }

    /// The kernel with the fewest effects, among the given kernels, that has all of the given effects.
    ///
    /// # Panics
    /// If none of them has all.
    #[doc(hidden)]
    pub fn smallest_of(kernels: impl Iterator<Item = Self>, effects: EffectSet) -> Self {
        let fitting = kernels.filter(|k| k.effects().contains(effects));
        fitting
            .min_by_key(|kernel| kernel.effects().len())
            .expect("the last kernel has every effect")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;

    #[test]
    fn every_effect_has_a_kernel_and_the_last_has_all_effects() {
        let last = Kernel::ALL.last().expect("there are kernels");
        assert_eq!(
            (*last, last.effects()),
            (Kernel::Everything, EffectSet::ALL)
        );
        assert_eq!(Kernel::smallest_for(EffectSet::NONE), Kernel::Matte);
        for &kernel in Kernel::ALL {
            assert_eq!(Kernel::smallest_for(kernel.effects()), kernel);
            for effect in Effect::ALL {
                let wanted = EffectSet::NONE.with(effect);
                assert!(Kernel::smallest_for(wanted).effects().has(effect));
            }
        }
    }
}
