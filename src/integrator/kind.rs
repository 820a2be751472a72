//! The integrators by name, and the properties of each.
//!
//! Measure: none.
//! Range: every integrator.
//! Source: the names of the course. Tested in `tests/rendering/integrators.rs` and `cli/tests/command/render.rs`.

use super::roulette::{Roulette, WeightWindow};
use super::technique::Technique;
use crate::effects::{Effect, EffectSet};
use crate::light::types::LightChoice;
use serde::Serialize;

/// An integrator, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[non_exhaustive]
pub enum IntegratorKind {
    /// Path tracing with uniform directions, where emission or scattering is chosen with probability 1/2.
    Naive,
    /// Path tracing with uniform directions, where the choice depends on whether the surface emits.
    EmitOrReflect,
    /// Path tracing with BSDF sampling alone.
    Bsdf,
    /// Path tracing with one ray to a sampled light, and one uniform direction for all other lights.
    LightOrRest,
    /// Next event estimation without multiple importance sampling.
    NextEvent,
    /// Path tracing with next event estimation and multiple importance sampling.
    #[default]
    Path,
    /// Path tracing with indirect light from an irradiance cache.
    IrradianceCache,
    /// Direct light by uniform directions.
    DirectDirectional,
    /// Direct light by uniform points on the lights.
    DirectArea,
    /// Bidirectional path tracing.
    Bidirectional,
    /// Metropolis light transport, over bidirectional path tracing.
    Metropolis,
    /// Ambient occlusion.
    AmbientOcclusion,
    /// The unbiased integrator that suits the scene: `render/auto/` chooses it before anything is rendered.
    Auto,
}

impl IntegratorKind {
    /// Every integrator: the path tracers of the course from the first to the last, then those that are not path
    /// tracers, then `auto`, which stands for one of them.
    pub const ALL: &'static [Self] = &[
        Self::Naive,
        Self::EmitOrReflect,
        Self::Bsdf,
        Self::LightOrRest,
        Self::NextEvent,
        Self::Path,
        Self::IrradianceCache,
        Self::DirectDirectional,
        Self::DirectArea,
        Self::Bidirectional,
        Self::Metropolis,
        Self::AmbientOcclusion,
        Self::Auto,
    ];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Naive => "naive",
            Self::EmitOrReflect => "emit-or-reflect",
            Self::Bsdf => "bsdf",
            Self::LightOrRest => "light-or-rest",
            Self::NextEvent => "nee",
            Self::Path => "path",
            Self::IrradianceCache => "irradiance-cache",
            Self::DirectDirectional => "direct-directional",
            Self::DirectArea => "direct-area",
            Self::Bidirectional => "bdpt",
            Self::Metropolis => "mlt",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::Auto => "auto",
        }
    }

    /// The technique by which light is found; `None` for an integrator that is not a path tracer.
    pub fn technique(self) -> Option<Technique> {
        match self {
            Self::Naive => Some(Technique::NAIVE),
            Self::EmitOrReflect => Some(Technique::EMIT_OR_REFLECT),
            Self::Bsdf => Some(Technique::BSDF),
            Self::LightOrRest => Some(Technique::LIGHT_OR_REST),
            Self::NextEvent => Some(Technique::NEXT_EVENT),
            Self::Path | Self::IrradianceCache => Some(Technique::PATH),
            Self::DirectDirectional => Some(Technique::DIRECT_DIRECTIONAL),
            Self::DirectArea => Some(Technique::DIRECT_AREA),
            Self::Bidirectional | Self::Metropolis | Self::AmbientOcclusion | Self::Auto => None,
        }
    }

    /// The default rule of Russian roulette. The paths of the first path tracer end by its own random choice alone, and
    /// paths that scatter once gain nothing from roulette.
    pub fn roulette(self) -> Roulette {
        match self {
            Self::Naive | Self::DirectDirectional | Self::DirectArea | Self::AmbientOcclusion => {
                Roulette::None
            }
            Self::EmitOrReflect
            | Self::Bsdf
            | Self::LightOrRest
            | Self::NextEvent
            | Self::Bidirectional
            | Self::Metropolis
            | Self::Auto => Roulette::Throughput,
            Self::Path | Self::IrradianceCache => Roulette::Window(WeightWindow::default()),
        }
    }

    /// The default selection of lights: by power in the path tracers of the course before the last.
    pub fn light_choice(self) -> LightChoice {
        match self {
            Self::LightOrRest | Self::NextEvent | Self::DirectArea => LightChoice::Power,
            _ => LightChoice::Contribution,
        }
    }

    /// Whether samples contribute to other pixels, too, by splats.
    pub fn splats(self) -> bool {
        matches!(self, Self::Bidirectional | Self::Metropolis)
    }

    /// The largest number of scattering events, for integrators of direct light only.
    pub fn bounce_limit(self) -> Option<u32> {
        match self {
            Self::DirectDirectional | Self::DirectArea => Some(1),
            _ => None,
        }
    }

    /// The light that is missing from the image of a scene with these effects, in words.
    pub fn bias(self, effects: EffectSet) -> Option<String> {
        let name = self.name();
        if self == Self::AmbientOcclusion {
            return Some(format!("{name}: the image shows no light"));
        }
        let technique = self.technique().unwrap_or(Technique::PATH);
        let mut lacks = Vec::new();
        if self.bounce_limit().is_some() {
            lacks.push("light that scatters more than once is missing");
        }
        if effects.has(Effect::DeltaLights) && !technique.samples_lights() {
            lacks.push(
                "scattered rays cannot hit point, spot and distant lights, whose light is missing",
            );
        }
        // Delta lights are found only by light sampling, which cannot go by way of a delta lobe, and by light paths.
        let has_both = effects.has(Effect::DeltaLights) && effects.has(Effect::Specular);
        if has_both && technique.samples_lights() && self.bounce_limit().is_none() {
            lacks.push(if self.splats() || effects.has(Effect::LightPaths) {
                "caustics of point, spot and distant lights that are seen in mirrors or through smooth glass are missing"
            } else {
                "caustics of point, spot and distant lights, by mirrors and smooth glass on other surfaces, are missing"
            });
        }
        (!lacks.is_empty()).then(|| format!("{name}: {}", lacks.join("; ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row 56 of docs/hard-cases.md: where no technique finds a class of paths, error bars do not show it.
    #[test]
    fn missing_specular_paths_from_delta_lights_are_reported() {
        let lights = EffectSet::NONE.with(Effect::DeltaLights);
        let both = lights.with(Effect::Specular);
        for &integrator in IntegratorKind::ALL {
            let lacks = |effects| {
                let bias = integrator.bias(effects).unwrap_or_default();
                bias.matches("mirrors").count() > 0
            };
            let technique = integrator.technique().unwrap_or(Technique::PATH);
            let finds_lights = technique.samples_lights() && integrator.bounce_limit().is_none();
            let is_transport = integrator != IntegratorKind::AmbientOcclusion;
            assert_eq!(lacks(both), finds_lights && is_transport, "{integrator:?}");
            assert!(!lacks(lights) && !lacks(EffectSet::NONE.with(Effect::Specular)));
        }
        let [path, bidirectional] = [IntegratorKind::Path, IntegratorKind::Bidirectional]
            .map(|kind| kind.bias(both).expect("both lack some"));
        assert!(path.contains("on other surfaces") && bidirectional.contains("seen in mirrors"));
        let with_light_paths = IntegratorKind::Path.bias(both.with(Effect::LightPaths));
        assert!(with_light_paths.is_some_and(|it| it.contains("seen in mirrors")));
    }
}
