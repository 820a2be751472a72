//! The scene and the rays of its render that several benches use.
//!
//! Measure: normalised scene units.
//! Range: scenes of the sources.
//! Source: none needed.

// Each bench compiles this anew and uses a part of it.
#![allow(dead_code)]

use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::filter::Filter;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::sampler::{Decision, Independent, Sampler};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use etendue_lab::bench::record::{Recording, record};
use etendue_lab::bench::subject::BenchedRender;
use std::path::Path;

/// A scene of the sources, as written.
pub fn written(name: &str) -> SceneDescription {
    let file = format!("{}/scenes/{name}/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    load(Path::new(&file)).expect("a scene of our own loads")
}

/// A scene that is ready to be traced with the preferred backend.
pub fn ready(description: &SceneDescription) -> Scene {
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Fast,
        quality: None,
        threads: 1,
    };
    let prepared = prepare(description, options);
    prepared.expect("it was built before").scene
}

/// The rays of a scene's render, until there are so many of the most frequent kind.
pub fn recorded(description: &SceneDescription, scene: &Scene, limit: usize) -> Recording {
    let size = description.film.size;
    let subject = BenchedRender {
        scene,
        filter: &Filter::new(&description.film.filter),
        size,
        settings: &RenderSettings::new(size, 64),
    };
    record(&subject, limit)
}

/// Uniform numbers to draw inputs from, the same in every run.
pub fn numbers(count: usize) -> Vec<[f32; 4]> {
    let mut sampler = Independent::new(1);
    let draw = |i: usize| {
        sampler.start([0, 0], i as u64);
        sampler.draw(Decision::Light(0))
    };
    (0..count).map(draw).collect()
}
