//! Whether a description that was made in code is one that `load` would let through.
//!
//! Measure: as in the description.
//! Range: any description; the first thing that is wrong is an error of the scene that names the object and its field.
//! Source: docs/scene-format.md, whose rules these are. Tested in `tests/loading/built_scenes.rs`.

use super::description::{
    CameraDescription, ColourDescription, FilmDescription, GeometryDescription,
    InstanceDescription, Key, LightDescription, LightModel, MaterialDescription, MaterialModel,
    MeshDescription, SceneDescription, ShapeDescription,
};
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::image::MAX_SIDE;
use crate::math::rgb::Rgb;
use crate::math::transform::{is_invertible, is_rotation};
use crate::math::vec::{DAffine3, DVec3};
use std::f64::consts::PI;

/// A whole scene.
///
/// # Errors
/// What is wrong with the first object that is not valid.
pub fn scene(scene: &SceneDescription) -> Result<()> {
    camera(&scene.camera)?;
    film(&scene.film)?;
    scene.materials.iter().try_for_each(material)?;
    for added in &scene.shapes {
        shape(added, scene)?;
    }
    for added in &scene.instances {
        instance(added, scene)?;
    }
    scene.lights.iter().try_for_each(light)?;
    panoramas(&scene.lights)
}

/// A camera.
///
/// # Errors
/// What is wrong with it.
pub fn camera(camera: &CameraDescription) -> Result<()> {
    let in_camera = |field: &str| format!("camera.{field}");
    let places = camera.motion.iter().map(|key| &key.transform);
    for placed in [&camera.to_world].into_iter().chain(places) {
        require(
            placed.is_finite() && is_rotation(&placed.matrix3),
            || in_camera("to_world"),
            "expected finite numbers, and rotations and translations only",
        )?;
    }
    keys(&camera.motion, "camera")?;
    let [open, close] = camera.shutter;
    require(
        open.is_finite() && close.is_finite() && open <= close,
        || in_camera("shutter"),
        "expected the times of opening and closing, in order",
    )?;
    require(
        camera.fov > 0.0 && camera.fov < PI,
        || in_camera("fov"),
        "expected an angle above 0 and below 180 degrees",
    )?;
    require(
        camera.lens_radius >= 0.0 && camera.lens_radius.is_finite(),
        || in_camera("lens_radius"),
        "expected a finite number of at least 0",
    )?;
    require(
        camera.focus_distance > 0.0 && camera.focus_distance.is_finite(),
        || in_camera("focus_distance"),
        "expected a finite number above 0",
    )
}

/// A film.
///
/// # Errors
/// What is wrong with it.
pub fn film(film: &FilmDescription) -> Result<()> {
    let is_side = |side: u32| (1..=MAX_SIDE).contains(&(side as usize));
    require(
        is_side(film.size.0) && is_side(film.size.1),
        || "film.size".to_owned(),
        &format!("expected from 1 to {MAX_SIDE} pixels a side"),
    )?;
    require(
        film.filter.radius > 0.0 && film.filter.radius <= 32.0,
        || "film.filter".to_owned(),
        "expected a radius of pixels above 0, up to 32",
    )
}

/// A material.
///
/// # Errors
/// What is wrong with it.
pub fn material(material: &MaterialDescription) -> Result<()> {
    let field = |key: &str| format!("material `{}`: {key}", material.name);
    let share = |key: &str, x: f32| {
        let is_share = (0.0..=1.0).contains(&x);
        require(is_share, || field(key), "expected a number from 0 to 1")
    };
    let reflectance = |key: &str, c: &ColourDescription| colour(c, 1.0, || field(key));
    let index = |ior: f32| {
        let is_index = ior >= 1.0 && ior.is_finite();
        require(
            is_index,
            || field("ior"),
            "expected a finite number of at least 1",
        )
    };
    reflectance("alpha", &material.alpha)?;
    if let Some(map) = &material.normal_map {
        let is_fine = map.strength >= 0.0 && map.strength.is_finite();
        let expected = "expected a finite strength of at least 0";
        require(is_fine, || field("normal_map"), expected)?;
    }
    match &material.model {
        MaterialModel::Diffuse { reflectance: r } | MaterialModel::Mirror { reflectance: r } => {
            reflectance("reflectance", r)
        }
        MaterialModel::Conductor { eta, k, roughness } => {
            positive(*eta, || field("eta"))?;
            not_negative(*k, || field("k"))?;
            share("roughness", *roughness)
        }
        MaterialModel::Phong {
            diffuse,
            specular,
            exponent,
        } => {
            reflectance("diffuse", diffuse)?;
            reflectance("specular", specular)?;
            let sum = brightest(diffuse) + brightest(specular);
            require(
                sum.max_channel() <= 1.0,
                || field("specular"),
                "expected diffuse and specular of at most 1 together in every channel",
            )?;
            let fits = (0.0..=1e6).contains(exponent);
            require(
                fits,
                || field("exponent"),
                "expected a number from 0 to 1e6",
            )
        }
        MaterialModel::Plastic {
            reflectance: r,
            ior,
            roughness,
        } => {
            reflectance("reflectance", r)?;
            index(*ior)?;
            share("roughness", *roughness)
        }
        MaterialModel::Dielectric {
            ior,
            roughness,
            tint,
        } => {
            let is_index = *ior > 0.0 && ior.is_finite();
            require(
                is_index,
                || field("ior"),
                "expected a finite number above 0",
            )?;
            share("roughness", *roughness)?;
            reflectance("tint", tint)
        }
        MaterialModel::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            transmission,
        } => {
            reflectance("base_color", base_color)?;
            share("metallic", *metallic)?;
            share("roughness", *roughness)?;
            index(*ior)?;
            share("transmission", *transmission)
        }
    }?;
    require(
        material.two_sided || !material.model.transmits(),
        || field("two_sided"),
        "what light passes through has two sides",
    )
}

