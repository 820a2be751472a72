//! Tests of studies in shards: the numbers of one study, the pace of different machines, and parts that do not belong
//! together.

use super::study::{scene, settings, study};
use etendue::internals::image::{ColourSpace, Image};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::SamplerKind;
use etendue::{ErrorKind, Result};
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::schedule::Schedule;
use etendue_lab::study::settings::{NullStudyObserver, StudyObserver, StudySettings};
use etendue_lab::study::shards::{ShardRequest, StudyPart, StudyPlan, merge, plan, render};
use etendue_lab::study::summary::summaries;
use etendue_lab::study::variant::SettingValue;
use std::collections::HashSet;
use std::path::Path;
use std::time::Instant;

const SIZE: (u32, u32) = (16, 16);

/// Two variants in a schedule by which the images depend only on the seed.
fn two_variants(shards: u64) -> StudySettings {
    let samplers = [SamplerKind::Independent, SamplerKind::Sobol].map(SettingValue::Sampler);
    let schedule = Schedule {
        reference_spp: 64,
        seeds: vec![vec![3, 2, 2]; 2],
    };
    StudySettings {
        shards,
        ..settings(&samplers, 2.0, Some(schedule))
    }
}

fn planned(settings: &StudySettings) -> StudyPlan {
    let plan = plan(&scene(), SIZE, settings, Instant::now(), &NullStudyObserver);
    plan.expect("a valid study").expect("it was not cancelled")
}

fn part(settings: &StudySettings, plan: &StudyPlan, shard: u64) -> Result<StudyPart> {
    rest(settings, plan, shard, None)
}

/// The part that a request gives.
fn shard_of(
    settings: &StudySettings,
    plan: &StudyPlan,
    request: ShardRequest,
    observer: &dyn StudyObserver,
) -> Result<Option<StudyPart>> {
    let start = Instant::now();
    render(&scene(), SIZE, settings, plan, request, start, observer)
}

/// The whole part, given the renders of it that there are already.
fn rest(
    settings: &StudySettings,
    plan: &StudyPlan,
    shard: u64,
    begun: Option<StudyPart>,
) -> Result<StudyPart> {
    let part = shard_of(
        settings,
        plan,
        ShardRequest { shard, begun },
        &NullStudyObserver,
    )?;
    Ok(part.expect("it was not cancelled"))
}

fn merged(
    settings: &StudySettings,
    plan: &StudyPlan,
    parts: Vec<StudyPart>,
) -> Result<StudyReport> {
    let start = Instant::now();
    merge(
        &scene(),
        SIZE,
        settings,
        plan,
        parts,
        start,
        &NullStudyObserver,
    )
}

/// The part as its file has it.
fn through_file(part: &StudyPart, folder: &Path) -> StudyPart {
    let path = folder.join(StudyPart::file_name(part.shard));
    part.write(&path).expect("written");
    StudyPart::read(&path).expect("read")
}

#[test]
fn single_shard_has_the_errors_of_the_study() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = two_variants(1);
    let whole = study(&settings);
    let plan = planned(&settings);
    let path = folder.path().join("plan.json");
    plan.write(&path).expect("written");
    assert_eq!(StudyPlan::read(&path).expect("read"), plan);
    let part = through_file(&part(&settings, &plan, 0).expect("rendered"), folder.path());
    let one = merged(&settings, &plan, vec![part]).expect("merged");
    assert!(one.complete);
    for (a, b) in whole.variants.iter().zip(&one.variants) {
        assert_eq!(a.error_record, b.error_record);
        for (a, b) in a.levels.iter().zip(&b.levels) {
            assert_eq!((a.spp, &a.gram), (b.spp, &b.gram));
        }
        assert!(b.bars.is_some());
    }
    let [a, b] = [whole, one].map(|it| it.reference.expect("rendered"));
    assert_eq!(
        (a.seeds, a.luminances, a.spp),
        (b.seeds, b.luminances, b.spp)
    );
}

