//! One sample once more, with every vertex of its path written down.
//!
//! Measure: positions in world units.
//! Range: any pixel and sample; the value is bit for bit that of the render with the same settings.
//! Source: pbrt's way of tracking a bad sample down. Tested in `tests/command.rs`.

use super::dispatch;
use super::settings::{RenderSettings, SamplerKind};
use super::tile::CameraSample;
use crate::bsdf::types::Lobe;
use crate::film::filter::Filter;
use crate::integrator::RayCounts;
use crate::integrator::observer::PathObserver;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::sampler::{Independent, Sampler, Sobol};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// One thing that happened to a path.
#[derive(Debug, Clone, PartialEq)]
pub enum PathEvent {
    /// It came to a surface.
    Arrived {
        /// Where, in world units.
        position: DVec3,
        /// The shape's index.
        shape: u32,
        /// The primitive's index.
        primitive: u32,
        /// The geometric normal.
        normal: Vec3,
        /// Throughput on arrival.
        beta: Rgb,
    },
    /// It left the scene.
    Escaped {
        /// Along this unit vector.
        direction: Vec3,
    },
    /// Emission found by scattering.
    Emission {
        /// What it added.
        contribution: Rgb,
        /// Its weight against light sampling.
        weight: f32,
    },
    /// Light found by sampling.
    Light {
        /// What it adds if it is visible.
        contribution: Rgb,
        /// Its weight against scattering.
        weight: f32,
        /// Whether nothing was in the way.
        visible: bool,
    },
    /// It was scattered.
    Scattered {
        /// Along this unit vector.
        direction: Vec3,
        /// How.
        lobe: Lobe,
        /// Throughput afterwards.
        beta: Rgb,
    },
    /// It ended by roulette.
    Terminated {
        /// The probability with which it would have gone on.
        survival: f32,
    },
}

/// A replayed sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// Its value, as the film gets it.
    pub radiance: Rgb,
    /// What happened, in order.
    pub events: Vec<PathEvent>,
}

/// Replays one sample of one pixel.
pub fn replay(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    pixel: [u32; 2],
    sample: u64,
) -> Replay {
    let camera_sample = CameraSample {
        scene,
        filter,
        pixel,
    };
    let mut recorder = Recorder {
        scene,
        events: Vec::new(),
    };
    let radiance = match settings.sampler {
        SamplerKind::Independent => recorder.record(
            &camera_sample,
            settings,
            Independent::new(settings.seed),
            sample,
        ),
        SamplerKind::Sobol => {
            recorder.record(&camera_sample, settings, Sobol::new(settings.seed), sample)
        }
    };
    Replay {
        radiance,
        events: recorder.events,
    }
}

struct Recorder<'a> {
    scene: &'a Scene,
    events: Vec<PathEvent>,
}

impl Recorder<'_> {
    fn record<S: Sampler>(
        &mut self,
        camera_sample: &CameraSample<'_>,
        settings: &RenderSettings,
        mut sampler: S,
        sample: u64,
    ) -> Rgb {
        sampler.start(camera_sample.pixel, sample);
        let integrator = dispatch::integrator(settings);
        camera_sample.radiance(integrator, &mut sampler, &mut RayCounts::default(), self)
    }
}

impl PathObserver for Recorder<'_> {
    fn arrived(&mut self, at: &Interaction, beta: Rgb) {
        self.events.push(PathEvent::Arrived {
            position: self.scene.normalisation.world_point(at.p),
            shape: at.id.geometry,
            primitive: at.id.primitive,
            normal: at.ng,
            beta,
        });
    }

    fn escaped(&mut self, direction: Vec3) {
        self.events.push(PathEvent::Escaped { direction });
    }

    fn emission(&mut self, contribution: Rgb, weight: f32) {
        self.events.push(PathEvent::Emission {
            contribution,
            weight,
        });
    }

    fn light(&mut self, contribution: Rgb, weight: f32, visible: bool) {
        self.events.push(PathEvent::Light {
            contribution,
            weight,
            visible,
        });
    }

    fn scattered(&mut self, direction: Vec3, lobe: Lobe, beta: Rgb) {
        self.events.push(PathEvent::Scattered {
            direction,
            lobe,
            beta,
        });
    }

    fn terminated(&mut self, survival: f32) {
        self.events.push(PathEvent::Terminated { survival });
    }
}
