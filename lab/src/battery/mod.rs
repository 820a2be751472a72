//! The battery of hard cases: scenes and formulas with exact answers, on which renderers are known to fail.
//!
//! A case claims a number and measures it; [`run`] runs cases and tests the measurements against the claims. Each
//! subject has a file of its own.

pub mod albedo;
mod bidirectional;
pub mod case;
pub mod claim;
pub mod closed_forms;
mod direct_light;
mod film;
mod form_factor;
mod fresnel;
mod furnaces;
mod geometry;
pub mod irradiance;
mod lamps;
mod mirrors;
pub mod patch;
mod pictures;
pub mod report;
mod run;
mod scattering;
mod six_cases;
mod transport;
mod trial;

use case::{Case, Effort};
pub use run::{BatteryObserver, BatterySettings, NullBatteryObserver, run};

/// A group of cases about one subject.
pub struct CaseGroup {
    /// Name of the subject.
    pub name: &'static str,
    /// A sentence on what is measured.
    pub caption: &'static str,
    cases: fn(Effort) -> Vec<Case>,
}

const fn subject(
    name: &'static str,
    caption: &'static str,
    cases: fn(Effort) -> Vec<Case>,
) -> CaseGroup {
    CaseGroup {
        name,
        caption,
        cases,
    }
}

/// Every subject, in the order of the report.
pub const SUBJECTS: [CaseGroup; 13] = [
    subject(
        "Six cases that break renderers",
        "The cases of the first table with their errors. Radiance.",
        six_cases::cases,
    ),
    subject(
        "Scattering",
        "Reflected radiance under uniform illumination, by the cosine between view and normal.",
        scattering::cases,
    ),
    subject(
        "Fresnel's law",
        "Reflectances where the formulas suffer from cancellation.",
        fresnel::cases,
    ),
    subject(
        "Furnaces",
        "Radiance of white objects under a sky of radiance 1 (exact: 1), and energy lost by tilted normals.",
        furnaces::cases,
    ),
    subject(
        "Mirrors",
        "Radiance and directions after many reflections.",
        mirrors::cases,
    ),
    subject(
        "Direct light",
        "Radiance of a floor of albedo 1/2 under a light of radiance 1; form factors of discs and rectangles.",
        direct_light::cases,
    ),
    subject(
        "Lamps",
        "Solid angles, and the radiance of a floor of albedo 1/2.",
        lamps::cases,
    ),
    subject(
        "Geometry",
        "Counts of wrong ray queries; fractions of a shutter interval and of a lens.",
        geometry::cases,
    ),
    subject(
        "The same image",
        "Number of pixels of a small image that differ from the expected bits.",
        pictures::cases,
    ),
    subject(
        "Many bounces",
        "Radiance in closed rooms, where the exact value is a geometric series.",
        transport::cases,
    ),
    subject(
        "Light from both ends",
        "Bidirectional path tracing (bdpt) and Metropolis light transport (mlt): radiance, or its ratio to the exact radiance.",
        bidirectional::cases,
    ),
    subject(
        "Irradiance cache",
        "Number of points of a floor whose error against a closed form exceeds the bound; irradiance of a sphere over the exact value.",
        irradiance::cases,
    ),
    subject(
        "Film and camera",
        "Radiance of constant scenes.",
        film::cases,
    ),
];

/// Every case, in the order of the report.
pub fn cases(effort: Effort) -> Vec<Case> {
    let of_subject = |subject: &CaseGroup| {
        let name = subject.name;
        let cases = (subject.cases)(effort).into_iter();
        cases.map(move |case| case.about(name))
    };
    SUBJECTS.iter().flat_map(of_subject).collect()
}
