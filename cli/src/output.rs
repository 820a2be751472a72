//! Progress while a render goes on, and its end by Ctrl-C.
//!
//! Measure: samples per pixel, seconds.
//! Range: a bar on a terminal; elsewhere a line every 30 seconds; nothing with `--quiet` or `--progress none`.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use super::args::ProgressMode;
use super::durations::format_duration;
use etendue::internals::film::Doubt;
use etendue::internals::render::{Predicted, Progress, RenderObserver};
use etendue::{Error, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// Parts of the bar.
const BAR_LENGTH: u64 = 1000;

/// Shows progress and passes Ctrl-C on.
pub struct Watcher {
    display: Display,
    /// How well it was said when an error will be reached: not at all, roughly, by a whole pilot.
    predicted: AtomicU8,
    interrupted: Arc<AtomicBool>,
}

enum Display {
    Bar(ProgressBar),
    Lines(Mutex<Instant>),
    Nothing,
}

impl Watcher {
    /// A watcher that catches Ctrl-C. A second one ends the process at once.
    ///
    /// # Errors
    /// If the handler cannot be installed.
    pub fn new(mode: ProgressMode) -> Result<Self> {
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        })
        .map_err(|error| Error::render("cannot watch for Ctrl-C").because(error))?;
        Ok(Self {
            display: Display::new(mode),
            predicted: AtomicU8::new(0),
            interrupted,
        })
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

impl Display {
    fn new(mode: ProgressMode) -> Self {
        match mode {
            ProgressMode::None => Self::Nothing,
            ProgressMode::Auto if std::io::stderr().is_terminal() => {
                let target = ProgressDrawTarget::stderr_with_hz(5);
                let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), target);
                let style = ProgressStyle::with_template("{bar:40.cyan} {percent:>3} %  {msg}");
                bar.set_style(style.expect("the template is well formed"));
                Self::Bar(bar)
            }
            _ => Self::Lines(Mutex::new(Instant::now())),
        }
    }
}

impl Watcher {
    /// Shows how far something has come, in words, too.
    pub fn show(&self, fraction: f64, words: impl FnOnce() -> String) {
        match &self.display {
            Display::Nothing => {}
            Display::Bar(bar) => {
                bar.set_position((fraction * BAR_LENGTH as f64) as u64);
                bar.set_message(words());
            }
            Display::Lines(last) => {
                let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    // Rounded down: 100 % means done.
                    let percent = (100.0 * fraction).floor();
                    eprintln!("{percent:>3} %  {}", words());
                }
            }
        }
    }
}

impl Watcher {
    /// Says something once, above the bar.
    fn note(&self, words: &str) {
        match &self.display {
            Display::Nothing => {}
            Display::Bar(bar) => bar.suspend(|| eprintln!("{words}")),
            Display::Lines(_) => eprintln!("{words}"),
        }
    }
}

/// When an error will be reached, by what the pilot told.
fn describe_prediction(predicted: &Predicted) -> String {
    let about = if predicted.is_rough {
        "very roughly"
    } else {
        "about"
    };
    format!(
        "after {} spp the error is below {}; what is asked for takes {about} {} spp, {}",
        predicted.pilot,
        format_percent(predicted.error),
        predicted.spp,
        format_duration(predicted.time)
    )
}

impl RenderObserver for Watcher {
    fn cache_prepass(&self, share: f64, records: usize) {
        self.show(share, || format!("irradiance cache, {records} records"));
    }

    fn progress(&self, progress: &Progress) {
        if let Some(predicted) = &progress.predicted {
            let how_well = if predicted.is_rough { 1 } else { 2 };
            if self.predicted.fetch_max(how_well, Ordering::Relaxed) < how_well {
                self.note(&describe_prediction(predicted));
            }
        }
        self.show(progress.fraction, || describe(progress));
    }

    fn is_cancelled(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

/// Samples, error so far, time left.
fn describe(progress: &Progress) -> String {
    let error = progress.rel_rmse.map_or(String::new(), |error| {
        format!(", error {}", format_percent(error))
    });
    let left = time_left(progress.fraction, progress.elapsed)
        .map_or(String::new(), |left| format!(", {left} left"));
    format!("{} spp{error}{left}", progress.spp)
}

/// How long something will still take that took so long for a fraction of it.
pub fn time_left(fraction: f64, elapsed: Duration) -> Option<String> {
    let left = (elapsed.as_secs_f64() * (1.0 / fraction - 1.0)).clamp(0.0, 3.6e9);
    (fraction > 0.0).then(|| format_duration(Duration::from_secs_f64(left)))
}

/// Why an error has no bound, in words.
pub fn explain(doubt: Doubt) -> String {
    match doubt {
        Doubt::FewPixels { pixels, share, .. } => format!(
            "rare bright paths: {} of the pixels hold {} of the squared error",
            format_percent(pixels),
            format_percent(share)
        ),
        Doubt::OneSample { times, .. } => {
            format!("rare bright paths: a single one may be {times:.1} times the squared error")
        }
        Doubt::Rising {
            samples, rel_rmse, ..
        } => format!(
            "it has not fallen as it should from {} after {samples:.0} spp: rare bright paths",
            format_percent(rel_rmse)
        ),
    }
}

/// A fraction, of either sign, as a percentage with three digits.
pub fn format_percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    let size = percent.abs();
    let decimals = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 1.0 {
        2
    } else {
        3
    };
    format!("{percent:.decimals$} %")
}
