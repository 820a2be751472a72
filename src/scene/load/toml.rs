//! The TOML scene.
//!
//! Measure: world units, degrees.
//! Range: version 1 of the format.
//! Source: docs/scene-format.md. Tested in `tests/scene_loading.rs` and `tests/bad_input.rs`.

use super::colour::{Bound, Textures, constant};
use super::reader::{Document, Table, Value};
use super::transform::transform;
use super::{material, read_text, shape};
use crate::error::Result;
use crate::image::MAX_SIDE;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::{
    CameraDescription, ColourDescription, FilmDescription, FilterDescription, FilterKind,
    MaterialDescription, MaterialModel, Place, RenderDescription, SceneDescription,
    ShapeDescription, Written,
};
use std::path::Path;

/// What is gathered while a scene is read.
#[derive(Debug, Default)]
pub struct Contents {
    pub materials: Vec<MaterialDescription>,
    /// What each material emits.
    emissions: Vec<Option<Rgb>>,
    pub shapes: Vec<ShapeDescription>,
    pub textures: Textures,
    pub notes: Vec<String>,
    default_material: Option<usize>,
}

impl Contents {
    /// Adds a material that gives its shapes this emission.
    pub fn add_material(&mut self, material: MaterialDescription, emission: Option<Rgb>) -> usize {
        self.materials.push(material);
        self.emissions.push(emission);
        self.materials.len() - 1
    }

    /// What a material's shapes emit.
    pub fn emission_of(&self, material: usize) -> Option<Rgb> {
        self.emissions[material]
    }

    /// The grey material of shapes that name none.
    pub fn default_material(&mut self) -> usize {
        if let Some(index) = self.default_material {
            return index;
        }
        let reflectance = ColourDescription::Constant(Rgb::grey(0.5));
        let index = self.add_material(
            MaterialDescription {
                name: "default".to_owned(),
                place: Place::default(),
                model: MaterialModel::Diffuse { reflectance },
            },
            None,
        );
        self.default_material = Some(index);
        index
    }

    /// Keeps a sentence for the user, once.
    pub fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }
}

/// Reads a scene.
///
/// # Errors
/// Whatever in it is not as the format says, or is wrong with a file that it names.
pub fn load(path: &Path) -> Result<SceneDescription> {
    let text = read_text(path)?;
    let document = Document {
        file: path,
        text: &text,
    };
    let parsed = document.parse()?;
    let root = Table::root(document, &parsed);
    let version = root.required("version")?;
    if version.number()? != 1.0 {
        return Err(version.expected("1, the version of the format that this program reads"));
    }
    let camera = camera(&root.required("camera")?.table()?)?;
    let film = film(root.optional("film").map(|film| film.table()).transpose()?)?;
    let render = match root.optional("render") {
        Some(render) => render_table(render.table()?)?,
        None => RenderDescription::default(),
    };
    let mut contents = Contents::default();
    for entry in list(&root, "material")? {
        let material = material::material(&entry, path, &mut contents.textures)?;
        if contents
            .materials
            .iter()
            .any(|known| known.name == material.name)
        {
            return Err(entry.error(format!("there is a material `{}` already", material.name)));
        }
        contents.add_material(material, None);
    }
    for (index, entry) in list(&root, "shape")?.iter().enumerate() {
        shape::shape(entry, path, index, &mut contents)?;
    }
    let environment = environment(&list(&root, "light")?)?;
    root.finish()?;
    Ok(SceneDescription {
        file: path.to_path_buf(),
        camera,
        film,
        render,
        materials: contents.materials,
        shapes: contents.shapes,
        environment,
        notes: contents.notes,
    })
}

/// The tables of `[[key]]`, none if there is no such key.
fn list<'a>(root: &Table<'a>, key: &'static str) -> Result<Vec<Value<'a>>> {
    root.optional(key)
        .map_or(Ok(Vec::new()), |value| value.list())
}

fn camera(table: &Table<'_>) -> Result<CameraDescription> {
    let (to_world, to_target) = match table.optional("transform") {
        Some(value) => {
            if let Some(other) = ["eye", "target", "up"]
                .into_iter()
                .find(|key| table.has(key))
            {
                let message = format!(
                    "expected either transform, or eye and target, but `{other}` is there too"
                );
                return Err(value.error(message));
            }
            (rigid(&value)?, 1.0)
        }
        None => {
            let eye = table.required("eye")?.vec3()?;
            let target = table.required("target")?;
            let up = table.optional("up").map_or(Ok(DVec3::Y), |up| up.vec3())?;
            let towards = target.vec3()?;
            let placed = look_at(eye, towards, up).ok_or_else(|| {
                target.error(
                    "eye and target are the same point, or up is along the line between them",
                )
            })?;
            (placed, eye.distance(towards))
        }
    };
    let positive = |key, default| match table.optional(key) {
        Some(value) => value.number_where("a number above 0", |x: f64| x > 0.0),
        None => Ok(default),
    };
    let fov = match table.optional("fov") {
        Some(fov) => fov.number_where("an angle in degrees above 0 and below 180", |x| {
            x > 0.0 && x < 180.0
        })?,
        None => 40.0,
    };
    let lens_radius = table.optional("lens_radius").map_or(Ok(0.0), |radius| {
        radius.number_where("a number of at least 0", |x| x >= 0.0)
    })?;
    if let Some(shutter) = table.optional("shutter") {
        let [open, close] = shutter.numbers::<2>()?;
        if open != close {
            return Err(
                shutter.error("motion is not supported by this version: expected equal times")
            );
        }
    }
    let camera = CameraDescription {
        to_world,
        fov: fov.to_radians(),
        lens_radius,
        focus_distance: positive("focus_distance", to_target)?,
    };
    table.finish()?;
    Ok(camera)
}

