//! A study on several machines that share the output folder: its plan, its shards and their merge.
//!
//! Measure: as in the report.
//! Range: the folder gets `plan.json`, then `part-K.exr` for each shard, at last the files of any study.
//! Source: docs/cluster.md, "Studies". Tested in `cli/tests/command/study_shards.rs`.

use crate::Outcome;
use crate::durations::format_duration;
use crate::output::ConsoleObserver;
use crate::report::measurement::MeasurementObserver;
use etendue::internals::image::atomic::{check_creatable, make_folder};
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::state::Shard;
use etendue::{Error, ErrorKind, Result, memory};
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::settings::{StudyObserver, StudySettings};
use etendue_lab::study::shards::{self, ShardRequest, StudyPart, StudyPlan};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The number of missing shards that a message names.
const NAMED: usize = 10;

/// The scene and the settings of a study, and its folder.
pub struct Studied<'a> {
    pub description: &'a SceneDescription,
    pub full_size: (u32, u32),
    pub settings: &'a StudySettings,
    pub folder: &'a Path,
    pub is_quiet: bool,
    pub start: Instant,
}

impl Studied<'_> {
    fn plan_file(&self) -> PathBuf {
        self.folder.join("plan.json")
    }

    fn part_file(&self, shard: u64) -> PathBuf {
        self.folder.join(StudyPart::file_name(shard))
    }

    /// The file of a shard that was interrupted.
    fn begun_file(&self, shard: u64) -> PathBuf {
        self.folder.join(StudyPart::begun_file_name(shard))
    }

    /// Reads the plan.
    fn planned(&self) -> Result<StudyPlan> {
        let file = self.plan_file();
        if !file.exists() {
            return Err(Error::new(
                ErrorKind::Io,
                "is missing: plan the study first, with --shards N and the same -o",
            )
            .in_file(file));
        }
        StudyPlan::read(&file)
    }

    /// Plans the study and writes the plan.
    pub fn plan(&self, console: &ConsoleObserver) -> Result<Outcome> {
        let file = self.plan_file();
        if file.exists() {
            return Err(Error::usage(
                "there is a plan already: choose another folder, or delete the plan and all shards",
            )
            .in_file(file));
        }
        make_folder(self.folder)?;
        check_creatable(&file)?;
        let shown = ShardProgress(MeasurementObserver::new(console));
        let plan = shards::plan(
            self.description,
            self.full_size,
            self.settings,
            self.start,
            &shown,
        );
        console.finish();
        if !matches!(plan, Ok(Some(_))) {
            // A new folder without a plan is of no use.
            let _ = std::fs::remove_dir(self.folder);
        }
        let Some(plan) = plan? else {
            return Ok(Outcome::Interrupted);
        };
        plan.write(&file)?;
        if !self.is_quiet {
            say!(
                "{}: {} shards of about {} each; next, --shard 0/{} to {}/{}, then --merge",
                file.display(),
                plan.shards,
                format_duration(Duration::from_secs_f64(plan.budget)),
                plan.shards,
                plan.shards - 1,
                plan.shards
            );
        }
        Ok(Outcome::Done)
    }

    /// Renders a shard, or the rest of it, and writes it.
    pub fn render(&self, shard: Shard, console: &ConsoleObserver) -> Result<Outcome> {
        let plan = self.planned()?;
        let index = match shard {
            Shard::Part { index, of } if of == plan.shards => index,
            Shard::Part { of, .. } => {
                return Err(Error::usage(format!(
                    "--shard: the study is planned for {} shards, not {of}",
                    plan.shards
                )));
            }
            Shard::Samples { .. } => {
                return Err(Error::usage(
                    "--shard: expected K/N, such as 0/16: a study is not divided by samples",
                ));
            }
        };
        let (file, begun_file) = (self.part_file(index), self.begun_file(index));
        check_creatable(&file)?;
        check_creatable(&begun_file)?;
        let begun = begun_file.exists();
        let begun = begun.then(|| StudyPart::read_begun(&begun_file));
        let request = ShardRequest {
            shard: index,
            begun: begun.transpose()?,
        };
        let shown = ShardProgress(MeasurementObserver::new(console));
        let part = shards::render(
            self.description,
            self.full_size,
            self.settings,
            &plan,
            request,
            self.start,
            &shown,
        );
        console.finish();
        let Some(part) = part? else {
            return Ok(Outcome::Interrupted);
        };
        if !part.is_whole() {
            part.write(&begun_file)?;
            if !self.is_quiet {
                say!(
                    "{}: {} of {} renders; the same command continues from them",
                    begun_file.display(),
                    part.renders.len(),
                    plan.schedule.renders()
                );
            }
            return Ok(Outcome::Interrupted);
        }
        part.write(&file)?;
        if begun_file.exists() {
            let removed = std::fs::remove_file(&begun_file);
            removed.map_err(|error| Error::io("cannot delete", &begun_file, error))?;
        }
        if !self.is_quiet {
            let time = format_duration(self.start.elapsed());
            say!("{}: done after {time}", file.display());
        }
        Ok(Outcome::Done)
    }

    /// Reads the plan and the shards that are there; an error if some are missing, unless `is_partial`.
    pub fn parts(&self, is_partial: bool) -> Result<(StudyPlan, Vec<StudyPart>)> {
        let plan = self.planned()?;
        let (there, missing): (Vec<u64>, Vec<u64>) =
            (0..plan.shards).partition(|&shard| self.part_file(shard).exists());
        if !missing.is_empty() && !is_partial {
            let named = missing.iter().take(NAMED).map(u64::to_string);
            let named = named.collect::<Vec<_>>().join(", ");
            let and_more = if missing.len() > NAMED { " ..." } else { "" };
            return Err(Error::usage(format!(
                "{} of {} shards are missing in {}: {named}{and_more}; render them by --shard K/{}, or add --partial",
                missing.len(),
                plan.shards,
                self.folder.display(),
                plan.shards
            )));
        }
        // While a file is read, its images are in memory twice more.
        let bytes = plan.memory(there.len() as u64 + 2);
        memory::check(bytes, || format!("the images of {} shards", there.len()))?;
        let parts = there
            .iter()
            .map(|&shard| StudyPart::read(&self.part_file(shard)));
        let parts = parts.collect::<Result<_>>()?;
        Ok((plan, parts))
    }

    /// The report of the merged study.
    pub fn merge(
        &self,
        plan: &StudyPlan,
        parts: Vec<StudyPart>,
        observer: &dyn StudyObserver,
    ) -> Result<StudyReport> {
        shards::merge(
            self.description,
            self.full_size,
            self.settings,
            plan,
            parts,
            self.start,
            observer,
        )
    }
}

/// Shows progress and forwards Ctrl-C; there are no results to keep.
struct ShardProgress<'a>(MeasurementObserver<'a>);

impl StudyObserver for ShardProgress<'_> {
    fn progress(&self, fraction: f64, what: &str) {
        self.0.show(fraction, what);
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
