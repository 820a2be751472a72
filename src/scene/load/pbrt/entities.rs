//! Carries out the statements of a pbrt file that have a class and parameters.
//!
//! Measure: as in the file.
//! Range: statements in the order that pbrt requires: options, `WorldBegin`, the world.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::builder::Builder;
use super::camera::GivenCamera;
use super::light;
use super::options::ClassStatement;
use super::parameter::Parameter;
use super::params::Parameters;
use super::state::TARGETS;
use super::statements::Entity;
use super::texture::TextureType;
use crate::error::Result;
use crate::scene::description::Place;
use crate::scene::load::wording::{shown, unknown_name};
use std::rc::Rc;

impl Builder {
    /// Carries out a statement of a class and parameters.
    pub fn entity(
        &mut self,
        entity: Entity,
        class: String,
        own: Vec<Rc<Parameter>>,
        place: Place,
    ) -> Result<()> {
        if entity.is_option() {
            self.before_world(entity.name(), &place)?;
        } else if entity != Entity::MakeNamedMedium {
            self.in_world(entity.name(), &place)?;
        }
        let target = match entity {
            Entity::Shape => "shape",
            Entity::LightSource | Entity::AreaLightSource => "light",
            Entity::Material | Entity::MakeNamedMaterial => "material",
            _ => "",
        };
        let params = Parameters::new(
            place,
            own,
            self.state.defaults_for(target),
            self.state.gamut,
        );
        match entity {
            Entity::Accelerator => {}
            Entity::Camera => {
                let from_world = self.state.transforms;
                let to_world = from_world.map(|t| t.inverse());
                self.spaces.insert("camera".to_owned(), to_world);
                let times = self.times.unwrap_or([0.0, 1.0]);
                self.options.camera = Some(GivenCamera {
                    class,
                    params,
                    from_world,
                    times,
                });
            }
            Entity::Film => self.options.film = Some(ClassStatement { class, params }),
            Entity::PixelFilter => self.options.filter = Some(ClassStatement { class, params }),
            Entity::Sampler => self.options.sampler = Some(ClassStatement { class, params }),
            Entity::Integrator => self.options.integrator = Some(ClassStatement { class, params }),
            Entity::MakeNamedMedium => self.note_media(&params.place),
            Entity::Material => {
                let name = format!("{class} {}", self.library.contents.materials.len() + 1);
                self.state.material =
                    Some(
                        self.library
                            .make_material(&class, &name, &params, &self.materials)?,
                    );
            }
            Entity::MakeNamedMaterial => {
                let name = shown(&class);
                if self.materials.contains_key(&class) {
                    return Err(params.error(format!("there is a material `{name}` already")));
                }
                let Some(kind) = params.text("type")?.map(str::to_owned) else {
                    return Err(params.error("expected a parameter `string type`"));
                };
                let made = self
                    .library
                    .make_material(&kind, &name, &params, &self.materials)?;
                self.materials.insert(class, made);
            }
            Entity::AreaLightSource => {
                let exposure = self.exposure();
                let made = self.library.area_light(&class, &params, exposure)?;
                self.state.area_light = Some(Rc::new(made));
            }
            Entity::LightSource => return self.light(&class, &params),
            Entity::Shape => return self.shape(&class, &params),
        }
        Ok(())
    }

    fn light(&mut self, class: &str, params: &Parameters) -> Result<()> {
        if self.state.is_animated() {
            self.library
                .approximated(&params.place, "a moving light stays where it starts");
        }
        let placed = self.to_ours() * self.state.transforms[0];
        let exposure = self.exposure();
        match self.library.make_light(class, params, &placed, exposure)? {
            light::PbrtLight::Light(light) => self.lights.push(light),
            light::PbrtLight::Panorama(map) => {
                self.panorama_place = params.place.clone();
                self.panoramas.push(map);
            }
            light::PbrtLight::Nothing => {}
        }
        Ok(())
    }

    pub fn texture(
        &mut self,
        name: String,
        value_type: &str,
        class: &str,
        own: Vec<Rc<Parameter>>,
        place: Place,
    ) -> Result<()> {
        self.in_world("Texture", &place)?;
        let params = Parameters::new(
            place,
            own,
            self.state.defaults_for("texture"),
            self.state.gamut,
        );
        let kind = match value_type {
            "float" => TextureType::Float,
            "spectrum" => TextureType::Colour,
            _ => {
                return Err(params.error(unknown_name(
                    "texture type",
                    value_type,
                    &["float", "spectrum"],
                )));
            }
        };
        let made = self.library.make_texture(class, kind, &params)?;
        self.library.note_unused(&params);
        let known = match kind {
            TextureType::Float => &mut self.library.floats,
            TextureType::Colour => &mut self.library.colours,
        };
        if known.insert(name.clone(), made).is_some() {
            let name = shown(&name);
            return Err(params.error(format!("there is a {value_type} texture `{name}` already")));
        }
        Ok(())
    }

    pub fn attribute(
        &mut self,
        target: &str,
        own: Vec<Rc<Parameter>>,
        place: &Place,
    ) -> Result<()> {
        let Some(index) = TARGETS.iter().position(|known| *known == target) else {
            return Err(place.error(unknown_name("attribute target", target, &TARGETS)));
        };
        let known = Rc::make_mut(&mut self.state.defaults[index]);
        for parameter in own {
            parameter.fix_gamut(self.state.gamut);
            // The latest default of a name counts.
            known.retain(|older| older.name != parameter.name);
            known.push(parameter);
        }
        Ok(())
    }

    pub fn option(&mut self, name: &str, value: &str, place: &Place) -> Result<()> {
        const KNOWN: &[&str] = &[
            "disablepixeljitter",
            "disabletexturefiltering",
            "disablewavelengthjitter",
            "displacementedgescale",
            "forcediffuse",
            "msereferenceimage",
            "msereferenceout",
            "pixelstats",
            "rendercoordsys",
            "seed",
            "wavefront",
        ];
        let plain = name.replace(['-', '_'], "").to_lowercase();
        if !KNOWN.contains(&plain.as_str()) {
            return Err(place.error(unknown_name("option", &plain, KNOWN)));
        }
        match plain.as_str() {
            "seed" => {
                let seed = value.parse().ok();
                self.options.seed = Some(seed.ok_or_else(|| {
                    place.error(format!(
                        "expected a whole number of at least 0, found `{}`",
                        shown(value)
                    ))
                })?);
            }
            "disablepixeljitter" | "forcediffuse" if value == "true" => {
                self.library
                    .omitted(place, format!("option `{plain}` was ignored"));
            }
            _ => {}
        }
        Ok(())
    }
}
