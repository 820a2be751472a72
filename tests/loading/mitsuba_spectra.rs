//! Spectra of Mitsuba 3: by wavelength, from files, of black bodies, and the indices of metals.
//!
//! Measure: linear Rec. 709.
//! Range: scenes that are made here.
//! Source: Mitsuba 3.9.1. The numbers are what `mitsuba.traverse` reports in the variant llvm_ad_rgb for an object with
//! the spectrum, or, where that variant has no such object, what `mitsuba.spectrum_list_to_srgb` returns for its values.

use crate::common::scene_folder::SceneFolder;
use crate::mitsuba::{complaint, material, scene, valid};
use etendue::description::{ColourDescription, LightModel, MaterialModel, NoteKind};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::scene::load::load;

const SAMPLES: &str = "400:0.04, 450:0.05, 500:0.1, 550:0.3, 600:0.7, 650:0.6, 700:0.65";

/// The reflectance of these samples.
const SEEN: [f32; 3] = [0.798_178, 0.289_532, 0.019_008_7];

/// The tables of the observer differ in their ends and steps.
fn assert_near(found: Rgb, expected: [f32; 3]) {
    let most = expected.into_iter().fold(0.0, f32::max);
    for (found, expected) in found.to_array().into_iter().zip(expected) {
        assert!((found - expected).abs() < 3e-3 * most, "{found} {expected}");
    }
}

fn diffuse(reflectance: &str) -> Rgb {
    match material(&format!("<bsdf type=\"diffuse\">{reflectance}</bsdf>")).0 {
        MaterialModel::Diffuse { reflectance } => reflectance.constant().expect("a constant"),
        other => panic!("{other:?}"),
    }
}

fn radiance(spectrum: &str) -> Rgb {
    let it = valid(&format!(
        "<shape type=\"sphere\"><emitter type=\"area\">{spectrum}</emitter></shape>"
    ));
    let emission = it.shapes[0].emission.as_ref().expect("it emits");
    emission.constant().expect("a constant")
}

#[test]
fn sampled_reflectances_are_seen_in_daylight() {
    let written = format!("<spectrum name=\"reflectance\" value=\"{SAMPLES}\"/>");
    assert_near(diffuse(&written), SEEN);
    let grey = "<spectrum name=\"reflectance\" value=\"0.25\"/>";
    assert_eq!(diffuse(grey), Rgb::grey(0.25));
    // A spectrum that reflects more than all light in one channel is cut there.
    let narrow = diffuse("<spectrum name=\"reflectance\" value=\"569:0, 570:1, 780:1\"/>");
    assert_eq!(narrow.to_array()[0], 1.0);
    let ramp = [0.421_193, 0.290_558, 0.153_908];
    for (kind, wavelengths) in [
        (
            "irregular",
            "<string name=\"wavelengths\" value=\"400, 700\"/>",
        ),
        (
            "regular",
            "<float name=\"wavelength_min\" value=\"400\"/><float name=\"wavelength_max\" value=\"700\"/>",
        ),
    ] {
        let spectrum = format!(
            "<spectrum type=\"{kind}\" name=\"reflectance\">{wavelengths}<string name=\"values\" value=\"0.1, 0.5\"/></spectrum>"
        );
        assert_near(diffuse(&spectrum), ramp);
    }
}

#[test]
fn spectra_are_read_from_files() {
    let file = format!(
        "# nm, value\n{}\n",
        SAMPLES.replace(", ", "\n").replace(':', " ")
    );
    let text = scene(
        "<shape type=\"sphere\"><bsdf type=\"diffuse\"><spectrum name=\"reflectance\" filename=\"a.spd\"/></bsdf></shape>",
    );
    let read = |file: &str| {
        load(&SceneFolder::new([("a.xml", text.as_str()), ("a.spd", file)]).path("a.xml"))
    };
    let it = read(&file).unwrap_or_else(|error| panic!("{error}"));
    let MaterialModel::Diffuse { reflectance } = &it.materials[0].model else {
        panic!("{:?}", it.materials[0])
    };
    assert_near(reflectance.constant().expect("a constant"), SEEN);
    let error = read("400 0.5\n500 x\n")
        .expect_err("x is no number")
        .to_string();
    assert!(
        error.contains("a.xml:3") && error.contains("a.spd:2"),
        "{error}"
    );
}

#[test]
fn sampled_light_has_the_power_of_its_spectrum() {
    let written = format!("<spectrum name=\"radiance\" value=\"{SAMPLES}\"/>");
    assert_near(radiance(&written), [0.910_036, 0.279_946, 0.011_432_1]);
    let flat = radiance("<spectrum name=\"radiance\" value=\"2\"/>");
    assert_near(flat, [2.409_59, 1.896_58, 1.817_83]);
    let it = valid(
        "<emitter type=\"point\"><spectrum name=\"intensity\" value=\"400:0, 700:8\"/></emitter>",
    );
    let LightModel::Point { intensity, .. } = it.lights[0].model else {
        panic!("{:?}", it.lights[0])
    };
    assert_near(intensity, [7.522_45, 3.637_76, 0.909_571]);
}