#[test]
fn shards_have_seeds_of_their_own_and_merge_to_more_renders() {
    let settings = two_variants(2);
    let plan = planned(&settings);
    let parts = [0, 1].map(|shard| part(&settings, &plan, shard).expect("rendered"));
    let seeds = parts.iter().flat_map(|part| {
        let levels = part.renders.iter().map(|render| render.seed);
        levels.chain(part.references.seeds).collect::<Vec<u64>>()
    });
    let seeds: Vec<u64> = seeds.collect();
    let distinct: HashSet<u64> = seeds.iter().copied().collect();
    assert_eq!((seeds.len(), distinct.len()), (32, 32));

    let report = merged(&settings, &plan, parts.to_vec()).expect("merged");
    let whole = study(&two_variants(1));
    for (all, one) in report.variants.iter().zip(&whole.variants) {
        let logarithms = all.levels.iter().zip(&one.levels).map(|(all, one)| {
            assert_eq!(all.runs.len(), 2 * one.runs.len());
            let [a, b] = [all, one].map(|level| level.gram.mse().expect("several").value);
            (a / b).ln()
        });
        // The error of a render of 256 pixels deviates by some 30 %, and so the mean of these by some 15 %. Renders of twice the
        // samples, as those of mixed-up levels would be, differ by 0.7 at least.
        let mean = logarithms.sum::<f64>() / all.levels.len() as f64;
        assert!(mean.abs() < 0.5, "{mean}");
    }
    assert!(summaries(&report).iter().all(|(_, it)| !it.bias.is_found));
    let reference = report.reference.as_ref().expect("rendered");
    assert_eq!(reference.spp, 128);

    // The order of shards changes no error.
    let [one, two] = parts;
    let turned = merged(&settings, &plan, vec![two, one]).expect("merged");
    for (a, b) in report.variants.iter().zip(&turned.variants) {
        for (a, b) in a.levels.iter().zip(&b.levels) {
            let [a, b] = [a, b].map(|level| level.gram.mse().expect("several").value);
            assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
        }
    }
}

#[test]
fn times_are_those_of_the_mean_pace_and_ratios_those_of_one_machine() {
    let settings = two_variants(2);
    let plan = planned(&settings);
    let mut parts = [0, 1].map(|shard| part(&settings, &plan, shard).expect("rendered"));
    // Both machines take as long for each render, so that the clock decides nothing.
    for part in &mut parts {
        for render in &mut part.renders {
            let seconds = 0.01 * f64::from(1 << render.task.level);
            render.seconds.wall = seconds * (1.0 + 0.5 * render.task.variant as f64);
            render.seconds.cpu = 2.0 * render.seconds.wall;
        }
    }
    let even = merged(&settings, &plan, parts.to_vec()).expect("merged");
    // The second one becomes four times as slow.
    for render in &mut parts[1].renders {
        render.seconds.wall *= 4.0;
        render.seconds.cpu *= 4.0;
    }
    let uneven = merged(&settings, &plan, parts.to_vec()).expect("merged");
    let [even, uneven] = [even, uneven].map(|report| {
        let differ = report.warnings.iter().any(|it| it.contains("slowest"));
        (differ, summaries(&report))
    });
    assert_eq!([even.0, uneven.0], [false, true]);
    for ((_, even), (_, uneven)) in even.1.iter().zip(&uneven.1) {
        // The mean pace is the geometric one.
        assert!((uneven.time.sample / even.time.sample - 2.0).abs() < 1e-9);
        assert!((uneven.ratio.value / even.ratio.value - 1.0).abs() < 1e-9);
        assert!((uneven.ratio.high / even.ratio.high - 1.0).abs() < 1e-6);
    }
}

#[test]
fn parts_of_other_studies_are_refused() {
    let settings = two_variants(2);
    let plan = planned(&settings);
    let one = part(&settings, &plan, 0).expect("rendered");
    let refused =
        |settings: &StudySettings, plan: &StudyPlan, parts: Vec<StudyPart>, word: &str| {
            let error = merged(settings, plan, parts).expect_err(word);
            assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
            assert!(error.to_string().contains(word), "{word}: {error}");
        };
    refused(&settings, &plan, vec![], "no shard");
    refused(&settings, &plan, vec![one.clone(), one.clone()], "twice");
    let longer = StudyPlan {
        budget: 3.0,
        ..plan.clone()
    };
    refused(&settings, &longer, vec![one.clone()], "another plan");
    let of_seed = StudySettings {
        seed: 6,
        ..settings.clone()
    };
    refused(
        &of_seed,
        &plan,
        vec![one.clone()],
        "the seed is 5 in the plan",
    );
    let mut bounded = settings.clone();
    bounded.variants[1].settings.max_bounces = Some(3);
    refused(&bounded, &plan, vec![one.clone()], "max_bounces");
    let mut other = settings.clone();
    other.reference = IntegratorKind::Bidirectional;
    refused(&other, &plan, vec![one.clone()], "integrator");
    other = settings.clone();
    other.variants.pop();
    refused(&other, &plan, vec![one.clone()], "variants");
    // The kernel changes no bit, but the time.
    other = settings.clone();
    other.variants[1].name = "kernel everything".to_owned();
    refused(&other, &plan, vec![one], "variants");
    let error = part(&settings, &plan, 2).expect_err("there are two");
    assert!(error.to_string().contains("counted from 0"), "{error}");
}

