//! Sensors with their film and sampler, and the integrator.
//!
//! Measure: world units, degrees.
//! Range: perspective and thin-lens sensors; others are errors. Notes name what has no counterpart.
//! Source: Mitsuba 3 documentation, "Sensors", "Films". A sensor of Mitsuba looks along +z with +x to the left, ours
//! along -z with +x to the right. Tested in `tests/loading/mitsuba.rs`.

use super::super::contents::SceneContents;
use super::super::wording::unknown_name;
use super::object::XmlObject;
use crate::error::Result;
use crate::image::MAX_SIDE;
use crate::math::functions::{atan, hypot, tan};
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::{
    CameraDescription, FilmDescription, FilterDescription, FilterKind, NoteKind, RenderDescription,
    WithLine,
};

/// Returns camera and film.
///
/// # Errors
/// If the sensor is of another kind, or a value is out of its range.
pub fn sensor(
    sensor: &XmlObject,
    render: &mut RenderDescription,
    contents: &mut SceneContents,
) -> Result<(CameraDescription, FilmDescription)> {
    if !matches!(sensor.kind.as_str(), "perspective" | "thinlens") {
        return Err(sensor.error("expected a sensor of type perspective or thinlens"));
    }
    let film = match sensor.children("film").next() {
        Some(object) => film(object, contents)?,
        None => FilmDescription {
            size: (768, 576),
            ..FilmDescription::default()
        },
    };
    if let Some(sampler) = sensor.children("sampler").next() {
        let is_count = |n: f64| n >= 1.0 && n.fract() == 0.0 && n <= 1e15;
        let count = sampler.number_where(
            "sample_count",
            4.0,
            "a whole number of at least 1",
            is_count,
        )?;
        render.spp = Some(count as u64);
        if sampler.kind == "independent" {
            render.sampler = Some(WithLine {
                value: "independent".to_owned(),
                line: sampler.place.line.unwrap_or(1),
            });
        }
        sampler.note_unused(&["seed"], contents);
    }
    let (to_world, is_mirrored) = to_world(sensor)?;
    let mut camera = CameraDescription {
        place: sensor.place.clone(),
        is_mirrored,
        ..CameraDescription::pinhole(to_world, field_of_view(sensor, &film)?)
    };
    if sensor.kind == "thinlens" {
        let above_0 = |x: f64| x > 0.0;
        camera.lens_radius =
            sensor.number_where("aperture_radius", 0.0, "a number of at least 0", |x| {
                x >= 0.0
            })?;
        let far_clip = sensor.number("far_clip")?.unwrap_or(1e4);
        camera.focus_distance =
            sensor.number_where("focus_distance", far_clip, "a number above 0", above_0)?;
    }
    sensor.note_unless_zero(
        &["principal_point_offset_x", "principal_point_offset_y"],
        contents,
    );
    sensor.note_unused(
        &[
            "near_clip",
            "far_clip",
            "focus_distance",
            "shutter_open",
            "shutter_close",
        ],
        contents,
    );
    Ok((camera, film))
}

/// The transform of a camera that is not mirrored, and whether the image is.
fn to_world(sensor: &XmlObject) -> Result<(DAffine3, bool)> {
    let transform = sensor.transform("to_world")?;
    let axes = transform.matrix3;
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::normalize_or_zero);
    let turned = DMat3::from_cols(x, y, z);
    let error = turned * turned.transpose() - DMat3::IDENTITY;
    let largest = error
        .to_cols_array()
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    // Exporters write single precision.
    if largest > 1e-4 {
        return Err(sensor.error_at(
            "to_world",
            "expected rotations, mirrors and translations only",
        ));
    }
    let is_mirrored = turned.determinant() < 0.0;
    let x = if is_mirrored { -x } else { x };
    let z = z.normalize();
    let x = (x - x.dot(z) * z).normalize();
    let to_world = DAffine3 {
        matrix3: DMat3::from_cols(-x, z.cross(x), -z),
        translation: transform.translation,
    };
    Ok((to_world, is_mirrored))
}

/// Returns the vertical field of view.
fn field_of_view(sensor: &XmlObject, film: &FilmDescription) -> Result<f64> {
    let (width, height) = (f64::from(film.size.0), f64::from(film.size.1));
    // Half the film's height over that of the extent which the angle refers to.
    let (share, angle) = match (sensor.number("fov")?, sensor.get("focal_length").is_some()) {
        (Some(fov), _) => {
            let extent = match sensor.text("fov_axis")?.unwrap_or("x") {
                "x" => width,
                "y" => height,
                "diagonal" => hypot(width, height),
                "smaller" => width.min(height),
                "larger" => width.max(height),
                other => {
                    let known = ["x", "y", "diagonal", "smaller", "larger"];
                    return Err(sensor.error_at("fov_axis", &unknown_name("axis", other, &known)));
                }
            };
            if !(fov > 0.0 && fov < 180.0) {
                return Err(
                    sensor.error_at("fov", "expected an angle above 0 and below 180 degrees")
                );
            }
            (height / extent, tan(0.5 * fov.to_radians()))
        }
        // Of film for still cameras, 36 x 24 mm, along its diagonal.
        (None, _) => {
            let text = sensor.text("focal_length")?.unwrap_or("50mm");
            let number = text
                .trim()
                .strip_suffix("mm")
                .unwrap_or(text)
                .trim()
                .parse()
                .ok();
            let focal = number
                .filter(|x: &f64| *x > 0.0 && x.is_finite())
                .ok_or_else(|| {
                    sensor.error_at("focal_length", "expected a number of mm above 0")
                })?;
            (
                height / hypot(width, height),
                0.5 * hypot(36.0, 24.0) / focal,
            )
        }
    };
    Ok(2.0 * atan(share * angle))
}

