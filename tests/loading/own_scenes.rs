//! Tests of the scenes that come with the program: each renders, the furnaces have their exact values, and the gallery
//! lists the effects of the others correctly.

use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::plan::Plan;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use std::path::{Path, PathBuf};

/// Every scene file under `scenes/`.
fn all_scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files_of = |folder: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).expect("the folder can be read");
        entries
            .map(|entry| entry.expect("an entry can be read").path())
            .collect()
    };
    let files = files_of(&root)
        .into_iter()
        .filter(|path| path.is_dir())
        .flat_map(|f| files_of(&f));
    files
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect()
}

fn rendered(path: &Path, size: (u32, u32), spp: u64) -> Film {
    let mut description = load(path).unwrap_or_else(|error| panic!("{error}"));
    description.film.size = size;
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Robust,
        quality: None,
        threads: 2,
    };
    let scene = prepare(&description, options)
        .expect("a scene of our own is valid")
        .scene;
    let filter = Filter::new(&description.film.filter);
    let settings = RenderSettings::new(size, spp);
    let rendered =
        render(&scene, &filter, size, &settings, &NullRenderObserver).expect("valid settings");
    assert_eq!(rendered.rejected.count, 0, "{}", path.display());
    rendered.film
}

#[test]
fn bundled_scenes_render_without_non_finite_samples() {
    let scenes = all_scenes();
    assert!(scenes.len() >= 6, "{scenes:?}");
    for path in scenes {
        let film = rendered(&path, (48, 32), 4);
        assert!(
            film.mean().iter().all(|&x| x > 0.01),
            "{}: {:?}",
            path.display(),
            film.mean()
        );
    }
}

fn furnace(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/furnace/{name}.toml"))
}

#[test]
fn white_furnace_spheres_have_unit_radiance_in_every_pixel() {
    for name in ["white-sphere", "glass-sphere"] {
        let image = rendered(&furnace(name), (64, 64), 16).develop();
        for pixel in image.pixels() {
            let off = pixel.to_array().map(|x| (x - 1.0).abs());
            assert!(off.iter().all(|&x| x < 1e-5), "{name}: {pixel:?}");
        }
    }
}

#[test]
fn emissive_grey_box_furnace_has_mean_radiance_two() {
    let film = rendered(&furnace("grey-box"), (64, 64), 64);
    // From the film's own estimate of the relative error (slightly too small, as relMSE has epsilon = 0.01 mean^2),
    // for the mean of 4096 pixels.
    let relative = film.error(0.95).expect("64 samples a pixel").rel_rmse;
    let standard_error = 1.01 * 2.0 * relative / 64.0;
    assert!(
        standard_error < 0.01,
        "inconclusive: standard error {standard_error}"
    );
    for mean in film.mean() {
        assert!((mean - 2.0).abs() < 5.2 * standard_error, "{mean}");
    }
}

#[test]
fn gallery_images_exist_and_listed_effects_match_the_scenes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/gallery.md")).expect("the page exists");
    let sections: Vec<&str> = page.split("\n## ").skip(1).collect();
    assert!(sections.len() >= 7, "{}", sections.len());
    for section in sections {
        let between = |start: &str, end: &str| {
            let (_, rest) = section
                .split_once(start)
                .unwrap_or_else(|| panic!("no `{start}` in {section}"));
            rest.split_once(end).expect("the text ends").0
        };
        let picture = root.join("docs").join(between("](", ")"));
        let bytes = std::fs::metadata(&picture).expect("the image exists");
        assert!(bytes.len() <= 400 * 1024, "{}", picture.display());

        let mut arguments = between("etendue render ", "\n").split(' ');
        let scene = arguments.next().expect("the scene is the first argument");
        let description = load(&root.join(scene)).expect("a valid scene");
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            quality: None,
            threads: 2,
        };
        let scene = prepare(&description, options).expect("a valid scene").scene;
        let found: Vec<&str> = Plan::new(&description, &scene)
            .on()
            .map(|effect| effect.name())
            .collect();
        let written = between("Effects: ", ".\n").replace('\n', " ");
        assert_eq!(written, found.join(", "), "{}", picture.display());
    }
}