#[test]
fn damaged_plans_and_parts_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = two_variants(2);
    let plan = planned(&settings);
    type Change = fn(&mut StudyPlan);
    let changes: [Change; 8] = [
        |plan| plan.shards = 0,
        |plan| plan.size = (0, 64),
        |plan| plan.size = (64, 1 << 20),
        |plan| plan.budget = -1.0,
        |plan| plan.schedule.seeds[1].clear(),
        |plan| plan.schedule.seeds[0][0] = u64::MAX,
        |plan| plan.schedule.reference_spp = 0,
        |plan| plan.laws.clear(),
    ];
    for (index, change) in changes.iter().enumerate() {
        let mut damaged = plan.clone();
        change(&mut damaged);
        let error = part(&settings, &damaged, 0).expect_err("damaged");
        let is_said = ["damaged", "counted from 0"]
            .iter()
            .any(|it| error.to_string().contains(it));
        assert!(is_said, "{index}: {error}");
    }
    let path = folder.path().join("plan.json");
    let huge = StudyPlan {
        shards: u64::MAX,
        ..plan.clone()
    };
    huge.write(&path).expect("written");
    let error = StudyPlan::read(&path).expect_err("too many");
    assert!(error.to_string().contains("1000 shards"), "{error}");
    std::fs::write(&path, "{\"shards\": 2}").expect("written");
    let error = StudyPlan::read(&path).expect_err("not a plan");
    assert_eq!(error.kind(), ErrorKind::Scene, "{error}");

    let part = part(&settings, &plan, 1).expect("rendered");
    let path = folder.path().join("part.exr");
    type PartChange = fn(&mut StudyPart);
    let changes: [PartChange; 6] = [
        |part| part.renders.truncate(3),
        |part| part.renders[1].task = part.renders[0].task,
        |part| part.renders[0].task.variant = 7,
        |part| part.renders[0].seconds.wall = 0.0,
        |part| part.shard = 2,
        |part| part.plan.size = (32, 32),
    ];
    for (index, change) in changes.iter().enumerate() {
        let mut damaged = part.clone();
        change(&mut damaged);
        damaged.write(&path).expect("written");
        let error = StudyPart::read(&path).expect_err("damaged");
        assert!(
            error.to_string().contains("not a shard"),
            "{index}: {error}"
        );
    }
    part.write(&path).expect("written");
    let bytes = std::fs::read(&path).expect("read");
    for length in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).expect("written");
        assert!(StudyPart::read(&path).is_err(), "{length}");
    }
    // An image of another program, or of a render.
    let image = Image::new(2, 2, vec![Default::default(); 4]);
    etendue::internals::image::write(&path, &image, &Default::default()).expect("written");
    assert!(Image::read(&path, ColourSpace::Linear).is_ok());
    let error = StudyPart::read(&path).expect_err("an image");
    assert!(error.to_string().contains("--shard"), "{error}");
}

/// Cancels at once.
struct Cancelling;

impl StudyObserver for Cancelling {
    fn is_cancelled(&self) -> bool {
        true
    }
}

#[test]
fn cancelled_plans_and_shards_give_nothing() {
    let settings = two_variants(2);
    let start = Instant::now();
    let none = plan(&scene(), SIZE, &settings, start, &Cancelling).expect("no error");
    assert!(none.is_none());
    let plan = planned(&settings);
    let request = ShardRequest::default();
    let none = shard_of(&settings, &plan, request, &Cancelling).expect("no error");
    assert!(none.is_none());
    let part = part(&settings, &plan, 0).expect("rendered");
    let report = merge(
        &scene(),
        SIZE,
        &settings,
        &plan,
        vec![part],
        start,
        &Cancelling,
    );
    assert!(!report.expect("a report").complete);
}

#[test]
fn interrupted_shard_continues_to_the_renders_of_a_whole_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = two_variants(2);
    let plan = planned(&settings);
    let whole = part(&settings, &plan, 1).expect("rendered");
    assert!(whole.is_whole());
    let mut begun = whole.clone();
    begun.renders.truncate(3);
    assert!(!begun.is_whole());
    let path = folder.path().join(StudyPart::begun_file_name(1));
    begun.write(&path).expect("written");
    assert!(StudyPart::read(&path).is_err());
    let begun = StudyPart::read_begun(&path).expect("read");
    // A cancelled shard keeps what it has.
    let request = ShardRequest {
        shard: 1,
        begun: Some(begun.clone()),
    };
    let kept = shard_of(&settings, &plan, request, &Cancelling);
    let kept = kept.expect("no error").expect("it was begun");
    assert_eq!(kept.renders.len(), 3);
    let continued = rest(&settings, &plan, 1, Some(begun.clone())).expect("rendered");
    assert!(continued.is_whole());
    for (a, b) in whole.renders.iter().zip(&continued.renders) {
        assert_eq!((a.task, a.seed, &a.image), (b.task, b.seed, &b.image));
    }
    for (index, (a, b)) in whole.renders.iter().zip(&continued.renders).enumerate() {
        assert_eq!(a.seconds == b.seconds, index < 3, "{index}");
    }
    let error = rest(&settings, &plan, 0, Some(begun)).expect_err("another shard");
    assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
}
