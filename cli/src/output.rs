//! Progress display of a render, and its interruption by Ctrl-C.
//!
//! Measure: samples per pixel, seconds.
//! Range: a bar on a terminal; otherwise a line every 30 seconds; nothing with `--quiet` or `--progress none`.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use super::args::ProgressMode;
use super::durations::format_duration;
use etendue::internals::film::Doubt;
use etendue::internals::render::{Predicted, Progress, RenderObserver};
use etendue::{Error, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The interval between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// The number of steps of the progress bar.
const BAR_LENGTH: u64 = 1000;

/// Prints a line to standard error, as `eprintln!` does. A line that cannot be written is lost: a render does not end for it.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::output::say_line(format_args!($($words)*))
    };
}

/// Prints a line to standard error, if that can be written to.
pub fn say_line(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Shows progress and forwards Ctrl-C.
pub struct ConsoleObserver {
    display: Display,
    /// The best prediction printed so far: 0 none, 1 rough, 2 from a whole pilot.
    predicted: AtomicU8,
    interrupted: Arc<AtomicBool>,
}

enum Display {
    Bar(ProgressBar),
    Lines(Mutex<Instant>),
    Nothing,
}

impl ConsoleObserver {
    /// Creates an observer that catches Ctrl-C, the request to end, and the end of the terminal unless that is ignored, as by
    /// `nohup`. A second Ctrl-C ends the process at once; other signals may come twice, as from a queue that ends a job.
    ///
    /// # Errors
    /// If the handler cannot be installed.
    pub fn new(mode: ProgressMode) -> Result<Self> {
        let interrupted = Arc::new(AtomicBool::new(false));
        let mut signals = vec![SIGINT, SIGTERM];
        if !is_ignored(SIGHUP) {
            signals.push(SIGHUP);
        }
        for signal in signals {
            let at_once = match signal {
                SIGINT => {
                    flag::register_conditional_shutdown(signal, 130, Arc::clone(&interrupted))
                        .map(drop)
                }
                _ => Ok(()),
            };
            at_once
                .and_then(|()| flag::register(signal, Arc::clone(&interrupted)))
                .map_err(|error| {
                    Error::render("cannot install a handler for Ctrl-C").because(error)
                })?;
        }
        Ok(Self {
            display: Display::new(mode),
            predicted: AtomicU8::new(0),
            interrupted,
        })
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

/// Whether this process ignores a signal, as far as the system tells.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
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

impl ConsoleObserver {
    /// Shows the completed fraction, with a message.
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
                    say!("{percent:>3} %  {}", words());
                }
            }
        }
    }
}

impl ConsoleObserver {
    /// Prints a line above the bar.
    pub fn note(&self, words: &str) {
        match &self.display {
            Display::Nothing => {}
            Display::Bar(bar) => bar.suspend(|| say!("{words}")),
            Display::Lines(_) => say!("{words}"),
        }
    }

    /// Prints a warning, even if nothing else is shown.
    pub fn warn(&self, words: &str) {
        match &self.display {
            Display::Nothing => say!("{words}"),
            _ => self.note(words),
        }
    }
}

/// Describes the pilot's prediction of the samples and the time to the target error.
fn describe_prediction(predicted: &Predicted) -> String {
    let about = if predicted.is_rough {
        "very roughly"
    } else {
        "about"
    };
    format!(
        "after {} spp the error is about {}; the requested error takes {about} {} spp, {}",
        predicted.pilot,
        format_percent(predicted.error),
        predicted.spp,
        format_duration(predicted.time)
    )
}

impl RenderObserver for ConsoleObserver {
    fn shows_error(&self) -> bool {
        !matches!(self.display, Display::Nothing)
    }

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

/// Describes the samples per pixel, the current error and the time left.
fn describe(progress: &Progress) -> String {
    let error = progress.rel_rmse.map_or(String::new(), |error| {
        format!(", error {}", format_percent(error))
    });
    let left = time_left(progress.fraction, progress.elapsed)
        .map_or(String::new(), |left| format!(", {left} left"));
    format!("{} spp{error}{left}", progress.spp)
}

/// Returns the estimated time left, given the elapsed time of a completed fraction.
pub fn time_left(fraction: f64, elapsed: Duration) -> Option<String> {
    let left = (elapsed.as_secs_f64() * (1.0 / fraction - 1.0)).clamp(0.0, 3.6e9);
    (fraction > 0.0).then(|| format_duration(Duration::from_secs_f64(left)))
}

/// Explains why an error has no upper bound.
pub fn explain(doubt: Doubt) -> String {
    match doubt {
        Doubt::FewPixels { pixels, share, .. } => format!(
            "rare bright paths: {} of the pixels hold {} of the squared error",
            format_percent(pixels),
            format_percent(share)
        ),
        Doubt::OneSample { times, .. } => {
            format!("rare bright paths: a single sample may be {times:.1} times the squared error")
        }
        Doubt::Rising {
            samples, rel_rmse, ..
        } => format!(
            "it has not fallen as expected from {} after {samples:.0} spp: rare bright paths",
            format_percent(rel_rmse)
        ),
    }
}

/// Formats a confidence as a percentage, never as 100 %.
pub fn format_confidence(confidence: f64) -> String {
    let percent = 100.0 * confidence;
    let decimals = (0..12).find(|&decimals| {
        let rounded: f64 = format!("{percent:.decimals$}").parse().unwrap_or(percent);
        rounded < 100.0 && (rounded - percent).abs() <= 0.02 * (100.0 - percent)
    });
    format!("{percent:.0$} %", decimals.unwrap_or(12))
}

/// Formats a signed fraction as a percentage with three digits.
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
