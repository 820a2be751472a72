//! The identity of a render: a hash of the scene with all its assets, and every setting that changes bits.
//!
//! Nothing can be forgotten: the fields of descriptions and settings are those that `serde` finds, but for those that are
//! skipped explicitly: names, places in files, and what changes only the speed.
//!
//! Measure: BLAKE3 of the description in the form of `postcard`, as loaded: images as pixels, meshes as vertices.
//! Range: any scene. Names and places of objects do not count, nor where the scene's files are.
//! Source: none needed. Tested below and in `tests/rendering/state.rs`.

use crate::accel::{AccelOptions, embree_info};
use crate::error::{Error, ErrorKind, Result};
use crate::film::filter::Filter;
use crate::image::atomic::write_text;
use crate::render::settings::{RenderSettings, SamplerKind};
use crate::scene::description::SceneDescription;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::path::Path;

/// The identity of a render. Sums with equal identities may be added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fingerprint {
    /// The version of the program.
    pub program: String,
    /// The hash of the scene, in hexadecimal digits.
    pub scene: String,
    /// The hash of each part of the scene, to tell which of them differ.
    #[serde(default)]
    pub scene_parts: BTreeMap<String, String>,
    /// Every setting that changes bits.
    pub settings: Map<String, Value>,
}

impl Fingerprint {
    /// The differences to another identity, in words: `ours` and `theirs` name the two.
    pub fn differences(&self, other: &Self, ours: &str, theirs: &str) -> Vec<String> {
        let mut differences = vec![];
        if self.program != other.program {
            differences.push(format!(
                "{ours} was written by {}, {theirs} by {}",
                self.program, other.program
            ));
        }
        if self.scene != other.scene {
            differences.push(format!(
                "the scenes differ, or files that they name{}: {ours} has scene {:.12}, {theirs} has scene {:.12}",
                self.differing_parts(other),
                self.scene, other.scene
            ));
        }
        let of = |settings: &Map<String, Value>, name: &str| {
            settings.get(name).unwrap_or(&Value::Null).to_string()
        };
        let mut names: Vec<&String> = self.settings.keys().chain(other.settings.keys()).collect();
        names.sort();
        names.dedup();
        for name in names {
            let [a, b] = [&self.settings, &other.settings].map(|it| of(it, name));
            if a != b {
                differences.push(format!("{name} is {a} in {ours}, {b} in {theirs}"));
            }
        }
        differences
    }

    /// The parts of the scenes that differ, in words that follow others.
    fn differing_parts(&self, other: &Self) -> String {
        let parts = self.scene_parts.iter();
        let differing = parts.filter(|(name, hash)| other.scene_parts.get(*name) != Some(*hash));
        let names: Vec<&str> = differing.map(|(name, _)| name.as_str()).collect();
        match names.as_slice() {
            [] => String::new(),
            names => format!(", in {}", names.join(", ")),
        }
    }

    /// Reads an identity that [`Self::write`] wrote.
    ///
    /// # Errors
    /// A file that cannot be read, or has no identity.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read(path).map_err(|error| Error::io("cannot read", path, error))?;
        serde_json::from_slice(&text).map_err(|error| {
            let message =
                format!("is not a file of choices: expected one that --choices wrote: {error}");
            Error::new(ErrorKind::Io, message)
                .in_file(path)
                .because(error)
        })
    }

    /// Writes the identity to a file, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| Error::render("cannot write the identity").because(error))?;
        write_text(path, &(text + "\n"))
    }

    /// The name of the integrator, the sampler or the distribution of samples in the settings.
    pub fn name(&self, setting: &str) -> &str {
        let value = self.settings.get(setting);
        value.and_then(Value::as_str).unwrap_or("unknown")
    }
}

/// The identity of a render of this scene with these settings, traced with these options.
///
/// # Errors
/// An error of Embree.
pub fn fingerprint(
    description: &SceneDescription,
    settings: &RenderSettings,
    tracing: AccelOptions,
) -> Result<Fingerprint> {
    let scene_parts = scene_parts(description)?;
    Ok(Fingerprint {
        program: concat!(
            "etendue ",
            env!("CARGO_PKG_VERSION"),
            " of the sources ",
            env!("ETENDUE_SOURCES")
        )
        .to_owned(),
        scene: hash(&scene_parts)?,
        scene_parts,
        settings: all_settings(description, settings, tracing)?,
    })
}

/// The hash of each part of a scene, with the files that it names.
fn scene_parts(description: &SceneDescription) -> Result<BTreeMap<String, String>> {
    // A field that is added has to belong to a part.
    let SceneDescription {
        file: _,
        camera,
        film,
        render: _,
        materials,
        shapes,
        groups,
        instances,
        lights,
        notes: _,
    } = description;
    let parts = [
        ("the camera", hash(camera)?),
        ("the film", hash(film)?),
        ("the materials or their textures", hash(materials)?),
        ("the shapes, their meshes or emission", hash(shapes)?),
        ("the instances", hash(&(groups, instances))?),
        ("the lights or their images", hash(lights)?),
    ];
    Ok(parts.map(|(name, hash)| (name.to_owned(), hash)).into())
}

/// The hash of a value, in hexadecimal digits.
fn hash(value: &impl Serialize) -> Result<String> {
    let mut hasher = BufWriter::with_capacity(1 << 16, blake3::Hasher::new());
    postcard::to_io(value, &mut hasher)
        .map_err(|error| Error::render("cannot hash the scene").because(error))?;
    let hasher = hasher
        .into_inner()
        .map_err(|error| Error::render("cannot hash the scene").because(error.into_error()))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Every setting that changes bits, with its name.
fn all_settings(
    description: &SceneDescription,
    settings: &RenderSettings,
    tracing: AccelOptions,
) -> Result<Map<String, Value>> {
    let resolved = RenderSettings {
        roulette: Some(settings.roulette()),
        max_bounces: settings.bounce_limit(),
        ..settings.clone()
    };
    // The estimator that the render has, whatever was asked for.
    let filter = Filter::new(&description.film.filter);
    let filter_sampling = settings.filter_sampling_of(&filter);
    let failed = |error| Error::render("cannot write the settings").because(error);
    let Value::Object(mut map) = serde_json::to_value(&resolved).map_err(failed)? else {
        return Err(Error::render("the settings are not a map"));
    };
    for (name, value) in [
        ("filter", description.film.filter.name().as_str()),
        ("integrator", settings.integrator.name()),
        ("sampler", settings.sampler.name()),
        ("adaptive", settings.adaptive.name()),
        ("filter_sampling", filter_sampling.name()),
    ] {
        map.insert(name.to_owned(), json!(value));
    }
    if settings.sampler == SamplerKind::Stratified {
        map.insert("strata".to_owned(), json!(settings.samples_of_strata()));
    }
    let quality = tracing.quality().name();
    let AccelOptions {
        backend,
        precision,
        quality: _,
        threads: _,
    } = tracing;
    let version = embree_info()?.map(|embree| embree.library_version);
    map.insert("backend".to_owned(), json!(backend.name()));
    map.insert("precision".to_owned(), json!(precision.name()));
    map.insert("quality".to_owned(), json!(quality));
    if backend.name().starts_with("embree") {
        map.insert("embree".to_owned(), json!(version));
    }
    Ok(map)
}