/// A shape of a scene.
///
/// # Errors
/// What is wrong with it.
pub fn shape(shape: &ShapeDescription, scene: &SceneDescription) -> Result<()> {
    let field = |key: &str| format!("shape `{}`: {key}", shape.name);
    require(
        shape.material < scene.materials.len(),
        || field("material"),
        &format!("there are {} materials", scene.materials.len()),
    )?;
    in_group(shape.group, scene, || field("group"))?;
    placed(&shape.transform, || field("transform"))?;
    keys(&shape.motion, &shape.name)?;
    if let Some(emission) = &shape.emission {
        colour(emission, f32::MAX, || field("emission"))?;
    }
    match &shape.geometry {
        GeometryDescription::Mesh(triangles) => mesh(triangles, field),
        GeometryDescription::Sphere { center, radius } => {
            finite(*center, || field("center"))?;
            length(*radius, || field("radius"))
        }
        GeometryDescription::Rectangle {
            corner,
            edge_u,
            edge_v,
        } => {
            finite(*corner, || field("corner"))?;
            finite(*edge_u, || field("edge_u"))?;
            finite(*edge_v, || field("edge_v"))?;
            let has_area = edge_u.cross(*edge_v) != DVec3::ZERO;
            require(
                has_area,
                || field("edge_v"),
                "the edges are parallel: there is no area",
            )
        }
        GeometryDescription::Disk {
            center,
            normal,
            radius,
        } => {
            finite(*center, || field("center"))?;
            direction(*normal, || field("normal"))?;
            length(*radius, || field("radius"))
        }
        GeometryDescription::Box { min, max } => {
            finite(*min, || field("min"))?;
            finite(*max, || field("max"))?;
            let expected = "expected every coordinate of min below that of max";
            require(min.cmplt(*max).all(), || field("max"), expected)
        }
    }
}

/// An instance of a scene.
///
/// # Errors
/// What is wrong with it.
pub fn instance(instance: &InstanceDescription, scene: &SceneDescription) -> Result<()> {
    let field = |key: &str| format!("instance `{}`: {key}", instance.name);
    in_group(Some(instance.of), scene, || field("of"))?;
    in_group(instance.group, scene, || field("group"))?;
    placed(&instance.transform, || field("transform"))?;
    keys(&instance.motion, &instance.name)
}

/// A light that is no shape.
///
/// # Errors
/// What is wrong with it.
pub fn light(light: &LightDescription) -> Result<()> {
    let field = |key: &str| format!("light: {key}");
    match &light.model {
        LightModel::Environment { radiance, to_world } => {
            colour(radiance, f32::MAX, || field("radiance"))?;
            if let ColourDescription::Texture(texture) = radiance {
                let is_picture = matches!(**texture, Texture::Image { .. });
                let expected = "expected a colour or a picture: the sky is no checker";
                require(is_picture, || field("radiance"), expected)?;
            }
            let is_turned = to_world.is_finite() && is_rotation(to_world);
            require(is_turned, || field("to_world"), "expected a rotation")
        }
        LightModel::Point {
            position,
            intensity,
        } => {
            finite(*position, || field("position"))?;
            not_negative(*intensity, || field("intensity"))
        }
        LightModel::Spot {
            position,
            target,
            intensity,
            cone,
            penumbra,
        } => {
            finite(*position, || field("position"))?;
            finite(*target, || field("target"))?;
            direction(*target - *position, || field("target"))?;
            not_negative(*intensity, || field("intensity"))?;
            let expected = "expected an angle above 0, at most 180 degrees";
            require(*cone > 0.0 && *cone <= PI, || field("cone"), expected)?;
            let expected = "expected an angle from 0 to that of the cone";
            let is_within = (0.0..=*cone).contains(penumbra);
            require(is_within, || field("penumbra"), expected)
        }
        LightModel::Distant {
            direction: d,
            irradiance,
        } => {
            direction(*d, || field("direction"))?;
            not_negative(*irradiance, || field("irradiance"))
        }
    }
}

