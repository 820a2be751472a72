//! `etendue plan`: the effects that a scene needs with reasons, their costs, and the integrator that suits the scene.
//!
//! Measure: shares of the time and of the light, in percent.
//! Range: any scene that loads.
//! Source: none needed. Tested in `cli/tests/command/plan.rs`.

use super::args::{PlanArguments, ProgressMode};
use super::output::{ConsoleObserver, format_percent, time_left};
use super::recommendation::RecommendationReport;
use super::shard_plan::ShardPlan;
use super::{Outcome, print};
use etendue::Result;
use etendue::internals::effects::Effect;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterSampling};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::stats::Spread;
use etendue::internals::plan::{EffectFinding, Plan};
use etendue::internals::render::RenderObserver;
use etendue::internals::render::auto::Recommendation;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::{Place, SceneDescription};
use etendue::internals::session::Session;
use etendue_lab::study::effect_cost::{CostSettings, EffectCost, EffectCosts, effect_costs};
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

/// The approximate number of pixels of the renders that measure costs.
const PIXELS: f64 = 20_000.0;

/// The printed report.
#[derive(Debug, Serialize)]
struct PlanReport {
    scene: String,
    kernel: &'static str,
    /// Effects that the kernel has but the scene does not need.
    surplus: Vec<&'static str>,
    effects: Vec<EffectReport>,
    /// The time of the kernel with all effects over that of the chosen kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    everything: Option<Spread>,
    integrator: RecommendationReport,
    filter: FilterReport,
    /// The shards that bring the image to an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    shards: Option<ShardPlan>,
}

#[derive(Debug, Serialize)]
struct EffectReport {
    effect: &'static str,
    on: bool,
    why: String,
    #[serde(rename = "where")]
    place: Option<String>,
    leaves_out: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    cost: Option<CostReport>,
}

#[derive(Debug, Serialize)]
struct FilterReport {
    name: String,
    sampling: &'static str,
    /// The variance of light that varies little over a pixel by importance sampling, over that by splatting.
    gain_of_splatting: f64,
}

#[derive(Debug, Serialize)]
struct CostReport {
    time: Spread,
    energy: Option<f64>,
    energy_error: Option<f64>,
    energy_margin: Option<f64>,
}

pub fn run(arguments: &PlanArguments) -> Result<Outcome> {
    let accel = arguments.tracing.options();
    let mut description = arguments.scene.load()?;
    arguments.settings.apply_to(&mut description);
    let options = arguments.settings.options();
    // Invalid combinations of options are reported before anything slow starts.
    options.settings(&description)?;
    let session = Session::new(description, accel)?;
    let mut description = session.description().clone();
    let plan = Plan::new(&description, session.scene());
    let console = ConsoleObserver::new(ProgressMode::Auto)?;
    for note in session.notes() {
        say!("note: {note}");
    }
    let recommendation = session.recommend(&options, &Cancelling(&console))?;
    if console.is_cancelled() {
        return Ok(Outcome::Interrupted);
    }
    let mut costs = None;
    if arguments.cost {
        let (width, height) = description.film.size;
        let size = arguments.settings.size;
        description.film.size = size.unwrap_or_else(|| small(width, height));
        let settings = CostSettings {
            accel,
            spp: arguments.spp,
            rounds: arguments.rounds,
        };
        let Some(measured) = measure(&description, &plan, &settings, &console)? else {
            return Ok(Outcome::Interrupted);
        };
        costs = Some(measured);
    }
    let shards = ShardPlan::new(arguments, &session, &Cancelling(&console))?;
    if console.is_cancelled() {
        return Ok(Outcome::Interrupted);
    }
    let settings = RenderSettings {
        integrator: match options.integrator {
            None | Some(IntegratorKind::Auto) => recommendation.integrator,
            Some(named) => named,
        },
        ..options.settings(&description)?
    };
    let report = PlanReport {
        shards,
        ..report(
            &description,
            &plan,
            costs.as_ref(),
            &recommendation,
            &settings,
        )
    };
    if arguments.json {
        let json = serde_json::to_string_pretty(&report).expect("plain data always serialises");
        return print((json + "\n").as_bytes());
    }
    print(table(&report).as_bytes())
}

/// Returns an image size with the same aspect ratio and at most about 20 000 pixels, for renders that are repeated
/// often.
fn small(width: u32, height: u32) -> (u32, u32) {
    let scale = (PIXELS / (f64::from(width) * f64::from(height)))
        .sqrt()
        .min(1.0);
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    (side(width), side(height))
}

/// Forwards Ctrl-C, but not the progress of single renders.
pub struct Cancelling<'a>(pub &'a ConsoleObserver);

impl RenderObserver for Cancelling<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

fn measure(
    description: &SceneDescription,
    plan: &Plan,
    settings: &CostSettings,
    console: &ConsoleObserver,
) -> Result<Option<EffectCosts>> {
    let start = Instant::now();
    let costs = effect_costs(description, plan, settings, &Cancelling(console), |done| {
        let left = time_left(done, start.elapsed()).unwrap_or_default();
        console.show(done, || format!("measuring costs, {left} left"));
    });
    console.finish();
    costs
}

