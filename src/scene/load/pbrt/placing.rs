//! Places the shapes and object instances of a pbrt file.
//!
//! Measure: world units, mirrored where pbrt's camera is not; power in watts.
//! Range: transforms that are not singular. Objects become groups.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::builder::Builder;
use super::camera::keys;
use super::light::AreaLight;
use super::material::PbrtMaterial;
use super::mesh::Finish;
use super::params::Parameters;
use super::shape::ShapeAppearance;
use super::textured::{Mapping, Textured};
use crate::error::Result;
use crate::math::functions::cbrt;
use crate::math::rgb::Rgb;
use crate::math::transform::is_invertible;
use crate::math::vec::{DAffine3, DMat3};
use crate::scene::description::{
    ColourDescription, GeometryDescription, InstanceDescription, Keyframe, MaterialDescription,
    MaterialModel, Place, ShapeDescription,
};
use crate::scene::load::wording::{shown, unknown_name};
use std::rc::Rc;

/// The relative deviation from a uniform scale that files with few digits have.
const SCALE_TOLERANCE: f64 = 1e-4;

/// The transform of an object, and the keyframes of the transform that follows it.
type ObjectTransform = (DAffine3, Vec<Keyframe>);

impl Builder {
    /// Reads a `Shape` statement.
    ///
    /// # Errors
    /// If a parameter is not as the class requires, or the transform is singular.
    pub fn shape(&mut self, class: &str, params: &Parameters) -> Result<()> {
        let light = self.area_light(params);
        let Some((material, mapping)) = self.material(params, light.is_some())? else {
            return Ok(());
        };
        let is_textured = |colour: &ColourDescription| colour.constant().is_none();
        let emits_texture = light
            .as_ref()
            .is_some_and(|light| is_textured(&light.emission));
        let material_of_shape = &self.library.contents.materials[material];
        let textured = emits_texture || uses_uv(material_of_shape);
        let has_sides = material_of_shape.transmits()
            || light.as_ref().is_some_and(|light| !light.is_two_sided);
        let appearance = ShapeAppearance {
            finish: Finish {
                reverse: self.state.reverse,
                textured: textured.then_some(mapping),
            },
            has_sides,
        };
        let made = self
            .library
            .make_shape(class, params, appearance, &mut self.round_meshes)?;
        self.library.note_unused(params);
        let Some((geometry, before)) = made else {
            return Ok(());
        };
        let (transform, motion) = self.placed(params)?;
        let (transform, motion) =
            place_round(&geometry, transform * before, motion, &params.place, self);
        let name = format!(
            "{} {}",
            shown(class),
            self.library.contents.shapes.len() + 1
        );
        let mut shape = ShapeDescription {
            transform,
            motion,
            group: self.object,
            material,
            ..ShapeDescription::new(name, params.place.clone(), geometry)
        };
        match light {
            None => self.library.contents.shapes.push(shape),
            Some(light) => {
                shape.two_sided_emission = light.is_two_sided;
                return self.emitting(shape, &light, params);
            }
        }
        Ok(())
    }

    /// The light of the shape's surface, if it has any.
    fn area_light(&mut self, params: &Parameters) -> Option<Rc<AreaLight>> {
        let light = self.state.area_light.clone()?;
        if self.object.is_some() {
            let what = "a shape of an object does not emit, as in pbrt";
            self.library.decided(&params.place, what);
            return None;
        }
        Some(light)
    }

    /// The material of a shape, with its opacity, and how it changes texture coordinates; `None` if the shape is
    /// invisible.
    fn material(&mut self, params: &Parameters, emits: bool) -> Result<Option<(usize, Mapping)>> {
        let (material, mapping) = match self.state.material {
            None => (self.library.contents.default_material(), Mapping::default()),
            Some(PbrtMaterial::Surface { index, mapping }) => (index, mapping),
            Some(PbrtMaterial::Interface) => {
                if emits {
                    let what = "a shape of material `interface` does not emit, as in pbrt";
                    self.library.decided(&params.place, what);
                }
                return Ok(None);
            }
        };
        if !params.has("alpha") {
            return Ok(Some((material, mapping)));
        }
        let alpha = self.library.float(params, "alpha", 1.0)?;
        if alpha
            .colour
            .constant()
            .is_some_and(|alpha| alpha.to_array()[0] >= 1.0)
        {
            return Ok(Some((material, mapping)));
        }
        let is_textured = alpha.colour.constant().is_none();
        if emits && alpha.colour.constant() == Some(Rgb::BLACK) {
            let what = "an invisible light became visible, and black where it does not emit";
            self.library.approximated(&params.place_of("alpha"), what);
            let black = MaterialModel::Diffuse {
                reflectance: Rgb::BLACK.into(),
            };
            let material = MaterialDescription::new("black", params.place.clone(), black);
            let material = self.library.contents.add_material(material);
            return Ok(Some((material, Mapping::default())));
        }
        if is_textured
            && uses_uv(&self.library.contents.materials[material])
            && alpha.mapping != mapping
        {
            let what = "the mapping of the texture of alpha became that of the material's texture";
            self.library.approximated(&params.place_of("alpha"), what);
        }
        let mapping = match is_textured && !uses_uv(&self.library.contents.materials[material]) {
            true => alpha.mapping,
            false => mapping,
        };
        let key = (material, name_of(params, &alpha)?);
        let with_alpha = match self.alpha_materials.get(&key) {
            Some(known) => *known,
            None => {
                let made = self.library.with_alpha(material, &alpha);
                self.alpha_materials.insert(key, made);
                made
            }
        };
        Ok(Some((with_alpha, mapping)))
    }

