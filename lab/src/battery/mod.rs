//! The battery of hard cases: scenes and formulas with exact answers, on which renderers are known to break.
//!
//! A case claims a number and says how to measure it; [`run`] measures cases and holds them against their claims. The
//! cases stand in one file a subject.

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
pub use run::{BatteryObserver, BatterySettings, Unattended, run};

/// What cases have in common.
pub struct Subject {
    /// Its name.
    pub name: &'static str,
    /// What is measured, in a sentence.
    pub says: &'static str,
    cases: fn(Effort) -> Vec<Case>,
}

const fn subject(
    name: &'static str,
    says: &'static str,
    cases: fn(Effort) -> Vec<Case>,
) -> Subject {
    Subject { name, says, cases }
}

/// Every subject, in the order of the report.
pub const SUBJECTS: [Subject; 13] = [
    subject(
        "Six cases that break renderers",
        "Those of the first table, with their errors. Radiance.",
        six_cases::cases,
    ),
    subject(
        "Scattering",
        "What models give back of light from everywhere, at a cosine of the view to the normal.",
        scattering::cases,
    ),
    subject(
        "Fresnel's law",
        "Reflectances where the formulas cancel.",
        fresnel::cases,
    ),
    subject(
        "Furnaces",
        "Radiance of white things under a sky of 1, which they cannot be told from, and of what tilted normals lose.",
        furnaces::cases,
    ),
    subject(
        "Mirrors",
        "Radiance, and directions, after many reflections.",
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
        "Rays that go wrong, shares of a shutter and of a lens.",
        geometry::cases,
    ),
    subject(
        "The same picture",
        "Pixels of a small picture that differ by a bit from what they have to be.",
        pictures::cases,
    ),
    subject(
        "Many bounces",
        "Radiance in closed rooms, where light is a geometric series.",
        transport::cases,
    ),
    subject(
        "Light from both ends",
        "By bidirectional path tracing (bdpt) and Metropolis light transport (mlt): radiance, or radiance over the exact.",
        bidirectional::cases,
    ),
    subject(
        "Irradiance cache",
        "Points of a floor at which it is farther from a closed form than it may be; what it tells of a sphere, over the exact.",
        irradiance::cases,
    ),
    subject(
        "Film and camera",
        "Radiance of what is the same everywhere.",
        film::cases,
    ),
];

/// Every case, in the order of the report.
pub fn cases(effort: Effort) -> Vec<Case> {
    let of_subject = |subject: &Subject| {
        let name = subject.name;
        let cases = (subject.cases)(effort).into_iter();
        cases.map(move |case| case.about(name))
    };
    SUBJECTS.iter().flat_map(of_subject).collect()
}
