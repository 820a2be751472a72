//! The renders of all levels, each compared with the references and with the others of its level.
//!
//! Measure: relMSE.
//! Range: images of the references' size.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::reference::References;
use super::report::{RunReport, StudyReport};
use super::runner::{LevelRender, luminance};
use super::schedule::Schedule;
use etendue::internals::image::Image;

/// The renders so far, in the order in which they were given.
pub struct ComparedRenders<'a> {
    references: &'a References,
    /// All images, by variant and level.
    pub images: Vec<Vec<Vec<Image>>>,
    /// Number of renders so far.
    done: usize,
}

impl<'a> ComparedRenders<'a> {
    /// No renders yet, for the levels of a schedule.
    pub fn new(references: &'a References, schedule: &Schedule) -> Self {
        let levels = |seeds: &Vec<u64>| vec![Vec::new(); seeds.len()];
        Self {
            references,
            images: schedule.seeds.iter().map(levels).collect(),
            done: 0,
        }
    }

    /// Compares a render with the references and the earlier renders of its level, and adds the results to the report.
    pub fn take(&mut self, render: LevelRender, report: &mut StudyReport) {
        let LevelRender {
            task,
            seed,
            image,
            error_record,
            seconds,
            repeated,
            disturbed,
            rejected,
        } = render;
        let references = self.references;
        let earlier = &mut self.images[task.variant][task.level as usize];
        let row = earlier.iter().map(|old| references.product(&image, old));
        let row: Vec<f64> = row.collect();
        let column = earlier.iter().map(|old| references.product(old, &image));
        let column: Vec<f64> = column.collect();
        let [rel_mse, trimmed] = references.rel_mse(&image);
        let study = &mut report.variants[task.variant];
        study.error_record = study.error_record.or(error_record);
        study.repeated += usize::from(repeated);
        study.disturbed += usize::from(disturbed);
        let level = &mut study.levels[task.level as usize];
        level.gram.push(row, &column, rel_mse);
        level.runs.push(RunReport {
            seed,
            order: self.done,
            seconds,
            repeated,
            rel_mse,
            trimmed,
            luminance: luminance(&image),
            rejected,
        });
        self.done += 1;
        earlier.push(image);
    }
}
