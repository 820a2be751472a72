//! `auto`: the integrator that suits a scene, chosen by what is known of the scene and by a small pilot.
//!
//! The pilot's random numbers are none of the picture's, so that the picture is that of the integrator that is chosen, bit for
//! bit, and as unbiased. The same scene, seed and settings always make the same choice, on any number of threads: nothing is
//! timed.
//!
//! Measure: as in `rule.rs`.
//! Range: any scene. Among `path`, `bdpt` and `mlt`: biased integrators are named, never chosen.
//! Source: docs/accuracy.md, "Which integrator". Tested in `tests/rendering/auto.rs` and `cli/tests/command/auto.rs`.

mod pilot;
mod rule;

use super::settings::Adaptive;
use super::settings::{Budget, RenderSettings};
use super::{RenderInput, RenderObserver, Rendered, Threads, check, resume};
use crate::effects::{Effect, EffectSet};
use crate::error::{ErrorKind, Result};
use crate::film::Window;
use crate::integrator::kind::IntegratorKind;
use crate::sampler::hash;
use crate::scene::Scene;
use pilot::Pilot;
pub use rule::Candidate;
use rule::{Facts, choose};

/// Pixels of the pilot's pictures, about.
const PIXELS: f64 = 5000.0;

/// Samples per pixel of each of them ...
const SPP: u64 = 16;
/// ... and of those by `path`, which are quicker.
const SPP_OF_PATH: u64 = 32;

/// What a pilot's seeds begin with, below that of the picture.
const SEEDS: u64 = 0x0061_7574_6f00;

/// What `auto` stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// Why, in words.
    pub why: String,
    /// What it was held against, itself among them; empty where no pilot was needed.
    pub candidates: Vec<Candidate>,
    /// A biased integrator that may do better, and what it is for.
    pub option: Option<String>,
}

/// The integrator for these settings, whichever they name, by a pilot on these threads. One that `observer` ends leaves `path`.
///
/// # Errors
/// As a render by any of the integrators.
pub fn recommend(
    view: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Recommendation> {
    let kinds = [
        IntegratorKind::Path,
        IntegratorKind::Bidirectional,
        IntegratorKind::Metropolis,
    ];
    let able = kinds.into_iter().filter(|&integrator| {
        let settings = RenderSettings {
            integrator,
            ..settings.clone()
        };
        settings.validate(view.size).is_ok() && check(view.scene, &settings).is_ok()
    });
    let able: Vec<IntegratorKind> = able.collect();
    let effects = view.scene.effects;
    let mut candidates = vec![];
    if able.len() > 1 {
        let pilot_run = PilotRun::new(view, threads, settings, observer);
        match pilot_run.candidates(&able)? {
            Some(measured) => candidates = measured,
            None => return Ok(interrupted()),
        }
    }
    let facts = Facts {
        is_missed_by_path: effects.has(Effect::DeltaLights) && effects.has(Effect::Specular),
        has_smooth_surfaces: effects.has(Effect::Specular),
        candidates,
    };
    let (integrator, why) = choose(&facts);
    Ok(Recommendation {
        integrator,
        why,
        candidates: facts.candidates,
        option: option(effects),
    })
}

/// The settings with an integrator in place of `auto`, and the reason if that was asked for.
///
/// # Errors
/// As [`recommend`].
pub fn settle(
    view: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<(RenderSettings, Option<Recommendation>)> {
    let mut settled = settings.clone();
    if settings.integrator != IntegratorKind::Auto {
        return Ok((settled, None));
    }
    let recommendation = recommend(view, threads, settings, observer)?;
    settled.integrator = recommendation.integrator;
    Ok((settled, Some(recommendation)))
}

/// What is left where nobody waited for the pilot.
fn interrupted() -> Recommendation {
    Recommendation {
        integrator: IntegratorKind::Path,
        why: "the pilot was interrupted".to_owned(),
        candidates: vec![],
        option: None,
    }
}

/// What a biased integrator is worth trying for.
fn option(effects: EffectSet) -> Option<String> {
    let not_matte = [Effect::Glossy, Effect::Specular, Effect::Transmission];
    let is_matte = !not_matte.into_iter().any(|effect| effects.has(effect));
    (is_matte && !effects.has(Effect::Motion)).then(|| {
        "every surface is matte: irradiance-cache may be faster, biased within its --cache-error"
            .to_owned()
    })
}

/// Passes on whether to end, and nothing else.
struct Ended<'a>(&'a dyn RenderObserver);

impl RenderObserver for Ended<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// Where pilots are rendered: the scene on a small film.
struct PilotRun<'a> {
    scene: Scene,
    size: (u32, u32),
    view: &'a RenderInput<'a>,
    threads: &'a Threads,
    settings: &'a RenderSettings,
    observer: &'a dyn RenderObserver,
}

impl<'a> PilotRun<'a> {
    fn new(
        view: &'a RenderInput<'a>,
        threads: &'a Threads,
        settings: &'a RenderSettings,
        observer: &'a dyn RenderObserver,
    ) -> Self {
        let (scene, size) = view.scene.reduced(view.size, PIXELS);
        Self {
            scene,
            size,
            view,
            threads,
            settings,
            observer,
        }
    }

    /// How each of the integrators does; `None` if the observer ended it.
    fn candidates(&self, integrators: &[IntegratorKind]) -> Result<Option<Vec<Candidate>>> {
        let mut pilots = Vec::new();
        for &integrator in integrators {
            pilots.extend(self.pilot(integrator)?);
            if self.observer.is_cancelled() {
                return Ok(None);
            }
        }
        Ok(Some(pilot::inefficiencies(&pilots)))
    }

    /// Two pictures by one integrator; `None` if it found no light to begin with.
    fn pilot(&self, integrator: IntegratorKind) -> Result<Option<Pilot>> {
        let one = |index| -> Result<_> {
            let settings = self.settings_of(integrator, index);
            let view = RenderInput {
                scene: &self.scene,
                size: self.size,
                ..*self.view
            };
            let mut rendered = Rendered::nothing(&settings);
            let observer = Ended(self.observer);
            let until = settings.budget;
            resume(
                &view,
                self.threads,
                &settings,
                until,
                &mut rendered,
                &observer,
            )?;
            Ok((rendered.film.develop(), rendered.rays.total()))
        };
        let pictures = one(0).and_then(|first| one(1).map(|second| [first, second]));
        match pictures {
            Ok([(a, rays_a), (b, rays_b)]) => Ok(Some(Pilot {
                integrator,
                rays: 0.5 * (rays_a + rays_b) as f64,
                pictures: [a, b],
            })),
            Err(error) if error.kind() == ErrorKind::Render => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The settings of a pilot's picture.
    fn settings_of(&self, integrator: IntegratorKind, index: u64) -> RenderSettings {
        let (width, height) = self.size;
        let spp = match integrator {
            IntegratorKind::Path => SPP_OF_PATH,
            _ => SPP,
        };
        RenderSettings {
            integrator,
            seed: hash::combine(self.settings.seed, SEEDS + index),
            budget: Budget::samples(spp),
            adaptive: Adaptive::Off,
            layers: false,
            window: Window {
                x: 0,
                y: 0,
                width,
                height,
            },
            ..self.settings.clone()
        }
    }
}
