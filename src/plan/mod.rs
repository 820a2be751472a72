//! The plan of a render: the effects that a scene requires, the object that is the reason for each, and the resulting
//! kernel.
//!
//! Measure: none.
//! Range: any prepared scene.
//! Source: docs/architecture.md, "Effects". Tested in `cli/tests/command/plan.rs`.

mod objects;
mod without;

pub use without::without;

use crate::effects::{Effect, Kernel};
use crate::light::select::Lights;
use crate::scene::Scene;
use crate::scene::description::{Place, SceneDescription};
use objects::{PlannedObject, objects};

/// The state of one effect, and the reason for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EffectFinding {
    /// The effect.
    pub effect: Effect,
    /// Whether the scene requires the effect.
    pub on: bool,
    /// The first object that requires the effect, or the reason why it is not required.
    pub why: String,
    /// The location of that object in the scene file, if there is one.
    pub place: Option<Place>,
}

/// The simulated effects, and the kernel that simulates them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// One finding for each effect, in the order of [`Effect::ALL`].
    pub findings: Vec<EffectFinding>,
    /// The kernel of `path` for the scene: the smallest with every effect that is on. Other integrators have two kernels
    /// only (`src/render/dispatch.rs`).
    pub kernel: Kernel,
}

impl Plan {
    /// Creates the plan for a scene, with reasons from its description.
    pub fn new(description: &SceneDescription, scene: &Scene) -> Self {
        let objects = objects(description);
        let finding = |effect| {
            let on = scene.effects.has(effect);
            let reason = match effect {
                Effect::ManyLights => Some((lights(&scene.lights), None)),
                _ if on => objects.iter().find_map(|object| calls(object, effect)),
                _ => objects.iter().find_map(|object| folded(object, effect)),
            };
            let (why, place) = reason.unwrap_or_else(|| (nothing(effect).to_owned(), None));
            EffectFinding {
                effect,
                on,
                why,
                place,
            }
        };
        Self {
            findings: Effect::ALL.map(finding).to_vec(),
            kernel: Kernel::smallest_for(scene.effects),
        }
    }

    /// The effects that are on.
    pub fn on(&self) -> impl Iterator<Item = Effect> {
        let on = self.findings.iter().filter(|finding| finding.on);
        on.map(|finding| finding.effect)
    }
}

type Reason = (String, Option<Place>);

/// The reason why an effect is on, if the object requires it.
fn calls(object: &PlannedObject, effect: Effect) -> Option<Reason> {
    let why = format!("{} {}", object.name, object.what(effect));
    let place = object.place.clone();
    object.calls_for.has(effect).then_some((why, Some(place)))
}

/// The reason why an effect is off, if the description of the object contains it without any result.
fn folded(object: &PlannedObject, effect: Effect) -> Option<Reason> {
    let why = format!("{} {}", object.name, vanishes(effect));
    let place = object.place.clone();
    object.written.has(effect).then_some((why, Some(place)))
}

fn lights(lights: &Lights) -> String {
    let count = lights.len();
    let nodes = lights.tree().map_or(0, |tree| tree.size()[1]);
    match (count, nodes) {
        (0, _) => "there is no light to sample".to_owned(),
        (1, _) => "there is one light to sample".to_owned(),
        (_, 0) => format!("there are {count} lights to sample"),
        (_, 1) => format!(
            "there are {count} lights to sample, each selected by what it would contribute at a surface"
        ),
        _ => format!(
            "there are {count} lights to sample, selected by what they would contribute at a surface, from a tree of {nodes} nodes"
        ),
    }
}

/// The reason why an effect in the description of an object has no result.
fn vanishes(effect: Effect) -> &'static str {
    match effect {
        Effect::ShadingNormals => "has only the geometric normals of its triangles",
        Effect::Textures => "has a texture of one colour",
        Effect::NormalMaps => "has a flat normal or bump map",
        Effect::Alpha => "has an alpha of 1 everywhere",
        Effect::Motion => "has keyframes, but does not move while the shutter is open",
        Effect::Environment | Effect::DeltaLights | Effect::AreaLights => "is black",
        Effect::EnvironmentMap => "is an image of one colour",
        Effect::Lens => "has a lens_radius of 0",
        Effect::OneSided
        | Effect::Glossy
        | Effect::Specular
        | Effect::Transmission
        | Effect::ManyLights
        | Effect::Instances
        | Effect::LightPaths
        | Effect::Reuse => "has none of it",
    }
}

/// The reason why an effect is off that no description contains.
fn nothing(effect: Effect) -> &'static str {
    match effect {
        Effect::ShadingNormals => "no shape has shading normals",
        Effect::Textures => "every colour is constant",
        Effect::NormalMaps => "no material has a normal or bump map",
        Effect::Alpha => "no material has an alpha below 1",
        Effect::OneSided => "every surface scatters on both sides",
        Effect::Glossy => "no surface is glossy",
        Effect::Specular => "no surface is specular",
        Effect::Transmission => "every surface is opaque",
        Effect::Lens => "lens_radius is 0",
        Effect::Motion => "nothing has keyframes",
        Effect::Environment => "there is no environment",
        Effect::EnvironmentMap => "no environment is an image",
        Effect::DeltaLights => "every light has a size",
        Effect::AreaLights => "no shape emits",
        Effect::ManyLights => "there is at most one light",
        Effect::Instances => "no group is placed, and no shape moves",
        Effect::LightPaths => "no number of light_paths is asked for",
        Effect::Reuse => "no number of pixels is asked for by reuse",
    }
}