    /// The transform that the current transforms give an object.
    fn placed(&self, params: &Parameters) -> Result<ObjectTransform> {
        let to_ours = match self.object {
            // An instance of the object has the reflection.
            Some(_) => DAffine3::IDENTITY,
            None => self.to_ours(),
        };
        let placed = self.state.transforms.map(|transform| to_ours * transform);
        let is_fine = |t: &DAffine3| t.is_finite() && is_invertible(&t.matrix3);
        if !placed.iter().all(is_fine) {
            return Err(params.error("the transform is singular: it flattens space"));
        }
        if !self.state.is_animated() {
            return Ok((placed[0], vec![]));
        }
        let times = self.times.unwrap_or([0.0, 1.0]);
        Ok((DAffine3::IDENTITY, keys(placed, times, params)?))
    }

    /// Begins the definition of an object, a group.
    ///
    /// # Errors
    /// If it is within another, or the name is taken.
    pub fn object_begin(&mut self, name: &str, place: &Place) -> Result<()> {
        self.in_world("ObjectBegin", place)?;
        if self.object.is_some() {
            return Err(place.error("expected ObjectEnd before another ObjectBegin"));
        }
        if self.library.contents.group_named(name).is_some() {
            return Err(place.error(format!("there is an object `{}` already", shown(name))));
        }
        self.begin_object_block(place)?;
        self.object = Some(self.library.contents.add_to_group(name));
        Ok(())
    }

    /// Places an object.
    ///
    /// # Errors
    /// If there is none of this name, or the transform is singular.
    pub fn object_instance(&mut self, name: &str, place: Place) -> Result<()> {
        self.in_world("ObjectInstance", &place)?;
        if self.object.is_some() {
            return Err(place.error("expected ObjectInstance outside of ObjectBegin and ObjectEnd"));
        }
        let Some(of) = self.library.contents.group_named(name) else {
            let known = self.library.contents.group_names();
            return Err(place.error(unknown_name("object", name, &known)));
        };
        let params = Parameters::new(place, vec![], vec![], self.state.gamut);
        let (transform, motion) = self.placed(&params)?;
        let name = format!("instance {}", self.library.contents.instances.len() + 1);
        self.library.contents.instances.push(InstanceDescription {
            name,
            place: params.place,
            of,
            group: None,
            transform,
            motion,
        });
        Ok(())
    }
}

/// Whether a material looks up textures.
fn uses_uv(material: &MaterialDescription) -> bool {
    let varies = |colour: &ColourDescription| colour.constant().is_none();
    let model_varies = match &material.model {
        MaterialModel::Diffuse { reflectance }
        | MaterialModel::Mirror { reflectance }
        | MaterialModel::Plastic { reflectance, .. } => varies(reflectance),
        MaterialModel::Dielectric { tint, .. } | MaterialModel::ThinDielectric { tint, .. } => {
            varies(tint)
        }
        MaterialModel::Phong {
            diffuse, specular, ..
        } => varies(diffuse) || varies(specular),
        MaterialModel::Principled { base_color, .. } => varies(base_color),
        MaterialModel::Conductor { .. } => false,
    };
    let has_detail = material.normal_map.is_some() || material.bump_map.is_some();
    model_varies || has_detail || varies(&material.alpha)
}

/// A name for an opacity: that of its texture, or its value.
fn name_of(params: &Parameters, alpha: &Textured) -> Result<String> {
    Ok(match params.texture("alpha")? {
        Some(name) => format!("texture {name}"),
        None => format!("{:?}", alpha.mean()),
    })
}

/// Places a round shape: its own transform has to scale evenly, what is applied after it need not.
fn place_round(
    geometry: &GeometryDescription,
    transform: DAffine3,
    motion: Vec<Keyframe>,
    place: &Place,
    builder: &mut Builder,
) -> ObjectTransform {
    let is_round = matches!(
        geometry,
        GeometryDescription::Sphere { .. } | GeometryDescription::Disk { .. }
    );
    if !is_round || !motion.is_empty() {
        return (transform, motion);
    }
    let [x, y, z] = [
        transform.matrix3.x_axis,
        transform.matrix3.y_axis,
        transform.matrix3.z_axis,
    ];
    let scale = cbrt(transform.matrix3.determinant().abs());
    let lengths = [x, y, z].map(|axis| axis.length() / scale);
    let cosines = [x.dot(y), y.dot(z), z.dot(x)].map(|dot| dot / (scale * scale));
    let is_small = |x: f64| x.abs() < SCALE_TOLERANCE;
    let is_even = lengths.iter().all(|length| is_small(length - 1.0))
        && cosines.iter().all(|&cos| is_small(cos));
    if is_even {
        let x = x.normalize();
        let y = (y - y.dot(x) * x).normalize();
        let z = x.cross(y) * transform.matrix3.determinant().signum();
        let matrix3 = DMat3::from_cols(x, y, z) * scale;
        return (
            DAffine3 {
                matrix3,
                ..transform
            },
            motion,
        );
    }
    builder
        .library
        .decided(place, "a round shape is scaled unevenly");
    let key = Keyframe {
        time: 0.0,
        transform,
    };
    (DAffine3::IDENTITY, vec![key])
}
