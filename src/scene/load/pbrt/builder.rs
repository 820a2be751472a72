//! Carries out the statements of a pbrt file, and collects the scene.
//!
//! Measure: world units. The world is mirrored where pbrt's camera is not, see `options.rs`.
//! Range: statements in the order that pbrt requires: options, `WorldBegin`, the world.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::environment::{Panorama, panorama};
use super::files::IncludeStack;
use super::gamut::Gamut;
use super::library::Library;
use super::material::{AlphaMaterials, PbrtMaterial};
use super::options::{Options, PbrtSettings};
use super::shape::RoundMeshes;
use super::state::{BlockStatement, GraphicsState, StateStack, look_at, rotation};
use super::statements::{self, Statement};
use super::tokens::Tokens;
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::math::vec::{DAffine3, DMat3};
use crate::scene::description::{
    ColourDescription, LightDescription, LightModel, Place, SceneDescription,
};
use crate::scene::load::wording::{shown, unknown_name};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The scene as far as it was read.
#[derive(Debug, Default)]
pub struct Builder {
    pub library: Library,
    pub state: GraphicsState,
    /// The settings that `WorldBegin` made of the options.
    pub settings: Option<PbrtSettings>,
    /// The group that is being defined.
    pub object: Option<usize>,
    pub times: Option<[f64; 2]>,
    /// Round shapes as meshes, and materials with opacity.
    pub round_meshes: RoundMeshes,
    pub alpha_materials: AlphaMaterials,
    pub options: Options,
    stack: StateStack,
    files: IncludeStack,
    pub spaces: HashMap<String, [DAffine3; 2]>,
    pub materials: HashMap<String, PbrtMaterial>,
    pub lights: Vec<LightDescription>,
    pub panoramas: Vec<Panorama>,
    pub panorama_place: Place,
    has_noted_media: bool,
}

impl Builder {
    /// Reads a file and carries out its statements.
    ///
    /// # Errors
    /// The first one that is not as pbrt requires.
    pub fn read(&mut self, path: &Path) -> Result<()> {
        let text = self.files.open(path)?;
        let mut tokens = Tokens::new(&text);
        let complain = |(line, why): (usize, String)| Error::scene(why).in_file(path).at_line(line);
        while let Some((statement, line)) = statements::next(&mut tokens).map_err(complain)? {
            let place = Place::on_line(path, line);
            self.carry_out(statement, place)?;
        }
        self.files.close();
        Ok(())
    }

    /// Ends the scene.
    ///
    /// # Errors
    /// If a block is open, or the world did not begin.
    pub fn finish(mut self, path: &Path) -> Result<SceneDescription> {
        if let Some((block, place)) = self.stack.innermost() {
            return Err(place.error(match block {
                BlockStatement::Attribute => {
                    "expected an AttributeEnd for this block, found the end of the file"
                }
                BlockStatement::Object => {
                    "expected an ObjectEnd for this block, found the end of the file"
                }
            }));
        }
        let settings = self.settings.take().ok_or_else(|| {
            Error::scene("expected WorldBegin, found the end of the file").in_file(path)
        })?;
        if let Some(image) = panorama(&self.panoramas)? {
            let texture = Texture::Image {
                image: Arc::new(image.into()),
                scale: 1.0,
            };
            let radiance = ColourDescription::Texture(Arc::new(texture));
            self.lights.push(LightDescription {
                place: self.panorama_place,
                model: LightModel::Environment {
                    radiance,
                    to_world: DMat3::IDENTITY,
                },
            });
        }
        let contents = self.library.contents;
        let mut camera = settings.camera;
        let shapes = contents.shapes.iter().map(|shape| shape.motion.len());
        let motions = shapes.chain(
            contents
                .instances
                .iter()
                .map(|instance| instance.motion.len()),
        );
        if motions.chain([camera.motion.len()]).any(|keys| keys > 1) {
            camera.shutter = settings.shutter;
        }
        Ok(SceneDescription {
            film: settings.film,
            render: settings.render,
            materials: contents.materials,
            shapes: contents.shapes,
            groups: contents.groups,
            instances: contents.instances,
            lights: self.lights,
            notes: contents.notes,
            ..SceneDescription::new(path, camera)
        })
    }

    fn carry_out(&mut self, statement: Statement, place: Place) -> Result<()> {
        match statement {
            Statement::Entity(entity, class, parameters) => {
                self.entity(entity, class, parameters, place)
            }
            Statement::Texture {
                name,
                value_type,
                class,
                parameters,
            } => self.texture(name, &value_type, &class, parameters, place),
            Statement::Include(name) | Statement::Import(name) if name.is_empty() => {
                Err(place.error("expected the name of a file"))
            }
            Statement::Include(name) => self.include(&name, &place),
            Statement::Import(name) => {
                let (state, depth) = (self.state.clone(), self.stack.depth());
                self.include(&name, &place)?;
                if self.stack.depth() != depth {
                    return Err(
                        place.error("expected an imported file to end the blocks that it begins")
                    );
                }
                self.state = state;
                Ok(())
            }
            Statement::AttributeBegin => {
                let pushed = self
                    .stack
                    .push(BlockStatement::Attribute, &self.state, &place);
                pushed.map_err(|why| place.error(why))
            }
            Statement::AttributeEnd => {
                self.state = self
                    .stack
                    .pop(BlockStatement::Attribute)
                    .map_err(|why| place.error(why))?;
                Ok(())
            }
            Statement::ObjectBegin(name) => self.object_begin(&name, &place),
            Statement::ObjectEnd => {
                self.state = self
                    .stack
                    .pop(BlockStatement::Object)
                    .map_err(|why| place.error(why))?;
                self.object = None;
                Ok(())
            }
            Statement::ObjectInstance(name) => self.object_instance(&name, place),
            Statement::WorldBegin => self.world_begin(place),
            Statement::Attribute(target, parameters) => self.attribute(&target, parameters, &place),
            Statement::Option(name, value) => self.option(&name, &value, &place),
            Statement::MediumInterface => {
                self.note_media(&place);
                Ok(())
            }
            Statement::NamedMaterial(name) => {
                self.in_world("NamedMaterial", &place)?;
                let found = self.materials.get(&name).copied();
                self.state.material = Some(found.ok_or_else(|| {
                    let mut names: Vec<&str> = self.materials.keys().map(String::as_str).collect();
                    names.sort_unstable();
                    place.error(unknown_name("material", &name, &names))
                })?);
                Ok(())
            }
            transform => self.transform(transform, &place),
        }
    }

