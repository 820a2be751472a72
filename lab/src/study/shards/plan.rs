//! The plan of a study on several machines: its renders and their costs, measured once, as a JSON file.
//!
//! Measure: stated at each field.
//! Range: [`StudyPlan::check`] refuses plans of another study, and those that no study writes.
//! Source: none needed. Tested in `lab/tests/reports/study_shards.rs`.

use super::super::fit::TimeLaw;
use super::super::own_size::OwnSize;
use super::super::schedule::Schedule;
use super::super::settings::StudySettings;
use etendue::internals::image::atomic::write_text;
use etendue::internals::state::Fingerprint;
use etendue::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The largest number of shards.
pub const MAX_SHARDS: u64 = 1000;

/// The largest numbers of seeds of a level in one shard, of levels, and of samples of a reference.
const MAX_SEEDS: u64 = 64;
const MAX_LEVELS: usize = 32;
const MAX_REFERENCE: u64 = 1 << 40;

/// A plan that all shards of a study share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyPlan {
    /// The name of each variant.
    pub variants: Vec<String>,
    /// The identity of each variant, and of the references at the end.
    pub identities: Vec<Fingerprint>,
    /// The number of shards.
    pub shards: u64,
    /// The seed of the study.
    pub seed: u64,
    /// Seconds for each shard.
    pub budget: f64,
    /// The size of the image.
    pub size: (u32, u32),
    /// The renders of each shard.
    pub schedule: Schedule,
    /// Seconds of each variant by samples, in units of its minimum.
    pub laws: Vec<TimeLaw>,
    /// Seconds of each variant by samples, as measured in the warm-up.
    pub warm_up: Vec<TimeLaw>,
    /// The time and the error of each variant at the scene's own size, if the image is smaller.
    pub own_size: Vec<Option<OwnSize>>,
    /// Warnings to the reader.
    pub warnings: Vec<String>,
}

impl StudyPlan {
    /// Writes the plan to a file, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| Error::render("cannot write the plan").because(error))?;
        write_text(path, &text)
    }

    /// Reads a plan.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a plan.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::io("cannot read the plan of the study", path, error))?;
        let not_one =
            |why: &str| Error::scene(format!("is not the plan of a study: {why}")).in_file(path);
        let plan: Self = serde_json::from_str(&text)
            .map_err(|error| not_one(&error.to_string()).because(error))?;
        match (1..=MAX_SHARDS).contains(&plan.shards) {
            true => Ok(plan),
            false => Err(not_one(&format!(
                "expected at most {MAX_SHARDS} shards instead of {}",
                plan.shards
            ))),
        }
    }

    /// The memory of the images of this many shards, in bytes.
    pub fn memory(&self, shards: u64) -> u64 {
        let pixels = u64::from(self.size.0) * u64::from(self.size.1);
        let images = self.schedule.renders().saturating_add(2);
        let of_image = pixels.saturating_mul(size_of::<[f32; 3]>() as u64);
        images.saturating_mul(of_image).saturating_mul(shards)
    }

    /// The settings of a part of the study, from those of its command.
    pub(super) fn settings(&self, of_command: &StudySettings) -> StudySettings {
        StudySettings {
            budget: self.budget,
            shards: self.shards,
            schedule: Some(self.schedule.clone()),
            may_shrink: false,
            ..of_command.clone()
        }
    }

    /// Refuses a plan of other identities, of another seed, or that no study of an image of this size writes.
    pub(super) fn check(
        &self,
        identities: &[Fingerprint],
        settings: &StudySettings,
        full_size: (u32, u32),
    ) -> Result<()> {
        let mut differences = Vec::new();
        let names = settings.variants.iter().map(|variant| &variant.name);
        if !names.eq(&self.variants) {
            let names = settings.variants.iter().map(|it| it.name.as_str());
            differences.push(format!(
                "the variants are {} in the plan, {} in this command",
                self.variants.join("; "),
                names.collect::<Vec<_>>().join("; ")
            ));
        }
        if self.seed != settings.seed {
            differences.push(format!(
                "the seed is {} in the plan, {} in this command",
                self.seed, settings.seed
            ));
        }
        for (ours, theirs) in identities.iter().zip(&self.identities) {
            for difference in ours.differences(theirs, "this command", "the plan") {
                if !differences.contains(&difference) {
                    differences.push(difference);
                }
            }
        }
        if !differences.is_empty() {
            return Err(Error::usage(format!(
                "the study was planned for something else: {}",
                differences.join("; ")
            )));
        }
        let variants = settings.variants.len();
        let lengths = [self.laws.len(), self.warm_up.len(), self.own_size.len()];
        let is_identified = self.identities.len() == identities.len();
        let seeds = &self.schedule.seeds;
        let is_possible = (1..=MAX_SHARDS).contains(&self.shards)
            && (1..=full_size.0).contains(&self.size.0)
            && (1..=full_size.1).contains(&self.size.1)
            && self.budget > 0.0
            && lengths == [variants; 3]
            && is_identified
            && seeds.len() == variants
            && seeds.iter().all(|it| (1..=MAX_LEVELS).contains(&it.len()))
            && seeds
                .iter()
                .flatten()
                .all(|it| (1..=MAX_SEEDS).contains(it))
            && (1..=MAX_REFERENCE).contains(&self.schedule.reference_spp);
        match is_possible {
            true => Ok(()),
            false => Err(Error::scene(
                "the plan of the study is damaged: no study has such renders",
            )),
        }
    }
}
