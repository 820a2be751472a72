//! The part of a study that selects and tests images: tiles, error bars, the variants after certain times, examples of
//! certain errors.
//!
//! Measure: as in the report.
//! Range: a study whose levels are rendered.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::bars::reliability;
use super::compared_renders::ComparedRenders;
use super::reference::References;
use super::report::LevelReport;
use super::run::Study;
use super::runner::{Purpose, seed_for};
use super::settings::StudyClock;
use super::shown_images::{AtTime, EXAMPLES, ImageWithError, TIMES, relative_standard_errors};
use super::summary::{Summary, summaries};
use super::tiles;
use etendue::Result;
use etendue::internals::film::batches::BATCHES;
use etendue::internals::image::metrics::signed_errors;

/// The largest ratio between the error of an example and the one that it stands for.
const SIMILAR: f64 = 1.5;

/// The ratio below which a render takes nearly a certain time: levels lie a factor of two apart.
const MAX_TIME_RATIO: f64 = 2.0;

/// Each step returns `None` if the study was cancelled.
impl Study<'_> {
    /// Tests tiles for bias, with the last level that has all seeds.
    pub(super) fn tiles(&mut self, references: &References, compared: &ComparedRenders<'_>) {
        for (study, levels) in self.report.variants.iter_mut().zip(&compared.images) {
            let most = levels.iter().map(Vec::len).max().unwrap_or(0);
            let whole = levels.iter().rposition(|images| images.len() == most);
            if let Some(level) = whole.filter(|_| most > 1) {
                study.tile_p_values = tiles::p_values(references, &levels[level]);
            }
        }
    }

    /// Renders each variant once with error bars. The render is short compared with the reference, whose noise the bars
    /// do not include.
    pub(super) fn bars(
        &mut self,
        references: &References,
        clock: &StudyClock<'_>,
    ) -> Result<Option<()>> {
        for (index, variant) in self.settings.variants.iter().enumerate() {
            let longest = self.report.variants[index].levels.last();
            let spp = (longest.map_or(1, |level| level.spp) / 4).max(BATCHES);
            let seed = seed_for(self.settings.seed, Purpose::Bars, [index as u64, 0, 0]);
            let settings = self.prepared.settings(variant, spp, seed).with_layers();
            let Some(shot) = self.prepared.render(variant, &settings, clock)? else {
                return Ok(None);
            };
            if let Some((report, errors)) = reliability(&shot.film, spp, references) {
                self.report.variants[index].bars = Some(report);
                let errors = relative_standard_errors(references, &errors);
                self.report.images.standard_errors.push((index, errors));
            }
        }
        Ok(Some(()))
    }

    /// Selects the images to be shown among those of the levels.
    pub(super) fn show_images(
        &mut self,
        references: &References,
        compared: &ComparedRenders<'_>,
    ) -> Result<()> {
        let found = summaries(&self.report);
        let mut before: Vec<Option<usize>> = Vec::new();
        for seconds in TIMES {
            let levels = self.levels_after(seconds, &found);
            if levels != before {
                self.show_after(seconds, &levels, &found, references, compared)?;
            }
            before = levels;
        }
        if self.report.images.at_times.is_empty() {
            // A short study reaches none of these times: the longest renders are compared.
            let longest = |(index, summary): &(usize, Summary)| {
                let mut levels = self.report.variants[*index].levels.iter();
                let spp = levels.rfind(|level| !level.runs.is_empty())?.spp;
                Some(summary.own_time.at(spp as f64))
            };
            let seconds = found.iter().filter_map(longest).fold(0.0, f64::max);
            let levels = self.levels_after(seconds, &found);
            self.show_after(seconds, &levels, &found, references, compared)?;
        }
        for error in EXAMPLES {
            let off = |level: &LevelReport| {
                let mean = level.gram.mse().map_or(f64::NAN, |mse| mse.value);
                (0.5 * mean.ln() - error.ln()).abs()
            };
            let right = found.iter().filter(|(_, summary)| !summary.bias.is_found);
            let candidates = right.filter_map(|(index, _)| {
                let level = self.nearest(*index, off)?;
                Some((
                    off(&self.report.variants[*index].levels[level]),
                    (*index, level),
                ))
            });
            let best = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, pair)) = best.filter(|(off, _)| *off < SIMILAR.ln()) {
                let shown = self.shown(pair, references, compared)?;
                self.report.images.examples.push(shown);
            }
        }
        Ok(())
    }

    /// The level of each variant that takes nearly this time at the scene's own size; `None` where none does.
    fn levels_after(&self, seconds: f64, found: &[(usize, Summary)]) -> Vec<Option<usize>> {
        let level = |(index, summary): &(usize, Summary)| {
            let off = |level: &LevelReport| {
                let time = summary.own_time.at(level.spp as f64);
                (time / seconds).ln().abs()
            };
            let levels = &self.report.variants[*index].levels;
            let nearest = self.nearest(*index, off);
            nearest.filter(|&level| off(&levels[level]) < MAX_TIME_RATIO.ln())
        };
        found.iter().map(level).collect()
    }

    /// Shows the first image of these levels, if there is any, after a time.
    fn show_after(
        &mut self,
        seconds: f64,
        levels: &[Option<usize>],
        found: &[(usize, Summary)],
        references: &References,
        compared: &ComparedRenders<'_>,
    ) -> Result<()> {
        let pairs = found.iter().zip(levels);
        let pairs = pairs.filter_map(|((index, _), level)| Some((*index, (*level)?)));
        let shown = pairs.map(|pair| self.shown(pair, references, compared));
        let shown = shown.collect::<Result<Vec<ImageWithError>>>()?;
        if !shown.is_empty() {
            self.report.images.at_times.push(AtTime { seconds, shown });
        }
        Ok(())
    }

    /// The level of a variant for which `off` is least, among those with renders.
    fn nearest(&self, variant: usize, off: impl Fn(&LevelReport) -> f64) -> Option<usize> {
        let levels = self.report.variants[variant].levels.iter().enumerate();
        let rendered = levels.filter(|(_, level)| !level.runs.is_empty());
        let nearest = rendered.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
        nearest.map(|(index, _)| index)
    }

    /// The first image of a level.
    fn shown(
        &self,
        (variant, level): (usize, usize),
        references: &References,
        compared: &ComparedRenders<'_>,
    ) -> Result<ImageWithError> {
        let image = &compared.images[variant][level][0];
        let level = &self.report.variants[variant].levels[level];
        Ok(ImageWithError {
            variant,
            spp: level.spp,
            seconds: level.runs[0].seconds.wall,
            rel_mse: level.runs[0].rel_mse,
            errors: signed_errors(image, references.mean())?,
            image: image.clone(),
        })
    }
}
