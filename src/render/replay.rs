//! The replay of one sample, with every vertex of its path recorded.
//!
//! Measure: positions in world units.
//! Range: any pixel and sample, the pixel as the source of the sample; the value is bit for bit that of the render with
//! the same settings.
//! Source: pbrt's method of debugging a bad sample. Tested in `cli/tests/command/render.rs`.

use super::cache_prepass::cache_prepass;
use super::dispatch;
use super::observed::observe_tile;
use super::settings::{PathReuseRule, RenderSettings};
use crate::bsdf::types::Lobe;
use crate::error::Result;
use crate::film::filter::Filter;
use crate::film::splatted::Splatted;
use crate::film::{Film, Window};
use crate::integrator::observer::{PathObserver, PathVertex};
use crate::integrator::reuse::PathReuse;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::scene::Scene;

/// An event on a path.
#[derive(Debug, Clone, PartialEq)]
pub enum PathEvent {
    /// The path arrived at a surface.
    Arrived {
        /// The position, in world units.
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
    /// The path left the scene.
    Escaped {
        /// The unit vector of its direction.
        direction: Vec3,
    },
    /// Emission found by scattering.
    Emission {
        /// The contribution.
        contribution: Rgb,
        /// The MIS weight against light sampling.
        weight: f32,
    },
    /// Light found by light sampling.
    Light {
        /// The contribution if the light is visible.
        contribution: Rgb,
        /// The MIS weight against scattering.
        weight: f32,
        /// The visible share of the light.
        visible: f32,
    },
    /// Indirect light from a cache, which ended the path.
    CachedIndirect {
        /// The contribution.
        contribution: Rgb,
    },
    /// The path was scattered.
    Scattered {
        /// The unit vector of the new direction.
        direction: Vec3,
        /// The lobe.
        lobe: Lobe,
        /// The throughput afterwards.
        beta: Rgb,
    },
    /// The path ended by Russian roulette.
    Terminated {
        /// The survival probability.
        survival: f32,
    },
}

/// A replayed sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// The value of the sample: radiance, times the filter weight if its position is sampled from the filter. Where it
    /// contributes to several pixels, each has a weight of its own.
    pub radiance: Rgb,
    /// The events of the pixel's own path, in order.
    pub events: Vec<PathEvent>,
    /// The value of its own path alone, where the pixel shares paths with others.
    pub alone: Option<Rgb>,
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
    let observe = |settings: &RenderSettings, observer: &mut dyn PathObserver| {
        let border_size = settings.border_size(filter);
        let mut film = Film::new(window, 1).with_border(border_size);
        for tile in film.tiles_mut() {
            if border_size > 0 {
                // At the edge of a film the pixels beyond it are sources, too.
                tile.splatted = Some(Splatted::new(tile.window, border_size));
            }
            let only = sample..sample + 1;
            observe_tile(
                scene,
                filter,
                settings,
                cache.as_ref(),
                tile,
                only,
                observer,
            );
        }
    };
    let mut recorder = EventRecorder {
        scene,
        events: Vec::new(),
        radiance: Rgb::BLACK,
    };
    let alone = RenderSettings {
        reuse: PathReuseRule::Pixels(PathReuse::Off),
        ..settings.clone()
    };
    observe(&alone, &mut recorder);
    let EventRecorder {
        events, radiance, ..
    } = recorder;
    if !settings.reuse().is_on() {
        return Ok(Replay {
            radiance,
            events,
            alone: None,
        });
    }
    let mut last = SampleValue(Rgb::BLACK);
    observe(settings, &mut last);
    Ok(Replay {
        radiance: last.0,
        events,
        alone: Some(radiance),
    })
}

/// The value of a sample.
struct SampleValue(Rgb);

impl PathObserver for SampleValue {
    fn is_sequential(&self) -> bool {
        false
    }

    fn sample_added(&mut self, value: Rgb) {
        self.0 = value;
    }
}

struct EventRecorder<'a> {
    scene: &'a Scene,
    events: Vec<PathEvent>,
    radiance: Rgb,
}

impl PathObserver for EventRecorder<'_> {
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
        self.events.push(PathEvent::CachedIndirect { contribution });
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

    fn sample_added(&mut self, value: Rgb) {
        self.radiance = value;
    }
}
