//! Small scenes, and temporary folders to load them from.
//!
//! Measure: none.
//! Range: the folder is deleted when its value is dropped.
//! Source: none needed.

use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::film::filter::Filter;
use etendue::internals::image::Image;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The required part of a scene file; shapes and more can follow.
pub const HEAD: &str = "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";

/// A scene of 24 x 16 pixels with every kind of event: diffuse, glossy and refracted light, lamps and a sky.
pub const SMALL: &str = r#"version = 1

[camera]
eye = [0, 1, 5]
target = [0, 0.5, 0]

[film]
size = [24, 16]

[render]
spp = 4

[[material]]
name = "floor"
type = "diffuse"
reflectance = { checker = [0.7, 0.2], repeat = [4, 4] }

[[material]]
name = "glass"
type = "dielectric"

[[material]]
name = "gold"
type = "conductor"
preset = "gold"
roughness = 0.4

[[shape]]
name = "floor"
type = "rectangle"
material = "floor"
corner = [-4, 0, 4]
edge_u = [8, 0, 0]
edge_v = [0, 0, -8]

[[shape]]
name = "ball"
type = "sphere"
material = "glass"
center = [-0.8, 0.6, 0]
radius = 0.6

[[shape]]
name = "block"
type = "box"
material = "gold"
min = [0.3, 0, -0.5]
max = [1.1, 0.9, 0.4]

[[shape]]
name = "lamp"
type = "disk"
center = [1, 3, 1]
normal = [0, -1, 0]
radius = 0.4
emission = [12, 11, 10]

[[light]]
type = "environment"
radiance = [0.1, 0.12, 0.15]
"#;

/// A triangle as a model without materials.
pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The path of a file in the repository, from a test of any package.
pub fn in_repository(path: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = package.ancestors().find(|it| it.join("scenes").is_dir());
    root.expect("the repository has scenes").join(path)
}

/// A temporary folder with scene files.
pub struct SceneFolder(TempDir);

impl SceneFolder {
    /// Creates a folder with these files.
    pub fn new<T: AsRef<[u8]>>(files: impl IntoIterator<Item = (&'static str, T)>) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, content) in files {
            std::fs::write(folder.path(name), content).expect("the folder is writable");
        }
        folder
    }

    /// The path of the folder.
    pub fn root(&self) -> &Path {
        self.0.path()
    }

    /// The path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Loads a scene in the folder, which has to be valid.
    pub fn load(&self, name: &str) -> SceneDescription {
        load(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The sorted names of the files in the folder.
    pub fn listing(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.root()).expect("the folder exists");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("it is readable").file_name())
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// Loads one valid scene, given as text.
pub fn load_text(text: &str) -> SceneDescription {
    SceneFolder::new([("scene.toml", text)]).load("scene.toml")
}

/// Renders a scene with the default backend.
pub fn picture(description: &SceneDescription, settings: &RenderSettings) -> Image {
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Robust,
        quality: None,
        threads: settings.threads,
    };
    let prepared = prepare(description, options).expect("the scene is valid");
    let filter = Filter::new(&description.film.filter);
    let size = description.film.size;
    let rendered = render(
        &prepared.scene,
        &filter,
        size,
        settings,
        &NullRenderObserver,
    );
    rendered.expect("the settings are valid").film.develop()
}
