//! The part of a study that measures the sources of variance and of time: paths, bounces, effects.
//!
//! Measure: as in the report.
//! Range: measurements that do not fit into the time are left out, with a warning.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::effect_cost::{CostSettings, EffectCost, effect_costs};
use super::fit::TimeLaw;
use super::lengths::{self, bounce_costs};
use super::reference::References;
use super::report::EffectShare;
use super::run::Study;
use super::runner::{Purpose, seed_for};
use super::schedule::COST_SOURCES;
use super::settings::StudyClock;
use super::variance::{path_shares, remark};
use etendue::Result;
use etendue::internals::plan::Plan;
use etendue::internals::render::RenderObserver;

/// Number of rounds of renders with growing limits of bounces.
pub const BOUNCE_ROUNDS: u64 = 5;

/// Number of pairs of renders for the cost of an effect.
const EFFECT_ROUNDS: u64 = 3;

/// Minimum and maximum number of observed samples of a pixel.
const WATCHED: [u64; 2] = [8, 256];

/// Each step returns `None` if the study was cancelled.
impl Study<'_> {
    /// Measures the sources of variance, the cost of bounces, and that of effects. Each gets a third of the time, or of
    /// the remaining time.
    pub(super) fn cost_sources(
        &mut self,
        references: &References,
        laws: &[TimeLaw],
        clock: &StudyClock<'_>,
    ) -> Result<Option<()>> {
        let third = COST_SOURCES * self.settings.budget / 3.0;
        let share = |of_left: f64| third.min(of_left * clock.remaining()).max(0.0);
        self.paths(references, laws, share(1.0 / 3.0));
        if clock.is_cancelled() {
            return Ok(None);
        }
        self.publish(clock);
        if self.bounces(laws, share(0.5), clock)?.is_none() {
            return Ok(None);
        }
        self.effects(laws, share(0.9), clock)
    }

    /// Measures the variance of each variant by classes of paths.
    fn paths(&mut self, references: &References, laws: &[TimeLaw], seconds: f64) {
        let share = seconds / laws.len() as f64;
        for (index, law) in laws.iter().enumerate() {
            let spp = ((share / law.sample) as u64).clamp(WATCHED[0], WATCHED[1]);
            if share < 0.5 * law.at(spp as f64) {
                self.report
                    .warn("no time was left to measure the variance by class of paths");
                return;
            }
            let variant = &self.settings.variants[index];
            let seed = seed_for(self.settings.seed, Purpose::Paths, [index as u64, 0, 0]);
            let shares = path_shares(&self.prepared, variant, references, spp, seed);
            if let Some(remark) = remark(&variant.settings).filter(|_| shares.is_some()) {
                self.report.warn(remark);
            }
            self.report.variants[index].paths = shares;
        }
    }

    /// Measures the cost of each bounce for the first variant.
    fn bounces(
        &mut self,
        laws: &[TimeLaw],
        seconds: f64,
        clock: &StudyClock<'_>,
    ) -> Result<Option<()>> {
        let Some((law, variant)) = laws.first().zip(self.settings.variants.first()) else {
            return Ok(Some(()));
        };
        let each = seconds / (BOUNCE_ROUNDS * lengths::RENDERS) as f64;
        let spp = ((each - law.start) / law.sample) as u64;
        if spp == 0 {
            self.report
                .warn("no time was left to measure the cost of each bounce");
            return Ok(Some(()));
        }
        let seed = |round| seed_for(self.settings.seed, Purpose::Bounces, [round, 0, 0]);
        let seeds: Vec<u64> = (0..BOUNCE_ROUNDS).map(seed).collect();
        let costs = bounce_costs(&self.prepared, variant, spp, &seeds, clock)?;
        let is_whole = costs.is_some();
        self.report.variants[0].bounces = costs.unwrap_or_default();
        Ok(is_whole.then_some(()))
    }

    /// Measures the cost of each effect of the scene.
    fn effects(
        &mut self,
        laws: &[TimeLaw],
        seconds: f64,
        clock: &StudyClock<'_>,
    ) -> Result<Option<()>> {
        let plan = Plan::new(
            &self.description,
            self.prepared.scene(self.settings.options),
        );
        let renders = 2 * (plan.on().count() as u64 + 1) * (EFFECT_ROUNDS + 1);
        let builds = self
            .prepared
            .builds
            .first()
            .map_or(0.0, |(_, seconds)| *seconds);
        let each = (seconds - builds * plan.on().count() as f64) / renders as f64;
        let Some(law) = laws.first() else {
            return Ok(Some(()));
        };
        let spp = ((each - law.start) / law.sample) as u64;
        if spp == 0 {
            self.report.warn(
                "no time was left to measure the cost of each effect: see `etendue plan --cost`",
            );
            return Ok(Some(()));
        }
        let settings = CostSettings {
            accel: self.settings.options,
            spp,
            rounds: EFFECT_ROUNDS,
        };
        let costs = effect_costs(&self.description, &plan, &settings, clock, |_| {})?;
        let is_whole = costs.is_some();
        let effects = costs.map(|costs| costs.effects).unwrap_or_default();
        let share = |cost: EffectCost| EffectShare {
            effect: cost.effect.name(),
            time: cost.time,
            energy: [cost.energy, cost.energy_error],
            energy_margin: cost.energy_margin,
        };
        self.report.effects = effects.into_iter().map(share).collect();
        Ok(is_whole.then_some(()))
    }
}
