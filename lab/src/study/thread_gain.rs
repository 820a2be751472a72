//! The part of a study that measures the gain from one thread to all of the machine.
//!
//! Measure: seconds.
//! Range: two threads or more; renders on one thread and on all alternate.
//! Source: none needed. Tested in `cli/tests/command/study.rs`.

use super::fit::TimeLaw;
use super::run::Study;
use super::runner::{Purpose, seed_for};
use super::scaling::Scaling;
use super::schedule::SCALING;
use super::settings::StudyClock;
use etendue::Result;

/// The minimum and the maximum number of pairs of renders, with one thread and with all.
const ROUNDS: [u64; 2] = [4, 12];

impl Study<'_> {
    /// Measures the gain by threads with the first variant, if times for another number of them were requested; `None`
    /// if it was cancelled.
    pub(super) fn scaling(
        &mut self,
        laws: &[TimeLaw],
        clock: &StudyClock<'_>,
    ) -> Result<Option<()>> {
        let Some((threads, (law, variant))) = self
            .settings
            .for_threads
            .zip(laws.first().zip(self.settings.variants.first()))
        else {
            return Ok(Some(()));
        };
        let measured = self.settings.options.threads;
        if measured < 2 {
            self.report.warn(
                "times for another number of threads need a measurement with two threads or more",
            );
            return Ok(Some(()));
        }
        let spp_step = variant.settings.spp_step();
        let [fewest, most] = ROUNDS;
        let seconds = SCALING * self.settings.budget;
        // A pair takes as long as one render and `measured` times that.
        let pair = |spp: f64| (1.0 + measured as f64) * law.at(spp);
        let spp = ((seconds / most as f64 / pair(1.0)) as u64).max(1);
        let rounds = ((seconds / pair(spp as f64)) as u64).clamp(fewest, most);
        let mut ratios = Vec::new();
        for round in 0..rounds {
            let seed = seed_for(self.settings.seed, Purpose::Scaling, [round, 0, 0]);
            let mut times = [0.0; 2];
            for (time, threads) in times.iter_mut().zip([1, measured]) {
                let mut settings = self.prepared.settings(variant, spp * spp_step, seed);
                settings.threads = threads;
                let Some(shot) = self.prepared.render(variant, &settings, clock)? else {
                    return Ok(None);
                };
                *time = shot.seconds.wall;
            }
            ratios.push(times[1] / times[0]);
        }
        self.report.scaling = Scaling::of(measured, threads, &ratios);
        Ok(Some(()))
    }
}
