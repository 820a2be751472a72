//! The variants of a study: the settings that are varied, and all combinations of them.
//!
//! Measure: none.
//! Range: each setting is varied once, each value once; repetitions are merged.
//! Source: none needed. Tested below.

use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::Kernel;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::{
    LightPathRule, PathReuseRule, RenderSettings, SamplerKind,
};
use serde::Serialize;

/// One value of one setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingValue {
    /// The integrator.
    Integrator(IntegratorKind),
    /// The sampler.
    Sampler(SamplerKind),
    /// The backend that traces rays.
    Backend(Backend),
    /// The precision of its intersections.
    Precision(Precision),
    /// The number of light paths beside those of `path`.
    LightPaths(LightPathRule),
    /// The number of pixels that share their paths.
    Reuse(PathReuseRule),
    /// The kernel.
    Kernel(Kernel),
    /// Maximum number of scattering events.
    MaxBounces(Option<u32>),
}

impl SettingValue {
    /// The name of the setting.
    pub fn setting(self) -> &'static str {
        match self {
            Self::Integrator(_) => "integrator",
            Self::Sampler(_) => "sampler",
            Self::Backend(_) => "backend",
            Self::Precision(_) => "precision",
            Self::LightPaths(_) => "light-paths",
            Self::Reuse(_) => "reuse",
            Self::Kernel(_) => "kernel",
            Self::MaxBounces(_) => "max-bounces",
        }
    }

    /// The value in the name of a variant.
    fn name(self) -> String {
        match self {
            Self::Integrator(integrator) => integrator.name().to_owned(),
            Self::Sampler(sampler) => sampler.name().to_owned(),
            Self::Backend(backend) => backend.name().to_owned(),
            Self::Precision(precision) => precision.name().to_owned(),
            Self::LightPaths(rule) => format!("light paths {}", rule.name()),
            Self::Reuse(rule) => format!("reuse {}", rule.name()),
            Self::Kernel(kernel) => format!("kernel {}", kernel.name()),
            Self::MaxBounces(None) => "any bounces".to_owned(),
            Self::MaxBounces(Some(1)) => "1 bounce".to_owned(),
            Self::MaxBounces(Some(limit)) => format!("{limit} bounces"),
        }
    }
}

/// A variant of the settings for rendering the scene.
#[derive(Debug, Clone)]
pub struct Variant {
    /// A name that distinguishes it from the others.
    pub name: String,
    /// Render settings; the study sets seed and samples.
    pub settings: RenderSettings,
    /// Options of the acceleration structure.
    pub options: AccelOptions,
}

impl Variant {
    /// A variant in which no setting is varied yet.
    pub fn new(settings: RenderSettings, options: AccelOptions) -> Self {
        Self {
            name: String::new(),
            settings,
            options,
        }
    }

    /// Changes a setting to another value.
    fn with(&self, choice: SettingValue) -> Self {
        let mut changed = self.clone();
        match choice {
            SettingValue::Integrator(integrator) => changed.settings.integrator = integrator,
            SettingValue::Sampler(sampler) => changed.settings.sampler = sampler,
            SettingValue::Backend(backend) => changed.options.backend = backend,
            SettingValue::Precision(precision) => changed.options.precision = precision,
            SettingValue::LightPaths(rule) => changed.settings.light_paths = rule,
            SettingValue::Reuse(rule) => changed.settings.reuse = rule,
            SettingValue::Kernel(kernel) => changed.settings.kernel = Some(kernel),
            SettingValue::MaxBounces(limit) => changed.settings.max_bounces = limit,
        }
        if !changed.name.is_empty() {
            changed.name += ", ";
        }
        changed.name += &choice.name();
        changed
    }

    /// All combinations of the choices, those of each setting in the order given; the first setting changes last.
    pub fn all(base: &Self, choices: &[SettingValue]) -> Vec<Self> {
        let mut settings: Vec<(&str, Vec<SettingValue>)> = Vec::new();
        for &choice in choices {
            let name = choice.setting();
            match settings.iter_mut().find(|(known, _)| *known == name) {
                Some((_, values)) if values.contains(&choice) => {}
                Some((_, values)) => values.push(choice),
                None => settings.push((name, vec![choice])),
            }
        }
        let mut all = vec![base.clone()];
        for (_, values) in &settings {
            let vary = |one: &Self| values.iter().map(|&v| one.with(v)).collect::<Vec<_>>();
            all = all.iter().flat_map(vary).collect();
        }
        if let [only] = all.as_mut_slice()
            && only.name.is_empty()
        {
            only.name = only.settings.integrator.name().to_owned();
        }
        all
    }