fn film(film: &XmlObject, contents: &mut SceneContents) -> Result<FilmDescription> {
    let side = |name, default| {
        let is_side = |n: f64| (1.0..=MAX_SIDE as f64).contains(&n) && n.fract() == 0.0;
        let expected = format!("a whole number from 1 to {MAX_SIDE}");
        film.number_where(name, default, &expected, is_side)
            .map(|n| n as u32)
    };
    let size = (side("width", 768.0)?, side("height", 576.0)?);
    let filter = match film.children("rfilter").next() {
        Some(object) => filter(object, contents)?,
        None => gaussian(0.5),
    };
    let harmless = [
        "file_format",
        "pixel_format",
        "component_format",
        "banner",
        "compensate",
        "sample_border",
    ];
    film.note_unused(&harmless, contents);
    Ok(FilmDescription { size, filter })
}

/// A Gaussian: ours has three standard deviations, that of Mitsuba four, beyond which both are zero.
fn gaussian(deviation: f64) -> FilterDescription {
    FilterDescription {
        kind: FilterKind::Gaussian,
        radius: 3.0 * deviation,
    }
}

fn filter(filter: &XmlObject, contents: &mut SceneContents) -> Result<FilterDescription> {
    let above_0 = |x: f64| x > 0.0 && x < 100.0;
    let expected = "a number above 0 and below 100";
    let of = |kind: FilterKind| FilterDescription {
        kind,
        radius: kind.default_radius(),
    };
    let found = match filter.kind.as_str() {
        "box" => of(FilterKind::Box),
        "tent" => FilterDescription {
            kind: FilterKind::Tent,
            radius: filter.number_where("radius", 1.0, expected, above_0)?,
        },
        "gaussian" => gaussian(filter.number_where("stddev", 0.5, expected, above_0)?),
        "mitchell" => {
            let [b, c] = ["A", "B"].map(|name| filter.number(name));
            if [b?, c?]
                .iter()
                .flatten()
                .any(|x| (x - 1.0 / 3.0).abs() > 1e-3)
            {
                contents
                    .note(filter.note(NoteKind::Approximation, "replaced by that of A = B = 1/3"));
            }
            of(FilterKind::Mitchell)
        }
        "catmullrom" | "lanczos" => {
            contents.note(filter.note(NoteKind::Approximation, "replaced by Mitchell's filter"));
            filter.number("lobes")?;
            of(FilterKind::Mitchell)
        }
        other => {
            let known = [
                "box",
                "tent",
                "gaussian",
                "mitchell",
                "catmullrom",
                "lanczos",
            ];
            return Err(filter.error(&unknown_name("filter", other, &known)));
        }
    };
    filter.note_unused(&[], contents);
    Ok(found)
}

/// Sets the number of bounces, and the integrator if another than `path` is closer.
///
/// # Errors
/// If a value is out of its range.
pub fn integrator(
    integrator: &XmlObject,
    render: &mut RenderDescription,
    contents: &mut SceneContents,
) -> Result<()> {
    let is_depth = |n: f64| n.fract() == 0.0 && (n == -1.0 || (1.0..=4e9).contains(&n));
    let expected = "-1, or a whole number of at least 1";
    // A path of depth n has n - 1 scattering events.
    let depth = integrator.number_where("max_depth", -1.0, expected, is_depth)?;
    render.max_bounces = (depth > 0.0).then(|| depth as u32 - 1);
    match integrator.kind.as_str() {
        "path" => {}
        "direct" => render.max_bounces = Some(1),
        "ptracer" => {
            render.integrator = Some(WithLine {
                value: "bdpt".to_owned(),
                line: integrator.place.line.unwrap_or(1),
            });
            contents.note(integrator.note(
                NoteKind::Decision,
                "replaced by bdpt, which has the same expected image",
            ));
        }
        _ => {
            let text = "replaced by path: its image is that of the scene, whatever this integrator leaves out";
            contents.note(integrator.note(NoteKind::Approximation, text));
        }
    }
    if integrator.truth("hide_emitters", false)? {
        let text = "`hide_emitters` is not supported: the camera sees emitters";
        contents.note(integrator.note(NoteKind::Approximation, text));
    }
    let harmless = [
        "rr_depth",
        "shading_samples",
        "emitter_samples",
        "bsdf_samples",
        "block_size",
        "samples_per_pass",
        "timeout",
    ];
    integrator.note_unused(&harmless, contents);
    Ok(())
}
