//! One sample once more, with every vertex of its path written down.
//!
//! Measure: positions in world units.
//! Range: any pixel and sample; the value is bit for bit that of the render with the same settings.
//! Source: pbrt's way of tracking a bad sample down. Tested in `cli/tests/command/render.rs`.

use super::cache_prepass::cache_prepass;
use super::dispatch;
use super::observed::observe_tile;
use super::settings::RenderSettings;
use crate::bsdf::types::Lobe;
use crate::error::Result;
use crate::film::filter::Filter;
use crate::film::{Film, Window};
use crate::integrator::observer::{PathObserver, PathVertex};
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::scene::Scene;

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
    let (cache, _) = cache_prepass(scene, filter, settings, &|_, _| true);
    let [x, y] = pixel;
    let window = Window {
        x,
        y,
        width: 1,
        height: 1,
    };
    let mut film = Film::new(window, 1);
    let mut recorder = Recorder {
        scene,
        events: Vec::new(),
        radiance: Rgb::BLACK,
    };
    for tile in film.tiles_mut() {
        let only = sample..sample + 1;
        let cache = cache.as_ref();
        observe_tile(scene, filter, settings, cache, tile, only, &mut recorder);
    }
    Ok(Replay {
        radiance: recorder.radiance,
        events: recorder.events,
    })
}

struct Recorder<'a> {
    scene: &'a Scene,
    events: Vec<PathEvent>,
    radiance: Rgb,
}

impl PathObserver for Recorder<'_> {
    fn arrived(&mut self, at: &PathVertex, beta: Rgb) {
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

    fn cached_indirect(&mut self, contribution: Rgb) {
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

    fn filmed(&mut self, value: Rgb) {
        self.radiance = value;
    }
}
