//! The time of each part of the work for a sample.
//!
//! A clock is read at every event of a path, and the time since the previous event is added to the part of the work
//! that this event ends. The cost of reading the clock is subtracted. Since reading it also limits out-of-order
//! execution, the parts are then scaled so that their sum is the time of a sample without an observer: they are shares
//! of that.
//!
//! Measure: nanoseconds of one core a sample.
//! Range: whole tiles, spread over the image, on one thread, all traced once beforehand to fill the caches. For each
//! part, the shortest of a few runs counts: longer ones were interrupted.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::report::PartReport;
use super::subject::{BenchedRender, SAMPLES_AT_ONCE};
use etendue::internals::bsdf::types::Lobe;
use etendue::internals::integrator::observer::{PathObserver, PathVertex, RayKind};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Number of runs of which the shortest counts.
const RUNS: usize = 3;

/// A part of the work for a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SamplePart {
    /// Starting the sampler for the sample, and generating its camera ray.
    Camera,
    /// Tracing closest hits, and computing the surface interaction and its BSDF.
    ClosestHits,
    /// Emission, and light sampling.
    Lights,
    /// Tracing shadow rays.
    ShadowRays,
    /// BSDF sampling, Russian roulette, and setting up the extension rays.
    Scattering,
    /// Adding the sample to its pixel.
    Film,
}

impl SamplePart {
    /// Every part, in the order of the work.
    pub const ALL: &'static [Self] = &[
        Self::Camera,
        Self::ClosestHits,
        Self::Lights,
        Self::ShadowRays,
        Self::Scattering,
        Self::Film,
    ];

    /// The name of the part in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "sampler start, camera ray",
            Self::ClosestHits => "closest hits, surfaces, materials",
            Self::Lights => "emission, light sampling",
            Self::ShadowRays => "shadow rays",
            Self::Scattering => "scattering, roulette",
            Self::Film => "film",
        }
    }

    /// Whether rays are traced in this part.
    pub fn traces(self) -> bool {
        matches!(self, Self::ClosestHits | Self::ShadowRays)
    }
}

/// Measures the parts of a sample that takes `nanoseconds` in total, from at least `samples` samples.
pub fn parts(subject: &BenchedRender<'_>, samples: u64, nanoseconds: f64) -> Vec<PartReport> {
    let reading = cost_of_reading();
    // The first samples of a pixel are traced in smaller packets, and most images have many more.
    let spp = subject.settings.budget.spp.unwrap_or(u64::MAX);
    let first = if spp > SAMPLES_AT_ONCE {
        SAMPLES_AT_ONCE
    } else {
        0
    };
    let measure = || {
        let mut clock = EventClock::new();
        let enough = |clock: &EventClock| clock.samples >= samples;
        subject.observe(first, &mut clock, enough);
        clock.laps.map(|laps| laps.without(reading))
    };
    measure();
    let mut times = measure();
    for _ in 1..RUNS {
        for (time, again) in times.iter_mut().zip(measure()) {
            *time = time.min(again);
        }
    }
    let measured = times.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let scale = nanoseconds / measured;
    let report = |(part, time): (&SamplePart, f64)| PartReport {
        part: part.name(),
        nanoseconds: time * scale,
    };
    SamplePart::ALL.iter().zip(times).map(report).collect()
}

/// Nanoseconds of one reading of the clock, without interruptions.
fn cost_of_reading() -> f64 {
    const READINGS: u32 = 1000;
    let batch = || {
        let start = Instant::now();
        for _ in 0..READINGS {
            black_box(Instant::now());
        }
        start.elapsed().as_secs_f64() * 1e9 / f64::from(READINGS)
    };
    (0..100).map(|_| batch()).fold(f64::INFINITY, f64::min)
}

/// The accumulated time of one part.
#[derive(Debug, Clone, Copy, Default)]
struct Laps {
    count: u64,
    time: Duration,
}

impl Laps {
    /// Nanoseconds of all laps, without the time of reading the clock.
    fn without(self, reading: f64) -> f64 {
        (self.time.as_secs_f64() * 1e9 - self.count as f64 * reading).max(0.0)
    }
}

/// An observer that reads the clock at every event.
struct EventClock {
    last: Instant,
    laps: [Laps; SamplePart::ALL.len()],
    samples: u64,
}

impl EventClock {
    fn new() -> Self {
        Self {
            last: Instant::now(),
            laps: Default::default(),
            samples: 0,
        }
    }

    /// Adds the time since the last event to a part.
    #[inline]
    fn end(&mut self, part: SamplePart) {
        let now = Instant::now();
        let laps = &mut self.laps[part as usize];
        laps.count += 1;
        laps.time += now - self.last;
        self.last = now;
    }
}

impl PathObserver for EventClock {
    fn is_sequential(&self) -> bool {
        false
    }

    fn traced(&mut self, kind: RayKind, _ray: &Ray, _time: f32) {
        self.end(match kind {
            RayKind::Camera => SamplePart::Camera,
            RayKind::Shadow => SamplePart::Lights,
            _ => SamplePart::Scattering,
        });
    }

    fn arrived(&mut self, _at: &PathVertex, _beta: Rgb) {
        self.end(SamplePart::ClosestHits);
    }

    fn escaped(&mut self, _direction: Vec3) {
        self.end(SamplePart::ClosestHits);
    }

    fn environment(&mut self, _contribution: Rgb) {
        self.end(SamplePart::Lights);
    }

    fn emission(&mut self, _contribution: Rgb, _weight: f32) {
        self.end(SamplePart::Lights);
    }

    fn light(&mut self, _contribution: Rgb, _weight: f32, _visible: f32) {
        self.end(SamplePart::ShadowRays);
    }

    fn unlit(&mut self) {
        self.end(SamplePart::Lights);
    }

    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {
        self.end(SamplePart::Scattering);
    }

    fn terminated(&mut self, _survival: f32) {
        self.end(SamplePart::Scattering);
    }

    fn absorbed(&mut self) {
        self.end(SamplePart::Scattering);
    }

    fn sample_added(&mut self, _value: Rgb) {
        self.end(SamplePart::Film);
        self.samples += 1;
    }
}