/// The lights of a scene together: one panorama at most.
///
/// # Errors
/// If there are more.
pub fn panoramas(lights: &[LightDescription]) -> Result<()> {
    let is_panorama = |light: &&LightDescription| {
        matches!(
            light.model,
            LightModel::Environment {
                radiance: ColourDescription::Texture(_),
                ..
            }
        )
    };
    require(
        lights.iter().filter(is_panorama).count() <= 1,
        || "light: radiance".to_owned(),
        "there is a picture as environment already: at most one, and any number of colours",
    )
}

fn mesh(mesh: &MeshDescription, field: impl Fn(&str) -> String) -> Result<()> {
    let count = mesh.positions.len();
    require(
        mesh.positions.iter().all(|p| p.is_finite()),
        || field("positions"),
        "expected finite numbers",
    )?;
    require(
        mesh.normals.is_empty() || mesh.normals.len() == count,
        || field("normals"),
        &format!("expected one for each of the {count} positions"),
    )?;
    require(
        mesh.normals.iter().all(|n| n.is_finite()),
        || field("normals"),
        "expected finite numbers",
    )?;
    require(
        mesh.uvs.is_empty() || mesh.uvs.len() == count,
        || field("uvs"),
        &format!("expected one for each of the {count} positions"),
    )?;
    require(
        mesh.uvs.iter().all(|uv| uv.as_vec2().is_finite()),
        || field("uvs"),
        "expected numbers within single precision",
    )?;
    let wrong = mesh
        .indices
        .iter()
        .flatten()
        .find(|&&i| i as usize >= count);
    match wrong {
        None => Ok(()),
        Some(index) => Err(Error::scene(format!(
            "vertex {index}, but there are {count} positions"
        ))
        .in_field(field("indices"))),
    }
}

fn keys(keys: &[Key], object: &str) -> Result<()> {
    let field = || format!("{object}: motion");
    for key in keys {
        require(key.time.is_finite(), field, "expected finite times")?;
        placed(&key.transform, field)?;
    }
    let in_order = keys.windows(2).all(|pair| pair[0].time < pair[1].time);
    require(in_order, field, "expected keys in order of time")
}

fn placed(transform: &DAffine3, field: impl Fn() -> String) -> Result<()> {
    require(
        transform.is_finite() && is_invertible(&transform.matrix3),
        field,
        "expected finite numbers, and a transform that does not flatten space",
    )
}

fn in_group(
    group: Option<usize>,
    scene: &SceneDescription,
    field: impl Fn() -> String,
) -> Result<()> {
    require(
        group.is_none_or(|group| group < scene.groups.len()),
        field,
        &format!("there are {} groups", scene.groups.len()),
    )
}

fn colour(colour: &ColourDescription, most: f32, field: impl Fn() -> String) -> Result<()> {
    let is_within = |c: Rgb| c.to_array().iter().all(|x| (0.0..=most).contains(x));
    let all_within = match colour {
        ColourDescription::Constant(colour) => is_within(*colour),
        ColourDescription::Texture(texture) => match texture.as_ref() {
            Texture::Image { image, scale } => {
                image.pixels().iter().all(|&p| is_within(*scale * p))
            }
            Texture::Checker { colours, repeat } => {
                repeat.is_finite() && colours.iter().all(|&c| is_within(c))
            }
        },
    };
    let expected = if most == 1.0 {
        "expected a value from 0 to 1 in every channel"
    } else {
        "expected a finite value of at least 0 in every channel"
    };
    require(all_within, field, expected)
}

/// The largest value in each channel.
fn brightest(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(colour) => *colour,
        ColourDescription::Texture(texture) => texture.brightest(),
    }
}

fn positive(colour: Rgb, field: impl Fn() -> String) -> Result<()> {
    let is_fine = colour.to_array().iter().all(|&x| x > 0.0 && x.is_finite());
    let expected = "expected a finite value above 0 in every channel";
    require(is_fine, field, expected)
}

fn not_negative(colour: Rgb, field: impl Fn() -> String) -> Result<()> {
    let is_fine = colour.to_array().iter().all(|&x| x >= 0.0 && x.is_finite());
    let expected = "expected a finite value of at least 0 in every channel";
    require(is_fine, field, expected)
}

fn finite(point: DVec3, field: impl Fn() -> String) -> Result<()> {
    require(point.is_finite(), field, "expected finite numbers")
}

fn length(length: f64, field: impl Fn() -> String) -> Result<()> {
    let is_fine = length > 0.0 && length.is_finite();
    require(is_fine, field, "expected a finite number above 0")
}

fn direction(direction: DVec3, field: impl Fn() -> String) -> Result<()> {
    let is_fine = direction.try_normalize().is_some();
    require(
        is_fine,
        field,
        "expected a finite direction that is not zero",
    )
}

fn require(is_fine: bool, field: impl Fn() -> String, expected: &str) -> Result<()> {
    if is_fine {
        Ok(())
    } else {
        Err(Error::scene(expected).in_field(field()))
    }
}
