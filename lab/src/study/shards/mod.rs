//! A study on several machines: one plans it, each renders a shard of its levels and of its references, and one merges them.
//!
//! All shards have the same tasks with seeds of their own, and all variants, so that ratios compare renders of one machine.
//!
//! Measure: as in the report.
//! Range: shards of the same scene, settings and program as the plan; with two shards or more, every level has two renders.
//! Source: docs/cluster.md, "Studies". Tested in `lab/tests/reports/study_shards.rs` and `cli/tests/command/study_shards.rs`.

mod pace;
mod part;
mod plan;

use super::compared_renders::ComparedRenders;
use super::report::StudyReport;
use super::run::{Study, order, resolved};
use super::runner::Runner;
use super::schedule::Task;
use super::settings::{StudyClock, StudyObserver, StudySettings};
use etendue::internals::render::RenderObserver;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::state::{Fingerprint, fingerprint};
use etendue::{Error, Result};
pub use part::StudyPart;
pub use plan::{MAX_SHARDS, StudyPlan};
use std::collections::HashSet;
use std::time::Instant;

/// Plans a study of `settings.shards` shards, each of which takes the budget; `None` if it was cancelled.
///
/// # Errors
/// As [`super::run()`].
pub fn plan(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    start: Instant,
    observer: &dyn StudyObserver,
) -> Result<Option<StudyPlan>> {
    let mut clock = StudyClock::new(start, observer, settings);
    let (prepared, settings) = resolved(description, settings, &mut clock)?;
    let mut study = Study::new(description, full_size, &settings, prepared);
    let identities = identities(&study)?;
    clock.begin("measuring the cost of renders");
    let Some((costs, schedule)) = study.plan(&clock)? else {
        return Ok(None);
    };
    Ok(Some(StudyPlan {
        variants: settings.variants.iter().map(|it| it.name.clone()).collect(),
        identities,
        shards: settings.shards,
        seed: settings.seed,
        budget: settings.budget,
        size: study.prepared.size(),
        schedule,
        laws: costs.laws,
        warm_up: study.report.variants.iter().map(|it| it.warm_up).collect(),
        own_size: study.report.variants.iter().map(|it| it.own_size).collect(),
        warnings: study.report.warnings,
    }))
}

/// A shard to be rendered.
#[derive(Debug, Clone, Default)]
pub struct ShardRequest {
    /// Its number, from 0.
    pub shard: u64,
    /// The renders of it that there are already.
    pub begun: Option<StudyPart>,
}

/// Renders a shard. If it is cancelled, the part is not whole; `None` if not even its references are there. The budget and the
/// schedule are those of the plan.
///
/// # Errors
/// Another scene, other settings or another program than the plan's, a shard that it does not have, renders of another shard
/// or by another plan, or a render that fails.
pub fn render(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    plan: &StudyPlan,
    request: ShardRequest,
    start: Instant,
    observer: &dyn StudyObserver,
) -> Result<Option<StudyPart>> {
    let ShardRequest { shard, begun } = request;
    if shard >= plan.shards {
        return Err(Error::usage(format!(
            "there is no shard {shard}/{}: the plan has {} shards, counted from 0",
            plan.shards, plan.shards
        )));
    }
    if begun
        .as_ref()
        .is_some_and(|begun| begun.plan != *plan || begun.shard != shard)
    {
        return Err(Error::usage(format!(
            "{} has renders of another shard or by another plan: delete it",
            StudyPart::begun_file_name(shard)
        )));
    }
    let settings = plan.settings(settings);
    let mut clock = StudyClock::new(start, observer, &settings);
    let (prepared, settings) = resolved(description, &settings, &mut clock)?;
    let mut study = Study::new(description, full_size, &settings, prepared);
    follow(plan, &mut study)?;
    let mut part = match begun {
        Some(begun) => begun,
        None => {
            clock.begin("rendering two references");
            let spp = plan.schedule.reference_spp;
            let Some(references) = study.reference_renders(spp, shard, &clock)? else {
                return Ok(None);
            };
            StudyPart {
                plan: plan.clone(),
                shard,
                references,
                renders: Vec::new(),
            }
        }
    };
    clock.begin("rendering all levels in turn");
    let mut runner = Runner::new(&settings, &study.prepared, &clock, &plan.schedule, shard);
    let done: HashSet<Task> = part.renders.iter().map(|render| render.task).collect();
    let tasks = plan.schedule.blocks(order(&settings)).into_iter().flatten();
    for task in tasks.filter(|task| !done.contains(task)) {
        let Some(render) = runner.render(task, 0.0)? else {
            break;
        };
        part.renders.push(render);
    }
    Ok(Some(part))
}

