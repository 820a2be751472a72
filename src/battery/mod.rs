//! The battery of hard cases: scenes and formulas with exact answers, on which renderers are known to break.
//!
//! A case claims a number and says how to measure it; [`run`] measures cases and holds them against their claims. The
//! cases stand in one file a subject.

pub mod albedo;
pub mod case;
pub mod claim;
pub mod closed_forms;
mod direct_light;
mod film;
mod form_factor;
mod fresnel;
mod furnaces;
mod geometry;
mod lamps;
mod mirrors;
mod pictures;
pub mod report;
mod run;
mod scattering;
mod six_cases;
pub mod staging;
mod transport;

use case::{Case, Effort};
pub use run::{BatteryObserver, BatterySettings, Unattended, run};

/// Every case, in the order of the report.
pub fn cases(effort: Effort) -> Vec<Case> {
    let subjects: [(&'static str, fn(Effort) -> Vec<Case>); 11] = [
        ("Six cases that break renderers", six_cases::cases),
        ("Scattering", scattering::cases),
        ("Fresnel's law", fresnel::cases),
        ("Furnaces", furnaces::cases),
        ("Mirrors", mirrors::cases),
        ("Direct light", direct_light::cases),
        ("Lamps", lamps::cases),
        ("Geometry", geometry::cases),
        ("The same picture", pictures::cases),
        ("Many bounces", transport::cases),
        ("Film and camera", film::cases),
    ];
    let cases = subjects
        .into_iter()
        .flat_map(|(subject, cases)| cases(effort).into_iter().map(|case| case.about(subject)));
    cases.collect()
}
