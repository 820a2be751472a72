//! The check of a render's settings.
//!
//! Measure: pixels, samples per pixel.
//! Range: any settings; what is out of its range is a usage error that names the setting.
//! Source: none needed. Tested below and in `cli/tests/command/bad_flags.rs`.

use super::{Adaptive, Budget, RenderSettings};
use crate::error::{Error, Result};
use crate::film::Window;

/// The largest number of samples per pixel: beyond 2^47, random numbers would repeat (`sampler/mod.rs`).
pub const MAX_SPP: u64 = 1 << 46;

impl RenderSettings {
    /// Checks that the settings make sense for an image of this size.
    ///
    /// # Errors
    /// A usage error that names the setting.
    pub fn validate(&self, (width, height): (u32, u32)) -> Result<()> {
        let Window {
            x,
            y,
            width: w,
            height: h,
        } = self.window;
        let fits = |start: u32, length: u32, size: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= size)
        };
        if !(fits(x, w, width) && fits(y, h, height)) {
            return Err(Error::usage(format!(
                "the window from ({x}, {y}) of {w} x {h} pixels is not within the image of {width} x {height}"
            )));
        }
        let is_share = |x: f64| x > 0.0 && x < 1.0;
        match self.budget {
            Budget {
                spp: None,
                time: None,
                error: None,
            } => Err(Error::usage(
                "neither samples per pixel nor a time nor an error to stop at was given",
            )),
            Budget { spp: Some(spp), .. } if !(1..=MAX_SPP).contains(&spp) => Err(Error::usage(
                "samples per pixel must be at least 1, and at most 2^46",
            )),
            Budget {
                error: Some(target),
                ..
            } if !(is_share(target.rel_rmse) && is_share(target.confidence)) => Err(Error::usage(
                "the error to reach and its confidence must be above 0 and below 1",
            )),
            Budget { error: None, .. } if self.adaptive == Adaptive::Greedy => Err(Error::usage(
                "greedy adaptive sampling needs an error at which a pixel stops: give --error, such as --error 5%",
            )),
            _ if self.adaptive != Adaptive::Off && self.integrator.splats() => {
                Err(Error::usage(format!(
                    "the integrator {} has no adaptive sampling, as its light subpaths contribute to any pixel: use --adaptive=off, or --integrator path",
                    self.integrator.name()
                )))
            }
            _ if !(0.0..1.0).contains(&self.cache_error) => Err(Error::usage(
                "the error of an irradiance cache must be from 0 to below 1",
            )),
            _ if self.threads == 0 => Err(Error::usage("threads must be at least 1")),
            _ if self.tile_size == 0 => Err(Error::usage("the tile size must be at least 1")),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn out_of_range_settings_are_usage_errors() {
        let fine = RenderSettings::new((8, 4), 1);
        assert!(fine.validate((8, 4)).is_ok());
        let window = |x, y, width, height| RenderSettings {
            window: Window {
                x,
                y,
                width,
                height,
            },
            ..fine.clone()
        };
        let budget = |spp, time| RenderSettings {
            budget: Budget {
                spp,
                time,
                error: None,
            },
            ..fine.clone()
        };
        for wrong in [
            window(0, 0, 9, 4),
            window(8, 0, 1, 1),
            window(0, 0, 0, 4),
            window(u32::MAX, 0, 2, 1),
            budget(None, None),
            budget(Some(0), None),
            budget(Some(u64::MAX), None),
            RenderSettings {
                threads: 0,
                ..fine.clone()
            },
            RenderSettings {
                tile_size: 0,
                ..fine.clone()
            },
        ] {
            let error = wrong
                .validate((8, 4))
                .expect_err("something is out of its range");
            assert_eq!(error.kind(), crate::ErrorKind::Usage, "{wrong:?}");
        }
        assert!(
            budget(None, Some(Duration::from_secs(1)))
                .validate((8, 4))
                .is_ok()
        );
    }
}
