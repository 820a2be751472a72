//! The biases of a render by its settings, in words.
//!
//! Measure: none; the error of an irradiance cache is relative.
//! Range: valid settings; an unbiased render has none.
//! Source: docs/architecture.md. Tested below and in `tests/rendering/integrators.rs`.

use super::RenderSettings;
use crate::effects::EffectSet;
use crate::integrator::kind::IntegratorKind;

impl RenderSettings {
    /// The light that the integrator leaves out of the image of a scene with these effects, in words.
    pub fn bias_of_integrator(&self, effects: EffectSet) -> Option<String> {
        self.integrator.bias(self.effects(effects))
    }

    /// The biases of the image of a scene with these effects, in words; empty for an unbiased one.
    pub fn bias(&self, effects: EffectSet) -> Vec<String> {
        let limit = self
            .max_bounces
            .map(|n| format!("max_bounces {n}: light that scatters more often is missing"));
        let integrator = self.bias_of_integrator(effects);
        let is_cached =
            self.integrator == IntegratorKind::IrradianceCache && self.cache_error > 0.0;
        let cache = is_cached.then(|| {
            format!(
                "irradiance-cache: indirect light on matte surfaces is interpolated, with an error of up to about {} % that error bars do not include",
                100.0 * self.cache_error
            )
        });
        let all = [integrator, cache, self.adaptive.bias(), limit];
        all.into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounce_limit_is_reported_as_bias() {
        let mut settings = RenderSettings::new((8, 4), 1);
        assert!(settings.bias(EffectSet::NONE).is_empty());
        settings.max_bounces = Some(3);
        assert!(settings.bias(EffectSet::NONE)[0].contains("max_bounces 3"));
    }
}