    /// The reason why a render of this variant has no effect of one of these choices, if there is one: the variant would
    /// have the name of one render and the image of another.
    pub fn contradiction(&self, choices: &[SettingValue]) -> Option<&'static str> {
        let settings = &self.settings;
        let is_varied = |setting: &str| choices.iter().any(|choice| choice.setting() == setting);
        let lacks_light_paths = matches!(settings.light_paths,
            LightPathRule::Share(share) if share != settings.light_path_share());
        if is_varied("light-paths") && lacks_light_paths {
            return Some("only path has light paths beside camera paths");
        }
        let lacks_reuse = matches!(settings.reuse,
            PathReuseRule::Pixels(reuse) if reuse != settings.reuse());
        (is_varied("reuse") && lacks_reuse)
            .then_some("only path shares paths between pixels, and only without light paths")
    }

    /// The variant as written to the report.
    pub fn report(&self, bias: Vec<String>) -> VariantReport {
        VariantReport {
            name: self.name.clone(),
            integrator: self.settings.integrator.name(),
            sampler: self.settings.sampler.name(),
            backend: self.options.backend.name(),
            precision: self.options.precision.name(),
            light_paths: self.settings.light_path_share().name(),
            reuse: self.settings.reuse().name(),
            kernel: self.settings.kernel.map(Kernel::name),
            max_bounces: self.settings.max_bounces,
            bias,
        }
    }
}

/// A variant as written to the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VariantReport {
    /// A name that distinguishes it from the others.
    pub name: String,
    /// The integrator.
    pub integrator: &'static str,
    /// The sampler.
    pub sampler: &'static str,
    /// The backend that traces rays.
    pub backend: &'static str,
    /// The precision of its intersections.
    pub precision: &'static str,
    /// Light paths for each camera path.
    pub light_paths: &'static str,
    /// The number of pixels that share their paths.
    pub reuse: &'static str,
    /// The kernel, if it is forced.
    pub kernel: Option<&'static str>,
    /// Maximum number of scattering events.
    pub max_bounces: Option<u32>,
    /// Known sources of bias, in words.
    pub bias: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::integrator::light_paths::LightPathShare;
    use etendue::internals::integrator::reuse::PathReuse;

    fn base() -> Variant {
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        };
        Variant::new(RenderSettings::new((4, 4), 1), options)
    }

    #[test]
    fn combinations_without_the_effect_of_a_choice_are_contradictions() {
        let mut base = base();
        let paths = |share| SettingValue::LightPaths(LightPathRule::Share(share));
        let pixels = |reuse| SettingValue::Reuse(PathReuseRule::Pixels(reuse));
        let choices = [
            SettingValue::Integrator(IntegratorKind::Path),
            SettingValue::Integrator(IntegratorKind::Bidirectional),
            paths(LightPathShare::None),
            paths(LightPathShare::One),
            pixels(PathReuse::Off),
            pixels(PathReuse::Sixteen),
        ];
        let all = Variant::all(&base, &choices);
        assert_eq!(all.len(), 8);
        let kept = all.iter().filter(|v| v.contradiction(&choices).is_none());
        let kept: Vec<&str> = kept.map(|variant| variant.name.as_str()).collect();
        let expected = [
            "path, light paths off, reuse off",
            "path, light paths off, reuse 16",
            "path, light paths 1, reuse off",
            "bdpt, light paths off, reuse off",
        ];
        assert_eq!(kept, expected);

        base.settings.light_paths = LightPathRule::Share(LightPathShare::One);
        let by_bdpt = &Variant::all(&base, &choices[1..2])[0];
        assert_eq!(by_bdpt.contradiction(&choices[1..2]), None, "the scene's");
    }

    #[test]
    fn every_combination_of_choices_occurs_once() {
        let base = base();
        let names = |choices: &[SettingValue]| {
            let all = Variant::all(&base, choices);
            all.into_iter().map(|v| v.name).collect::<Vec<_>>()
        };
        let choices = [
            SettingValue::Integrator(IntegratorKind::Bsdf),
            SettingValue::MaxBounces(Some(1)),
            SettingValue::Integrator(IntegratorKind::Path),
            SettingValue::MaxBounces(None),
            SettingValue::Integrator(IntegratorKind::Bsdf),
        ];
        let expected = [
            "bsdf, 1 bounce",
            "bsdf, any bounces",
            "path, 1 bounce",
            "path, any bounces",
        ];
        assert_eq!(names(&choices), expected);
        assert_eq!(names(&[]), ["path"]);
        let varied = Variant::all(&base, &choices);
        assert_eq!(varied[0].settings.max_bounces, Some(1));
        assert_eq!(varied[1].settings.integrator, IntegratorKind::Bsdf);
    }
}
