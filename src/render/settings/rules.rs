//! The rules by which the rest of a render follows from its settings: the border size of its filter, its light paths, the
//! compensation of environment maps, roulette, and the rounding of sample counts.
//!
//! Measure: pixels, samples per pixel.
//! Range: valid settings.
//! Source: docs/architecture.md. Tested below, in `tests/rendering/filters.rs` and `tests/rendering/light_paths.rs`.

use super::{Adaptive, LightPathRule, PathReuseRule, RenderSettings};
use crate::effects::{Effect, EffectSet};
use crate::film::FilmLayout;
use crate::film::batches::BATCHES;
use crate::film::filter::{Filter, FilterSampling};
use crate::film::footprint::Footprint;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::light_paths::LightPathShare;
use crate::integrator::reuse::PathReuse;
use crate::light::types::{EnvironmentSampling, LightChoice};
use crate::planted::planted;

impl RenderSettings {
    /// The number of pixels on either side of its own to which a sample contributes by this filter; 0 if it belongs to its own
    /// alone. That is so for filters without a footprint; for adaptive renders, whose pixels differ in the count that a
    /// sample's weight is divided by; and for Markov chains, all of whose samples are splats.
    pub fn border_size(&self, filter: &Filter) -> u32 {
        let is_splatted = self.filter_sampling == FilterSampling::Splatting
            && self.adaptive == Adaptive::Off
            && self.integrator != IntegratorKind::Metropolis;
        let footprint = filter.footprint().filter(|_| is_splatted);
        footprint.map_or(0, Footprint::border_size)
    }

    /// The layout of the film of a render with this filter.
    pub fn film_layout(&self, filter: &Filter) -> FilmLayout {
        FilmLayout {
            window: self.window,
            tile_size: self.tile_size,
            border_size: self.border_size(filter),
            has_splats: self.splats(),
            has_counts: self.adaptive != Adaptive::Off,
        }
    }

    /// The estimator of this filter that a render has.
    pub fn filter_sampling_of(&self, filter: &Filter) -> FilterSampling {
        match self.border_size(filter) {
            0 => FilterSampling::Importance,
            _ => FilterSampling::Splatting,
        }
    }

    /// The largest number of scattering events, by these settings and by the integrator.
    pub fn bounce_limit(&self) -> Option<u32> {
        let limits = [self.max_bounces, self.integrator.bounce_limit()];
        limits.into_iter().flatten().min()
    }

    /// The step of sample counts: the number of batches where each needs equally many samples, otherwise 1.
    pub fn spp_step(&self) -> u64 {
        let in_whole_rounds = self.layers
            || self.budget.error.is_some()
            || self.adaptive != Adaptive::Off
            || self.integrator == IntegratorKind::Metropolis;
        match in_whole_rounds {
            true => BATCHES,
            false => 1,
        }
    }

    /// The number of samples over which a pixel's strata are spread, if it is known: in adaptive renders, where counts
    /// differ, that of the pilot, whose strata are repeated.
    pub fn samples_of_strata(&self) -> Option<u64> {
        match self.adaptive {
            Adaptive::Off => self.budget.spp,
            Adaptive::TwoPhase | Adaptive::Greedy => Some(self.budget.pilot()),
        }
    }

    /// The rule of Russian roulette.
    pub fn roulette(&self) -> Roulette {
        self.roulette.unwrap_or(self.integrator.roulette())
    }

    /// The selection of lights.
    pub fn light_choice(&self) -> LightChoice {
        self.light_choice.unwrap_or(self.integrator.light_choice())
    }

    /// The number of light paths for each camera path: none but beside `path`, none where each pixel stops by its own error, and
    /// none by `auto`, which has to be replaced before a scene is rendered (`render/auto/`).
    pub fn light_path_share(&self) -> LightPathShare {
        self.light_path_rule().share()
    }

    /// The rule of light paths, with the number of [`light_path_share`](Self::light_path_share).
    pub fn light_path_rule(&self) -> LightPathRule {
        let may_have = self.integrator == IntegratorKind::Path && self.adaptive != Adaptive::Greedy;
        match self.light_paths {
            LightPathRule::Share(_) | LightPathRule::Caustics(_) if may_have => self.light_paths,
            _ => LightPathRule::OFF,
        }
    }

    /// The settings with a rule of light paths in place of `auto`: with none, if none was chosen.
    pub fn with_light_paths(&self, chosen: Option<LightPathRule>) -> Self {
        let mut settings = self.clone();
        if settings.light_paths == LightPathRule::Auto {
            settings.light_paths = chosen.unwrap_or(LightPathRule::OFF);
        }
        settings
    }

    /// The number of pixels that share their paths: one but by `path` with equal sample counts and without light paths,
    /// whose weights take each path as its own pixel's. Where a number is asked for, `--light-paths auto` has none. One by
    /// `auto`, which has to be replaced before a scene is rendered (`render/auto/`).
    pub fn reuse(&self) -> PathReuse {
        let may_share = self.integrator == IntegratorKind::Path
            && self.adaptive == Adaptive::Off
            && self.light_path_share() == LightPathShare::None;
        match self.reuse {
            PathReuseRule::Pixels(reuse) if may_share => reuse,
            _ => PathReuse::Off,
        }
    }

    /// The settings with a number of pixels that share their paths in place of `auto`: with one, if none was chosen.
    pub fn with_reuse(&self, chosen: Option<PathReuse>) -> Self {
        let mut settings = self.clone();
        if settings.reuse == PathReuseRule::Auto {
            settings.reuse = PathReuseRule::Pixels(chosen.unwrap_or_default());
        }
        settings
    }

    /// The settings for a render with layers by default: those who read layers take the noise of pixels as independent, so that
    /// each pixel has its own samples and paths.
    pub fn with_layers(&self) -> Self {
        Self {
            layers: true,
            filter_sampling: FilterSampling::Importance,
            reuse: PathReuseRule::Pixels(PathReuse::Off),
            ..self.clone()
        }
    }

    /// The effects that a render of a scene with these effects needs.
    pub fn effects(&self, of_scene: EffectSet) -> EffectSet {
        let has_light_paths = self.light_path_share() != LightPathShare::None;
        of_scene
            .without(Effect::LightPaths)
            .without(Effect::Reuse)
            .with_if(Effect::LightPaths, has_light_paths)
            .with_if(Effect::Reuse, self.reuse().is_on())
    }

    /// Whether samples contribute to other pixels, too, by splats.
    pub fn splats(&self) -> bool {
        self.integrator.splats() || self.light_path_share() != LightPathShare::None
    }

    /// The density of directions to an environment map: compensated where BSDF sampling finds all of its light, too.
    pub fn environment_sampling(&self) -> EnvironmentSampling {
        let has_both = self.integrator == IntegratorKind::Path;
        if planted!("compensated-alone", true, has_both) {
            EnvironmentSampling::Compensated
        } else {
            EnvironmentSampling::Radiance
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elsewhere no other technique, or only a cache, finds what a compensated density leaves out.
    #[test]
    fn mis_compensation_is_used_by_the_path_integrator_only() {
        for &integrator in IntegratorKind::ALL {
            let settings = RenderSettings {
                integrator,
                ..RenderSettings::new((1, 1), 1)
            };
            let is_compensated =
                settings.environment_sampling() == EnvironmentSampling::Compensated;
            assert_eq!(is_compensated, integrator == IntegratorKind::Path);
        }
    }
}