fn report(
    description: &SceneDescription,
    plan: &Plan,
    costs: Option<&EffectCosts>,
    recommendation: &Recommendation,
    settings: &RenderSettings,
) -> PlanReport {
    let kernel = plan.kernel.effects();
    let surplus = plan
        .findings
        .iter()
        .filter(|f| !f.on && kernel.has(f.effect));
    let cost_of = |effect| {
        let costs = costs?.effects.iter();
        costs.clone().find(|cost| cost.effect == effect)
    };
    PlanReport {
        scene: description.file.display().to_string(),
        kernel: plan.kernel.name(),
        surplus: surplus.map(|finding| finding.effect.name()).collect(),
        effects: plan
            .findings
            .iter()
            .map(|finding| effect_report(finding, cost_of(finding.effect)))
            .collect(),
        everything: costs.map(|costs| costs.everything),
        integrator: recommendation.into(),
        filter: filter_report(&description.film.filter, settings),
        shards: None,
    }
}

fn filter_report(description: &FilterDescription, settings: &RenderSettings) -> FilterReport {
    let filter = Filter::new(description);
    FilterReport {
        name: description.name(),
        sampling: settings.filter_sampling_of(&filter).name(),
        gain_of_splatting: filter.gain_of_splatting(),
    }
}

fn effect_report(finding: &EffectFinding, cost: Option<&EffectCost>) -> EffectReport {
    EffectReport {
        effect: finding.effect.name(),
        on: finding.on,
        why: finding.why.clone(),
        place: finding.place.as_ref().and_then(place_text),
        leaves_out: finding.effect.leaves_out(),
        cost: cost.map(|cost| CostReport {
            time: cost.time,
            energy: cost.energy.is_finite().then_some(cost.energy),
            energy_error: cost.energy_error.is_finite().then_some(cost.energy_error),
            energy_margin: cost.energy_margin.is_finite().then_some(cost.energy_margin),
        }),
    }
}

/// Formats a place as `file:line`, which editors accept; `None` if there is no file.
fn place_text(place: &Place) -> Option<String> {
    let file = place.file.display();
    match place.line {
        Some(line) => Some(format!("{file}:{line}")),
        None if place.file.as_os_str().is_empty() => None,
        None => Some(file.to_string()),
    }
}

fn table(report: &PlanReport) -> String {
    let mut text = format!("{}\n\n", report.scene);
    let width = Effect::ALL.iter().map(|effect| effect.name().len()).max();
    let width = width.unwrap_or(0);
    for effect in &report.effects {
        let state = if effect.on { "on " } else { "off" };
        let place = effect
            .place
            .as_ref()
            .map_or(String::new(), |p| format!(" ({p})"));
        line(
            &mut text,
            format!("{:width$}  {state}  {}{place}", effect.effect, effect.why),
        );
        let detail = match &effect.cost {
            _ if !effect.on => format!("left out: {}", effect.leaves_out),
            Some(cost) => describe_cost(cost),
            None => continue,
        };
        line(&mut text, format!("{:width$}       {detail}", ""));
    }
    let on = report.effects.iter().filter(|effect| effect.on).count();
    let effects = if on == 1 { "effect" } else { "effects" };
    let surplus = match report.surplus.as_slice() {
        [] => "no other".to_owned(),
        names => format!("also {}", names.join(", ")),
    };
    line(&mut text, String::new());
    line(
        &mut text,
        format!(
            "kernel: {} ({on} {effects} of the scene; {surplus})",
            report.kernel
        ),
    );
    if report.everything.is_some() {
        line(
            &mut text,
            "costs: by the integrator path at its defaults, without light paths and shared paths; +- has a confidence of 95 %".to_owned(),
        );
    }
    if let Some(everything) = &report.everything {
        line(
            &mut text,
            format!(
                "the kernel with everything takes {:.3} times as long ({:.3} to {:.3})",
                everything.median, everything.min, everything.max
            ),
        );
    }
    for said in report.integrator.lines() {
        line(&mut text, said);
    }
    let FilterReport {
        name,
        sampling,
        gain_of_splatting,
    } = &report.filter;
    let gain = match *sampling == FilterSampling::Splatting.name() {
        true => format!(
            " (where light varies little, {gain_of_splatting:.2} times less squared error than by importance sampling)"
        ),
        false => String::new(),
    };
    line(&mut text, format!("filter: {name}, {sampling}{gain}"));
    if let Some(shards) = &report.shards {
        line(&mut text, shards.describe());
    }
    text
}

fn line(text: &mut String, line: String) {
    writeln!(text, "{}", line.trim_end()).expect("writing to a string cannot fail");
}

fn describe_cost(cost: &CostReport) -> String {
    let time = &cost.time;
    let energy = match (cost.energy, cost.energy_margin) {
        (Some(energy), Some(margin)) => format!(
            "{} +- {} of the light",
            format_percent(energy),
            format_percent(margin)
        ),
        _ => "the image is black".to_owned(),
    };
    format!(
        "{} of the time ({} to {}), {energy}",
        format_percent(time.median),
        format_percent(time.min),
        format_percent(time.max)
    )
}
