//! The part of a study that makes and tests images: tiles, error bars, and the variants at equal time and at equal
//! error.
//!
//! Measure: as in the report.
//! Range: a study whose levels are rendered.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::bars::reliability;
use super::fit::Reached;
use super::pictures::{Shown, relative_standard_errors};
use super::reference::References;
use super::report::VariantStudy;
use super::run::Study;
use super::runner::{Purpose, Runner, seed_for};
use super::settings::Watch;
use super::summary::{curve, time_law};
use super::tiles;
use etendue::Result;
use etendue::internals::film::batches::BATCHES;
use etendue::internals::image::metrics::signed_errors;
use etendue::internals::render::settings::RenderSettings;

/// Each step returns `None` if the study was cancelled.
impl Study<'_> {
    /// Tests tiles for bias, with the last level that has all seeds.
    pub(super) fn tiles(&mut self, references: &References, runner: &Runner<'_>) {
        for (study, levels) in self.report.variants.iter_mut().zip(&runner.images) {
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
        watch: &Watch<'_>,
    ) -> Result<Option<()>> {
        for (index, variant) in self.settings.variants.iter().enumerate() {
            let longest = self.report.variants[index].levels.last();
            let spp = (longest.map_or(1, |level| level.spp) / 4).max(BATCHES);
            let seed = seed_for(self.settings.seed, Purpose::Bars, [index as u64, 0, 0]);
            let settings = RenderSettings {
                layers: true,
                ..self.prepared.settings(variant, spp, seed)
            };
            let Some(shot) = self.prepared.render(variant, &settings, watch)? else {
                return Ok(None);
            };
            if let Some((report, errors)) = reliability(&shot.film, spp, references) {
                self.report.variants[index].bars = Some(report);
                let errors = relative_standard_errors(references, &errors);
                self.report.pictures.standard_errors.push((index, errors));
            }
        }
        Ok(Some(()))
    }

    /// Renders the variants at equal time and at equal error.
    pub(super) fn pictures(
        &mut self,
        references: &References,
        watch: &Watch<'_>,
    ) -> Result<Option<()>> {
        let known = |study: &VariantStudy| {
            let law = time_law(&study.levels)?;
            let curve = curve(&study.levels, 0);
            let (spp, mse, _) = curve.last()?;
            Some((law, curve, spp, mse))
        };
        let known: Vec<_> = self.report.variants.iter().map(known).collect();
        let all = || known.iter().flatten();
        let seconds = all()
            .map(|(law, _, spp, _)| law.at(*spp))
            .fold(f64::INFINITY, f64::min);
        let error = all().map(|(.., mse)| *mse).fold(0.0, f64::max);
        for (index, known) in known.iter().enumerate() {
            let Some((law, curve, longest, _)) = known else {
                continue;
            };
            let in_time = ((seconds - law.start) / law.sample).round().max(1.0);
            let at_error = match curve.reached(error) {
                Reached::At(spp) => spp.value.round().max(1.0),
                Reached::Within(_) => 1.0,
                Reached::Beyond(_) => *longest,
            };
            for (kind, spp) in [in_time, at_error].into_iter().enumerate() {
                let Some(shown) = self.shown(index, kind as u64, spp as u64, references, watch)?
                else {
                    return Ok(None);
                };
                let pictures = &mut self.report.pictures;
                match kind {
                    0 => pictures.equal_time.push(shown),
                    _ => pictures.equal_error.push(shown),
                }
            }
        }
        Ok(Some(()))
    }

    fn shown(
        &self,
        index: usize,
        kind: u64,
        spp: u64,
        references: &References,
        watch: &Watch<'_>,
    ) -> Result<Option<Shown>> {
        let variant = &self.settings.variants[index];
        let place = [index as u64, kind, 0];
        let seed = seed_for(self.settings.seed, Purpose::Picture, place);
        let settings = self.prepared.settings(variant, spp, seed);
        let Some(shot) = self.prepared.render(variant, &settings, watch)? else {
            return Ok(None);
        };
        let image = shot.film.develop();
        Ok(Some(Shown {
            variant: index,
            spp,
            seconds: shot.seconds.wall,
            rel_mse: references.rel_mse(&image)[0],
            errors: signed_errors(&image, references.mean())?,
            image,
        }))
    }
}