/// A camera at `eye` that looks at `target`; `None` where that leaves a direction open.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let back = (eye - target).try_normalize()?;
    let right = up.try_normalize()?.cross(back);
    // Nearly parallel vectors leave a direction that is mostly rounding.
    let right = (right.length() > 1e-9).then(|| right.normalize())?;
    Some(DAffine3 {
        matrix3: DMat3::from_cols(right, back.cross(right), back),
        translation: eye,
    })
}

/// A camera's transform: it may not stretch.
fn rigid(value: &Value<'_>) -> Result<DAffine3> {
    let placed = transform(value, "the camera")?;
    let matrix = placed.matrix3;
    let error = matrix.transpose() * matrix - DMat3::IDENTITY;
    let largest = error
        .to_cols_array()
        .into_iter()
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    if largest < 1e-6 && matrix.determinant() > 0.0 {
        Ok(placed)
    } else {
        Err(value.error(
            "expected rotations and translations only: a camera cannot be stretched or mirrored",
        ))
    }
}

fn film(table: Option<Table<'_>>) -> Result<FilmDescription> {
    let gaussian = FilterDescription {
        kind: FilterKind::Gaussian,
        radius: FilterKind::Gaussian.default_radius(),
    };
    let Some(table) = table else {
        return Ok(FilmDescription {
            size: (768, 512),
            filter: gaussian,
        });
    };
    let size = match table.optional("size") {
        Some(size) => {
            let sides = size.list()?;
            let [width, height] = sides.as_slice() else {
                return Err(size.expected("a list of width and height"));
            };
            let side = |value: &Value<'_>| value.whole(1, MAX_SIDE as u64).map(|side| side as u32);
            (side(width)?, side(height)?)
        }
        None => (768, 512),
    };
    let filter = match table.optional("filter") {
        None => gaussian,
        Some(name) if name.is_text() => {
            let kind = name.one_of(FilterKind::ALL)?;
            FilterDescription {
                kind,
                radius: kind.default_radius(),
            }
        }
        Some(filter) => {
            let filter = filter.table()?;
            let kind = filter.required("type")?.one_of(FilterKind::ALL)?;
            let radius = filter
                .optional("radius")
                .map_or(Ok(kind.default_radius()), |radius| {
                    radius.number_where("a number of pixels above 0, up to 32", |x| {
                        x > 0.0 && x <= 32.0
                    })
                })?;
            filter.finish()?;
            FilterDescription { kind, radius }
        }
    };
    table.finish()?;
    Ok(FilmDescription { size, filter })
}

fn render_table(table: Table<'_>) -> Result<RenderDescription> {
    let name = |key| -> Result<Option<Written<String>>> {
        let Some(value) = table.optional(key) else {
            return Ok(None);
        };
        Ok(Some(Written {
            value: value.text()?.to_owned(),
            line: value.line(),
        }))
    };
    let whole = |key, least, most| {
        table
            .optional(key)
            .map(|value| value.whole(least, most))
            .transpose()
    };
    let render = RenderDescription {
        integrator: name("integrator")?,
        sampler: name("sampler")?,
        spp: whole("spp", 1, u64::MAX)?,
        max_bounces: whole("max_bounces", 0, u64::from(u32::MAX))?.map(|n| n as u32),
        seed: whole("seed", 0, u64::MAX)?,
    };
    table.finish()?;
    Ok(render)
}

/// The sum of all environments, of which this version knows constant ones.
fn environment(lights: &[Value<'_>]) -> Result<Rgb> {
    let mut sum = Rgb::BLACK;
    for light in lights {
        let table = light.table()?;
        table.required("type")?.one_of(&[("environment", ())])?;
        let radiance = table.required("radiance")?;
        if radiance.table().is_ok_and(|table| table.has("texture")) {
            return Err(radiance.error(
                "a map as environment is not supported by this version: expected a colour",
            ));
        }
        sum += constant(&radiance, Bound::NonNegative)?;
        table.finish()?;
    }
    Ok(sum)
}