/// Merges shards to a whole study; this machine measures the error bars and the sources of time and variance. Times are
/// those of a machine of the mean pace of all.
///
/// # Errors
/// No shards, one of another plan, one that is given twice, or an error of [`super::run()`].
pub fn merge(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    plan: &StudyPlan,
    parts: Vec<StudyPart>,
    start: Instant,
    observer: &dyn StudyObserver,
) -> Result<StudyReport> {
    check_parts(plan, &parts)?;
    let settings = plan.settings(settings);
    let mut clock = StudyClock::new(start, observer, &settings);
    let (prepared, settings) = resolved(description, &settings, &mut clock)?;
    let mut study = Study::new(description, full_size, &settings, prepared);
    follow(plan, &mut study)?;
    let finished = merge_into(&mut study, plan, parts, &mut clock)?;
    Ok(study.ended(finished, &clock))
}

/// Refuses parts that are not those of a study.
fn check_parts(plan: &StudyPlan, parts: &[StudyPart]) -> Result<()> {
    if parts.is_empty() {
        return Err(Error::usage("no shard of the study is there"));
    }
    for (index, part) in parts.iter().enumerate() {
        let StudyPart { shard, .. } = part;
        if part.plan != *plan {
            return Err(Error::usage(format!(
                "shard {shard} was rendered by another plan: render it again"
            )));
        }
        if parts[..index].iter().any(|other| other.shard == *shard) {
            return Err(Error::usage(format!("shard {shard} was given twice")));
        }
    }
    Ok(())
}

/// Merges parts into an empty study; `None` if it was cancelled.
fn merge_into(
    study: &mut Study<'_>,
    plan: &StudyPlan,
    mut parts: Vec<StudyPart>,
    clock: &mut StudyClock<'_>,
) -> Result<Option<()>> {
    clock.begin("measuring the gain by threads");
    if study.scaling(&plan.laws, clock)?.is_none() {
        return Ok(None);
    }
    clock.begin("comparing the renders of all shards");
    let schedule = plan.schedule.of_shards(parts.len() as u64);
    study.report.schedule = Some(schedule.clone());
    if let Some(warning) = pace::to_mean_pace(&mut parts) {
        study.report.warn(warning);
    }
    if parts.len() < plan.shards as usize {
        study.report.warn(format!(
            "merged from {} of {} shards",
            parts.len(),
            plan.shards
        ));
    }
    let (of_references, renders): (Vec<_>, Vec<_>) = parts
        .into_iter()
        .map(|part| (part.references, part.renders))
        .unzip();
    let references = study.references(&of_references)?;
    let mut compared = ComparedRenders::new(&references, &schedule);
    let mut renders: Vec<_> = renders.into_iter().map(Vec::into_iter).collect();
    // The shards in turn, so that the report of a cancelled merge has as much of each.
    loop {
        let round: Vec<_> = renders.iter_mut().filter_map(Iterator::next).collect();
        if round.is_empty() {
            break;
        }
        for render in round {
            if clock.is_cancelled() {
                return Ok(None);
            }
            compared.take(render, &mut study.report);
        }
    }
    pace::own_size_to_mean_pace(&mut study.report);
    study.publish(clock);
    study.after_levels(compared, &references, &plan.laws, clock)
}

/// Lets a study follow a plan.
fn follow(plan: &StudyPlan, study: &mut Study<'_>) -> Result<()> {
    plan.check(&identities(study)?, study.settings, study.prepared.size())?;
    if plan.size != study.prepared.size() {
        study.on_film(plan.size);
    }
    for warning in &plan.warnings {
        study.report.warn(warning);
    }
    study.begin_levels(&plan.schedule);
    for (index, variant) in study.report.variants.iter_mut().enumerate() {
        variant.warm_up = plan.warm_up[index];
        variant.own_size = plan.own_size[index];
    }
    Ok(())
}

/// The identities of all variants, and that of the references.
fn identities(study: &Study<'_>) -> Result<Vec<Fingerprint>> {
    let reference = study.reference_variant();
    let variants = study.settings.variants.iter().chain([&reference]);
    variants
        .map(|variant| fingerprint(&study.description, &variant.settings, variant.options))
        .collect()
}
