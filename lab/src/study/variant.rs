//! What is compared: the settings that are varied, and all combinations of them.
//!
//! Measure: none.
//! Range: each setting is varied once, each value once; what is given again is taken together.
//! Source: none needed. Tested below.

use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::Kernel;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use serde::Serialize;

/// One value of one setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// The estimator.
    Integrator(IntegratorKind),
    /// Where random numbers come from.
    Sampler(SamplerKind),
    /// The library that traces rays.
    Backend(Backend),
    /// How carefully it does.
    Precision(Precision),
    /// The code that runs.
    Kernel(Kernel),
    /// Scattering events at most.
    MaxBounces(Option<u32>),
}

impl Choice {
    /// The name of the setting.
    pub fn setting(self) -> &'static str {
        match self {
            Self::Integrator(_) => "integrator",
            Self::Sampler(_) => "sampler",
            Self::Backend(_) => "backend",
            Self::Precision(_) => "precision",
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
            Self::Kernel(kernel) => format!("kernel {}", kernel.name()),
            Self::MaxBounces(None) => "any bounces".to_owned(),
            Self::MaxBounces(Some(1)) => "1 bounce".to_owned(),
            Self::MaxBounces(Some(limit)) => format!("{limit} bounces"),
        }
    }
}

/// A way to render the scene.
#[derive(Debug, Clone)]
pub struct Variant {
    /// What tells it from the others.
    pub name: String,
    /// How it renders; seed and samples are not its own.
    pub settings: RenderSettings,
    /// How it traces.
    pub options: AccelOptions,
}

impl Variant {
    /// A way that is not varied yet.
    pub fn new(settings: RenderSettings, options: AccelOptions) -> Self {
        Self {
            name: String::new(),
            settings,
            options,
        }
    }

    /// The same with another value of a setting.
    fn with(&self, choice: Choice) -> Self {
        let mut changed = self.clone();
        match choice {
            Choice::Integrator(integrator) => changed.settings.integrator = integrator,
            Choice::Sampler(sampler) => changed.settings.sampler = sampler,
            Choice::Backend(backend) => changed.options.backend = backend,
            Choice::Precision(precision) => changed.options.precision = precision,
            Choice::Kernel(kernel) => changed.settings.kernel = Some(kernel),
            Choice::MaxBounces(limit) => changed.settings.max_bounces = limit,
        }
        if !changed.name.is_empty() {
            changed.name += ", ";
        }
        changed.name += &choice.name();
        changed
    }

    /// All combinations of the choices, those of each setting in the order given; the first setting changes last.
    pub fn all(base: &Self, choices: &[Choice]) -> Vec<Self> {
        let mut settings: Vec<(&str, Vec<Choice>)> = Vec::new();
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

    /// What is written of it.
    pub fn report(&self, bias: Vec<String>) -> VariantReport {
        VariantReport {
            name: self.name.clone(),
            integrator: self.settings.integrator.name(),
            sampler: self.settings.sampler.name(),
            backend: self.options.backend.name(),
            precision: self.options.precision.name(),
            kernel: self.settings.kernel.map(Kernel::name),
            max_bounces: self.settings.max_bounces,
            bias,
        }
    }
}

/// A variant as it is written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VariantReport {
    /// What tells it from the others.
    pub name: String,
    /// The estimator.
    pub integrator: &'static str,
    /// Where random numbers come from.
    pub sampler: &'static str,
    /// The library that traces rays.
    pub backend: &'static str,
    /// How carefully it does.
    pub precision: &'static str,
    /// The code that is forced to run.
    pub kernel: Option<&'static str>,
    /// Scattering events at most.
    pub max_bounces: Option<u32>,
    /// What is known to bias it, in words.
    pub bias: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_there_once() {
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        };
        let base = Variant::new(RenderSettings::new((4, 4), 1), options);
        let names = |choices: &[Choice]| {
            let all = Variant::all(&base, choices);
            all.into_iter().map(|v| v.name).collect::<Vec<_>>()
        };
        let choices = [
            Choice::Integrator(IntegratorKind::Bsdf),
            Choice::MaxBounces(Some(1)),
            Choice::Integrator(IntegratorKind::Path),
            Choice::MaxBounces(None),
            Choice::Integrator(IntegratorKind::Bsdf),
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
