//! The overhead of our own render over the time that Embree alone needs for its rays when used in the fastest way.
//!
//! The floor of a sample is the sum, over the kinds of rays, of the number of rays per sample times the time per ray in
//! the fastest way through Embree, among those with the render's own precision. The time of the render over the floor
//! is the overhead factor: 1 would be a render that only traces rays, each kind in the fastest way. Pixels share no paths,
//! and there are no light paths: observers, which record the rays, see neither.
//!
//! Measure: nanoseconds of one core a sample.
//! Range: at least one round. Renders on all threads and on one thread are interleaved; a first round of each is
//! discarded. Images are made small so that each pixel has many samples, as final images have: the first samples of a
//! pixel are traced in smaller packets.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::meter::ProgressStage;
use super::record::Recording;
use super::report::TraceReport;
use super::subject::BenchedRender;
use super::target::BenchTarget;
use etendue::Result;
use etendue::internals::math::stats::Spread;
use etendue::internals::render::Rendered;
use etendue::internals::render::settings::RenderSettings;

/// The time of tracing alone.
#[derive(Debug, Clone)]
pub struct TracingFloor {
    /// Nanoseconds of one core for the rays of a sample.
    pub nanoseconds: f64,
    /// The fastest way for each kind.
    pub best: Vec<TraceReport>,
}

impl TracingFloor {
    /// Computes the floor of a render through `target`; `None` unless Embree was timed on all kinds of its rays.
    pub fn of(target: BenchTarget, recording: &Recording, traces: &[TraceReport]) -> Option<Self> {
        if !target.is_embree() {
            return None;
        }
        let fits =
            |it: BenchTarget| it.backend == target.backend && it.precision == target.precision;
        let best = recording.kinds().map(|kind| {
            let of_kind = traces
                .iter()
                .filter(|trace| trace.kind == kind && fits(trace.variant.target));
            let median = |trace: &TraceReport| trace.nanoseconds.median;
            let best = of_kind.min_by(|a, b| median(a).total_cmp(&median(b)));
            best.cloned()
        });
        let best = best.collect::<Option<Vec<TraceReport>>>()?;
        let time =
            |trace: &TraceReport| recording.per_sample(trace.kind) * trace.nanoseconds.median;
        Some(Self {
            nanoseconds: best.iter().map(time).sum(),
            best,
        })
    }

    /// The overhead factor of renders that took `sample` nanoseconds per sample.
    pub fn factor(&self, sample: Spread) -> Spread {
        Spread {
            median: sample.median / self.nanoseconds,
            min: sample.min / self.nanoseconds,
            max: sample.max / self.nanoseconds,
        }
    }
}

/// The minimum number of samples per pixel of a render on one thread.
const MIN_SPP: u64 = 64;

/// The measured times of renders.
#[derive(Debug, Clone, Copy)]
pub struct RenderTimes {
    /// Samples per pixel of a render on all threads.
    pub spp: u64,
    /// Nanoseconds of one core a sample, on all threads.
    pub sample: Spread,
    /// Nanoseconds of one core a sample, on one thread.
    pub sample_alone: Spread,
}

/// Times renders of about `seconds` each; `None` if cancelled.
///
/// # Errors
/// As `render`.
pub fn render_times(
    subject: &BenchedRender<'_>,
    threads: usize,
    rounds: usize,
    seconds: f64,
    stage: &ProgressStage<'_>,
) -> Result<Option<RenderTimes>> {
    let Some(first) = time(subject, threads, 1, stage)? else {
        return Ok(None);
    };
    // The render on one thread has 1 / `threads` of these samples.
    let least = MIN_SPP * threads as u64;
    let samples = seconds * 1e9 * threads as f64 / first;
    let (scene, size) = subject.scene.reduced(subject.size, samples / least as f64);
    let settings = RenderSettings {
        window: RenderSettings::new(size, 1).window,
        ..subject.settings.clone()
    };
    let reduced = BenchedRender {
        scene: &scene,
        size,
        settings: &settings,
        ..*subject
    };
    let spp = (samples / settings.window.pixel_count() as f64).round() as u64;
    let spp = spp.max(least);
    let time = |threads, spp| time(&reduced, threads, spp, stage);
    let (mut sample, mut sample_alone) = (vec![], vec![]);
    for round in 0..=rounds {
        let together = time(threads, spp)?;
        let alone = time(1, spp / threads as u64)?;
        let (Some(together), Some(alone)) = (together, alone) else {
            return Ok(None);
        };
        if round > 0 {
            sample.push(together);
            sample_alone.push(alone);
        }
        if !stage.advance((round + 1) as f64 / (rounds + 1) as f64) {
            return Ok(None);
        }
    }
    Ok(Some(RenderTimes {
        spp,
        sample: Spread::of(sample),
        sample_alone: Spread::of(sample_alone),
    }))
}

/// Nanoseconds of one core a sample; `None` if cancelled.
fn time(
    subject: &BenchedRender<'_>,
    threads: usize,
    spp: u64,
    stage: &ProgressStage<'_>,
) -> Result<Option<f64>> {
    let rendered = subject.render(threads, spp, stage)?;
    Ok((!rendered.cancelled).then(|| nanoseconds_per_sample(&rendered, threads)))
}

fn nanoseconds_per_sample(rendered: &Rendered, threads: usize) -> f64 {
    let seconds = rendered.elapsed.as_secs_f64();
    seconds * 1e9 * threads as f64 / rendered.film.sample_count() as f64
}
