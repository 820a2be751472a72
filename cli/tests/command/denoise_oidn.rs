//! Tests of denoising with Open Image Denoise if the library is found, and of the error message if it is not.
#![cfg(feature = "oidn")]

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{USAGE, command, succeed};
use etendue::internals::image::{ColourSpace, LayeredImage};
use etendue::internals::post::denoise::Denoiser;

#[test]
fn missing_oidn_library_error_names_the_folder() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    succeed(&folder, "render small.toml -q --layers -o it.exr");
    let empty = tempfile::tempdir().expect("a folder");
    for arguments in [
        "denoise it.exr --filter oidn -o out.exr",
        "render small.toml --denoise=oidn -o out.exr",
    ] {
        let mut command = command(&folder, arguments);
        let output = command
            .env("OIDN_DIR", empty.path())
            .output()
            .expect("the command starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(USAGE), "{message}");
        for word in [
            "Open Image Denoise 2 was not found",
            "OIDN_DIR",
            &empty.path().display().to_string(),
        ] {
            assert!(message.contains(word), "no `{word}` in {message}");
        }
        assert!(!folder.path("out.exr").exists());
    }
}

/// A file of that name that is not a library leads to an error, not a panic.
#[test]
#[cfg(target_os = "linux")]
fn invalid_oidn_library_is_reported_by_name() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let fake = tempfile::tempdir().expect("a folder");
    std::fs::write(fake.path().join("libOpenImageDenoise.so.2"), "no library").expect("written");
    let mut command = command(&folder, "render small.toml --denoise=oidn -o out.exr");
    let output = command
        .env("OIDN_DIR", fake.path())
        .output()
        .expect("the command starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(USAGE), "{message}");
    assert!(message.contains("libOpenImageDenoise.so.2"), "{message}");
}

/// Runs only if OIDN_DIR names the library or the system has it.
#[test]
fn oidn_filtering_halves_rel_mse_if_available() {
    if let Err(error) = Denoiser::OpenImageDenoise.check() {
        println!("not tested: {error}");
        return;
    }
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    succeed(&folder, "render small.toml -q --layers --spp 16 -o it.exr");
    succeed(
        &folder,
        "render small.toml -q --layers --spp 2048 --seed 5 -o reference.exr",
    );
    let said = succeed(&folder, "denoise it.exr --filter oidn -o out.exr").stderr;
    for word in [
        "filtered by oidn, error about",
        "a trained network made this image",
    ] {
        assert!(said.contains(word), "no `{word}` in {said}");
    }
    let [it, out, reference] = ["it.exr", "out.exr", "reference.exr"].map(|name| {
        LayeredImage::read(&folder.path(name), ColourSpace::Srgb)
            .expect("an image")
            .image
    });
    let error = |image| {
        etendue::internals::image::metrics::rel_mse(image, &reference).expect("the same size")
    };
    let (before, after) = (error(&it), error(&out));
    assert!(
        after < before / 2.0,
        "relMSE {before} before, {after} after"
    );
}