/// Planck's law is evaluated by the variant scalar_spectral every half nanometre.
#[test]
fn black_bodies_have_the_radiance_of_plancks_law() {
    let body = |more: &str| {
        format!(
            "<spectrum type=\"blackbody\" name=\"radiance\"><float name=\"temperature\" value=\"4000\"/>{more}</spectrum>"
        )
    };
    let whole = [4_897.03, 3_200.57, 1_848.26];
    assert_near(radiance(&body("")), whole);
    let some = body(
        "<float name=\"wavelength_min\" value=\"500\"/><float name=\"wavelength_max\" value=\"600\"/>",
    );
    let [_, green, blue] = radiance(&some).to_array();
    // One more nanometre at the ends.
    assert!(
        (green - 3_315.32).abs() < 0.02 * 3_315.32 && blue == 0.0,
        "{green} {blue}"
    );
    let it = valid(&format!(
        "<emitter type=\"constant\">{}</emitter>",
        body("")
    ));
    let LightModel::Environment { radiance, .. } = &it.lights[0].model else {
        panic!("{:?}", it.lights[0])
    };
    assert_near(radiance.constant().expect("a constant"), whole);
}

#[test]
fn refractive_indices_may_be_spectra_or_names() {
    let conductor =
        |content: &str| match material(&format!("<bsdf type=\"conductor\">{content}</bsdf>")) {
            (MaterialModel::Conductor { eta, k, .. }, _, scene) => {
                assert!(scene.check_faithful().is_ok(), "{:?}", scene.notes);
                (eta, k)
            }
            other => panic!("{other:?}"),
        };
    let (eta, k) = conductor(&format!(
        "<spectrum name=\"eta\" value=\"{SAMPLES}\"/><spectrum name=\"k\" value=\"400:3, 500:2, 700:4\"/>"
    ));
    assert_near(eta, SEEN);
    assert_near(k, [3.464_65, 2.352_04, 2.433_68]);
    let (eta, k) = conductor("<string name=\"material\" value=\"CuO\"/>");
    assert_near(eta, [3.2475, 2.4478, 2.2102]);
    assert_near(k, [0.5211, 0.57, 0.7222]);
    let (eta, _) = conductor("<string name=\"material\" value=\"AlSb\"/>");
    assert!(
        eta.to_array()[0] > 0.0,
        "an index of 0 has no Fresnel reflectance"
    );
    let (model, ..) =
        material("<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"Diamond\"/></bsdf>");
    assert!(matches!(model, MaterialModel::Dielectric { ior, .. } if ior > 2.4));
}

#[test]
fn attributes_of_meshes_become_grey_with_a_note() {
    for kind in ["mesh_attribute", "volume"] {
        let (model, _, scene) = material(&format!(
            "<bsdf type=\"diffuse\"><texture type=\"{kind}\" name=\"reflectance\"><string name=\"name\" value=\"vertex_color\"/></texture></bsdf>"
        ));
        let MaterialModel::Diffuse { reflectance } = model else {
            panic!("{model:?}")
        };
        assert_eq!(reflectance, ColourDescription::from(Rgb::grey(0.5)));
        let noted = scene
            .notes
            .iter()
            .any(|note| note.kind == NoteKind::Approximation && note.text.contains(kind));
        assert!(noted, "{:?}", scene.notes);
    }
}

#[test]
fn invalid_spectra_are_rejected() {
    for (value, expected) in [
        (
            "400:1, 500",
            "a wavelength and a value such as 400:0.5, found 500",
        ),
        ("400:1, 500:x", "found 500:x"),
        ("500:1, 400:1", "expected increasing wavelengths"),
        ("400:-1, 500:1", "expected values of at least 0, found -1"),
        ("400:1e31, 500:1", "expected values of at most 1e30"),
        ("1 2", "expected one value from 0 to 1e30"),
        ("-1", "expected one value from 0 to 1e30"),
        ("", "expected one value from 0 to 1e30"),
    ] {
        let words = complaint(&format!(
            "<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" value=\"{value}\"/></bsdf>"
        ));
        assert!(
            words.contains("a.xml:3: ") && words.contains(expected),
            "{value}: {words}"
        );
    }
    for (object, expected) in [
        ("type=\"blackbody\"", "expected a `temperature`"),
        ("type=\"regular\"", "expected a `values`"),
        ("type=\"cauchy\"", "unknown texture `cauchy`"),
    ] {
        let words = complaint(&format!(
            "<shape type=\"cube\"><bsdf type=\"diffuse\"><spectrum {object} name=\"reflectance\"/></bsdf></shape>"
        ));
        assert!(words.contains(expected), "{words}");
    }
    let hot = "<spectrum type=\"blackbody\" name=\"radiance\"><float name=\"temperature\" value=\"1e10\"/></spectrum>";
    let words = complaint(&format!("<emitter type=\"constant\">{hot}</emitter>"));
    assert!(
        words.contains("a temperature above 0 and at most 1e9 K"),
        "{words}"
    );
}
