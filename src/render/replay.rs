//! One sample once more, with every vertex of its path written down.
//!
//! Measure: positions in world units.
//! Range: any pixel and sample; the value is bit for bit that of the render with the same settings.
//! Source: pbrt's way of tracking a bad sample down. Tested in `cli/tests/command/render.rs`.

use super::camera_rays::{CameraRays, Pixel};
use super::dispatch::{self, Dispatched};
use super::overture::overture;
use super::settings::RenderSettings;
use crate::bsdf::types::Lobe;
use crate::effects::Effects;
use crate::error::Result;
use crate::film::filter::Filter;
use crate::film::splats::NoSplats;
use crate::integrator::Integrator;
use crate::integrator::observer::PathObserver;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// One thing that happened to a path.
#[derive(Debug, Clone, PartialEq)]
pub enum PathEvent {
    /// It came to a surface.
    Arrived {
        /// Where, in world units.
        position: DVec3,
        /// The shape's number, see [`Scene::described`].
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
        /// The share of it that nothing is in the way of.
        visible: f32,
    },
    /// Indirect light that a cache knows, which ended the path.
    Known {
        /// What it added.
        contribution: Rgb,
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
///
/// # Errors
/// Settings with which the scene cannot be rendered.
pub fn replay(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    pixel: [u32; 2],
    sample: u64,
) -> Result<Replay> {
    dispatch::check(scene, settings)?;
    let (cache, _) = overture(scene, filter, settings, &|_, _| true);
    let pixel = Pixel {
        scene,
        filter,
        position: pixel,
    };
    let mut recorder = Recorder {
        scene,
        events: Vec::new(),
    };
    let job = ReplayJob {
        pixel,
        sample,
        recorder: &mut recorder,
    };
    let radiance = dispatch::dispatch(scene, settings, cache.as_ref(), job);
    Ok(Replay {
        radiance,
        events: recorder.events,
    })
}

struct Recorder<'a> {
    scene: &'a Scene,
    events: Vec<PathEvent>,
}

struct ReplayJob<'a, 'b> {
    pixel: Pixel<'a>,
    sample: u64,
    recorder: &'a mut Recorder<'b>,
}

impl Dispatched for ReplayJob<'_, '_> {
    type Output = Rgb;

    fn run<E: Effects, S: Sampler, I: Integrator>(self, integrator: I, sampler: S) -> Rgb {
        let mut camera_rays = CameraRays::new();
        let only = self.sample..self.sample + 1;
        let places = camera_rays.add::<E, _>(&self.pixel, &sampler, only, self.recorder);
        let (scene, place, splats) = (self.pixel.scene, places.start, &mut NoSplats);
        camera_rays.trace(scene);
        camera_rays.estimate::<E, I, _, _>(places, scene, integrator, self.recorder, splats);
        camera_rays.value(place)
    }
}

impl PathObserver for Recorder<'_> {
    fn arrived<E: Effects>(&mut self, at: &Interaction<E>, beta: Rgb) {
        self.events.push(PathEvent::Arrived {
            position: self.scene.normalisation.world_point(at.p),
            shape: at.id.shape,
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

    fn light(&mut self, contribution: Rgb, weight: f32, visible: f32) {
        self.events.push(PathEvent::Light {
            contribution,
            weight,
            visible,
        });
    }

    fn known(&mut self, contribution: Rgb) {
        self.events.push(PathEvent::Known { contribution });
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
