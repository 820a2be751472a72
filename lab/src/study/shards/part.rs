//! The renders of one shard of a study, as an OpenEXR file: the first reference is its image, all others are layers, and
//! their times are metadata.
//!
//! Measure: radiance, seconds.
//! Range: a file that is not a shard of its own plan is an error.
//! Source: none needed. Tested in `lab/tests/reports/study_shards.rs`.

use super::super::clock::Seconds;
use super::super::reference_renders::ReferenceRenders;
use super::super::runner::LevelRender;
use super::super::schedule::Task;
use super::plan::StudyPlan;
use etendue::internals::image::{
    ColourSpace, Image, LayeredImage, MetadataValue, WriteOptions, write,
};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::convergence::ErrorRecord;
use etendue::internals::session::layers::channels;
use etendue::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::Path;

/// The metadata value that has everything but pixels, without the prefix of this program's.
const FACTS: &str = "study";

/// One shard of a study.
#[derive(Debug, Clone)]
pub struct StudyPart {
    /// The plan by which it was rendered.
    pub plan: StudyPlan,
    /// The shard, counted from 0.
    pub shard: u64,
    /// Its renders of the references.
    pub references: ReferenceRenders,
    /// Its renders of all levels, in the order in which they were rendered.
    pub renders: Vec<LevelRender>,
}

/// All data of a shard except its pixels.
#[derive(Serialize, Deserialize)]
struct ShardMetadata {
    plan: StudyPlan,
    shard: u64,
    reference_spp: u64,
    reference_seconds: [Seconds; 2],
    reference_seeds: [u64; 2],
    renders: Vec<RenderFacts>,
}

/// All data of a render except its pixels.
#[derive(Serialize, Deserialize)]
struct RenderFacts {
    task: Task,
    seed: u64,
    #[serde(rename = "look")]
    error_record: Option<ErrorRecord>,
    seconds: Seconds,
    repeated: bool,
    disturbed: bool,
    rejected: u64,
}

impl StudyPart {
    /// The name of the file of a shard.
    pub fn file_name(shard: u64) -> String {
        format!("part-{shard}.exr")
    }

    /// The name of the file of a shard that was interrupted.
    pub fn begun_file_name(shard: u64) -> String {
        format!("begun-{shard}.exr")
    }

    /// Writes the shard to an OpenEXR file, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let ReferenceRenders {
            spp,
            images: [first, second],
            seconds,
            seeds,
        } = &self.references;
        let facts = ShardMetadata {
            plan: self.plan.clone(),
            shard: self.shard,
            reference_spp: *spp,
            reference_seconds: *seconds,
            reference_seeds: *seeds,
            renders: self.renders.iter().map(facts_of).collect(),
        };
        let facts = serde_json::to_string(&facts)
            .map_err(|error| Error::render("cannot write the shard").because(error))?;
        let renders = self.renders.iter().enumerate();
        let named = renders.map(|(index, render)| (layer_name(index), &render.image));
        let all = named.chain([(SECOND_REFERENCE.to_owned(), second)]);
        let mut layers = Vec::new();
        for (name, image) in all {
            layers.extend(channels(&name, image));
        }
        let options = WriteOptions {
            metadata: vec![(format!("etendue.{FACTS}"), MetadataValue::Text(facts))],
            layers,
            ..WriteOptions::default()
        };
        write(path, first, &options)
    }

    /// Reads a whole shard.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a whole shard of a study.
    pub fn read(path: &Path) -> Result<Self> {
        let part = Self::read_begun(path)?;
        match part.is_whole() {
            true => Ok(part),
            false => Err(not_one("its renders are not those of its plan").in_file(path)),
        }
    }

    /// Reads a shard that may lack renders.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a shard of a study.
    pub fn read_begun(path: &Path) -> Result<Self> {
        let file = LayeredImage::read(path, ColourSpace::Linear)?;
        Self::of(&file).map_err(|error| error.in_file(path))
    }

    /// Whether it has all renders of its plan.
    pub fn is_whole(&self) -> bool {
        self.renders.len() as u64 == self.plan.schedule.renders()
    }

    fn of(file: &LayeredImage) -> Result<Self> {
        let Some(MetadataValue::Text(facts)) = file.fact(FACTS) else {
            return Err(not_one(
                "expected a file that `etendue study --shard` wrote",
            ));
        };
        let facts: ShardMetadata = serde_json::from_str(facts).map_err(|error| {
            not_one(&format!("its metadata cannot be read: {error}")).because(error)
        })?;
        let image_of = |name: &str| {
            let names = ["R", "G", "B"].map(|channel| format!("{name}.{channel}"));
            let [r, g, b] = names.each_ref().map(|channel| file.layer(channel));
            let (Some(r), Some(g), Some(b)) = (r, g, b) else {
                return Err(not_one(&format!("it has no layer `{name}`")));
            };
            let pixels = r.iter().zip(g).zip(b);
            let pixels: Vec<Rgb> = pixels.map(|((&r, &g), &b)| Rgb::new(r, g, b)).collect();
            match pixels.iter().all(|pixel| pixel.is_finite()) {
                true => Ok(Image::new(file.image.width(), file.image.height(), pixels)),
                false => Err(not_one(&format!("its layer `{name}` is not finite"))),
            }
        };
        let renders = facts.renders.iter().enumerate().map(|(index, facts)| {
            Ok(LevelRender {
                task: facts.task,
                seed: facts.seed,
                image: image_of(&layer_name(index))?,
                error_record: facts.error_record,
                seconds: facts.seconds,
                repeated: facts.repeated,
                disturbed: facts.disturbed,
                rejected: facts.rejected,
            })
        });
        let part = Self {
            shard: facts.shard,
            references: ReferenceRenders {
                spp: facts.reference_spp,
                images: [file.image.clone(), image_of(SECOND_REFERENCE)?],
                seconds: facts.reference_seconds,
                seeds: facts.reference_seeds,
            },
            renders: renders.collect::<Result<_>>()?,
            plan: facts.plan,
        };
        match part.is_planned() {
            true => Ok(part),
            false => Err(not_one("its renders are not those of its plan")),
        }
    }

    /// Whether the part has only renders of its plan, each once, in times that are possible.
    fn is_planned(&self) -> bool {
        let StudyPlan { schedule, size, .. } = &self.plan;
        let image = &self.references.images[0];
        let is_planned = |task: &Task| {
            let levels = schedule.seeds.get(task.variant);
            let count = levels.and_then(|levels| levels.get(task.level as usize));
            count.is_some_and(|&count| task.seed < count)
        };
        let tasks: HashSet<Task> = self.renders.iter().map(|render| render.task).collect();
        let is_time = |seconds: &Seconds| seconds.wall > 0.0 && seconds.wall.is_finite();
        tasks.iter().all(is_planned)
            && (image.width(), image.height()) == *size
            && self.shard < self.plan.shards
            && tasks.len() == self.renders.len()
            && self.renders.iter().all(|render| is_time(&render.seconds))
    }
}

fn not_one(what: &str) -> Error {
    Error::scene(format!("is not a shard of a study: {what}"))
}

/// The layer of the second reference.
const SECOND_REFERENCE: &str = "reference";

/// The name of the layer of a render.
fn layer_name(index: usize) -> String {
    format!("render{index:04}")
}

fn facts_of(render: &LevelRender) -> RenderFacts {
    RenderFacts {
        task: render.task,
        seed: render.seed,
        error_record: render.error_record,
        seconds: render.seconds,
        repeated: render.repeated,
        disturbed: render.disturbed,
        rejected: render.rejected,
    }
}