    /// Carries out a statement about transforms, or another that only changes the state.
    fn transform(&mut self, statement: Statement, place: &Place) -> Result<()> {
        let direction =
            |found: Option<DAffine3>, what: &str| found.ok_or_else(|| place.error(what));
        match statement {
            Statement::Identity => self.state.change(|_| DAffine3::IDENTITY),
            Statement::Translate(by) => self.state.change(|t| t * DAffine3::from_translation(by)),
            Statement::Scale(by) => self.state.change(|t| t * DAffine3::from_scale(by)),
            Statement::Rotate { angle, axis } => {
                let turn = direction(rotation(angle, axis), "expected an axis that is not zero")?;
                self.state.change(|t| t * turn);
            }
            Statement::LookAt { eye, target, up } => {
                let what =
                    "eye and target are the same point, or up is along the line between them";
                let view = direction(look_at(eye, target, up), what)?;
                self.state.change(|t| t * view);
            }
            Statement::Transform(matrix) => self.state.change(|_| matrix),
            Statement::ConcatTransform(matrix) => self.state.change(|t| t * matrix),
            Statement::CoordinateSystem(name) => {
                self.spaces.insert(name, self.state.transforms);
            }
            Statement::CoordSysTransform(name) => match self.spaces.get(&name) {
                Some(space) => self.state.transforms = *space,
                None => {
                    let what = format!(
                        "there is no coordinate system `{}`: the transform is unchanged",
                        shown(&name)
                    );
                    self.library.decided(place, what);
                }
            },
            Statement::ActiveTransform(active) => self.state.active = active,
            Statement::TransformTimes(times) => {
                self.before_world("TransformTimes", place)?;
                self.times = Some(times);
            }
            Statement::ReverseOrientation => {
                self.in_world("ReverseOrientation", place)?;
                self.state.reverse = !self.state.reverse;
            }
            Statement::ColorSpace(name) => {
                let found = Gamut::ALL.iter().find(|(known, _)| *known == name);
                let names: Vec<&str> = Gamut::ALL.iter().map(|(known, _)| *known).collect();
                let found = found
                    .ok_or_else(|| place.error(unknown_name("colour space", &name, &names)))?;
                self.state.gamut = found.1;
            }
            other => unreachable!("{other:?} is carried out by its caller"),
        }
        Ok(())
    }

    fn include(&mut self, name: &str, place: &Place) -> Result<()> {
        let path = self.library.path(name);
        let read = self.read(&path);
        // Both places are reported.
        read.map_err(|error| place.error(error.to_string()).of_kind(error.kind()))
    }

    fn world_begin(&mut self, place: Place) -> Result<()> {
        self.before_world("WorldBegin", &place)?;
        self.settings = Some(self.options.settings(&place, &mut self.library)?);
        self.state.transforms = [DAffine3::IDENTITY; 2];
        self.state.active = [true; 2];
        self.spaces
            .insert("world".to_owned(), self.state.transforms);
        Ok(())
    }

    pub fn note_media(&mut self, place: &Place) {
        if !self.has_noted_media {
            self.library
                .omitted(place, "participating media were left out");
            self.has_noted_media = true;
        }
    }

    /// Requires that the world has not begun.
    pub fn before_world(&self, what: &str, place: &Place) -> Result<()> {
        match self.settings {
            None => Ok(()),
            Some(_) => Err(place.error(format!("expected {what} before WorldBegin"))),
        }
    }

    /// Requires that the world has begun.
    pub fn in_world(&self, what: &str, place: &Place) -> Result<()> {
        match self.settings {
            Some(_) => Ok(()),
            None => Err(place.error(format!("expected WorldBegin before {what}"))),
        }
    }

    /// The transform from pbrt's world to ours.
    pub fn to_ours(&self) -> DAffine3 {
        self.settings
            .as_ref()
            .map_or(DAffine3::IDENTITY, |settings| settings.to_ours)
    }

    pub fn exposure(&self) -> f64 {
        self.settings
            .as_ref()
            .map_or(1.0, |settings| settings.exposure)
    }

    /// Begins a block for an object.
    pub fn begin_object_block(&mut self, place: &Place) -> Result<()> {
        let pushed = self.stack.push(BlockStatement::Object, &self.state, place);
        pushed.map_err(|why| place.error(why))
    }
}
