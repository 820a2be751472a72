//! The rays of a render, by kind, in the order in which it traces them.
//!
//! The rays are those of whole tiles, spread over the image; recording does not change the render.
//!
//! Measure: normalised scene units.
//! Range: a limited number of rays of each kind, beyond which rays are only counted. The primitive that a ray leaves is
//! not recorded: the few rays that hit it again because of rounding end there when they are traced again.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::report::RayCount;
use super::subject::BenchedRender;
use etendue::internals::accel::batch::RayBatch;
use etendue::internals::film::Film;
use etendue::internals::integrator::RayCounts;
use etendue::internals::integrator::observer::{PathObserver, RayKind};
use etendue::internals::math::ray::Ray;

const KINDS: usize = RayKind::ALL.len();

/// The recorded rays of a render.
#[derive(Debug)]
pub struct Recording {
    rays: [RayBatch; KINDS],
    traced: [u64; KINDS],
    /// The film with the samples to which the rays belong, in the pixels where the render has them.
    pub film: Film,
}

/// Records rays until the most frequent kind has `limit` of them, or the render has no more.
pub fn record(subject: &BenchedRender<'_>, limit: usize) -> Recording {
    let mut recorder = RayRecorder {
        limit,
        rays: Default::default(),
        traced: [0; KINDS],
    };
    let full = |recorder: &RayRecorder| recorder.rays.iter().any(|rays| rays.len() >= limit);
    let film = subject.observe(0, &mut recorder, full);
    Recording {
        rays: recorder.rays,
        traced: recorder.traced,
        film,
    }
}

impl Recording {
    /// The kinds of which rays were recorded.
    pub fn kinds(&self) -> impl Iterator<Item = RayKind> {
        let all = RayKind::ALL.iter().copied();
        all.filter(|&kind| !self.rays(kind).is_empty())
    }

    /// The rays of a kind.
    pub fn rays(&self, kind: RayKind) -> &RayBatch {
        &self.rays[kind as usize]
    }

    /// The average number of rays of a kind per sample of the render.
    pub fn per_sample(&self, kind: RayKind) -> f64 {
        self.traced[kind as usize] as f64 / self.film.sample_count() as f64
    }

    /// The numbers of all rays of the recorded samples, as a render counts them.
    pub fn counts(&self) -> RayCounts {
        let of = |kind: RayKind| self.traced[kind as usize];
        let (camera, shadow) = (of(RayKind::Camera), of(RayKind::Shadow));
        RayCounts {
            camera,
            shadow,
            closest: self.traced.iter().sum::<u64>() - camera - shadow,
        }
    }

    /// The numbers of rays of each recorded kind, for the report.
    pub fn report(&self) -> Vec<RayCount> {
        let count = |kind| RayCount {
            kind,
            per_sample: self.per_sample(kind),
            recorded: self.rays(kind).len(),
        };
        self.kinds().map(count).collect()
    }
}

struct RayRecorder {
    limit: usize,
    rays: [RayBatch; KINDS],
    traced: [u64; KINDS],
}

impl PathObserver for RayRecorder {
    fn is_sequential(&self) -> bool {
        false
    }

    fn traced(&mut self, kind: RayKind, ray: &Ray, time: f32) {
        let kind = kind as usize;
        self.traced[kind] += 1;
        if self.rays[kind].len() < self.limit {
            self.rays[kind].push(ray, time);
        }
    }
}
