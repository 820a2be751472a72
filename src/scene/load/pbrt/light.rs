//! Lights of a pbrt file: those without a shape, and the emission of shapes.
//!
//! Measure: world units; radiance, radiant intensity and irradiance as in the description, times the film's imaging
//! ratio. A spectrum other than `rgb` has luminance 1 before `scale`; `power` and `illuminance` replace its magnitude.
//! Range: point, spot, distant and infinite lights; others are left out with a note.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::environment::Panorama;
use super::library::Library;
use super::params::Parameters;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::math::functions::cos;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::{ColourDescription, LightDescription, LightModel};
use crate::scene::load::wording::unknown_name;
use std::f64::consts::PI;
use std::sync::Arc;

const CLASSES: &[&str] = &[
    "distant",
    "goniometric",
    "infinite",
    "point",
    "projection",
    "spot",
];

/// A light that a statement describes.
pub enum PbrtLight {
    Light(LightDescription),
    /// An image at infinity: all of them become one panorama.
    Panorama(Panorama),
    /// A light that was left out.
    Nothing,
}

/// The emission of a shape.
#[derive(Debug)]
pub struct AreaLight {
    pub emission: ColourDescription,
    pub is_two_sided: bool,
    /// The power of one shape, in watts; `emission` is then radiance up to a factor.
    pub power: Option<f64>,
    /// The luminance of `emission` on average, relative to which power is stated; 1 for colours.
    pub mean: f64,
}

impl Library {
    /// Reads a `LightSource` statement under a transform. `exposure` is the film's imaging ratio.
    ///
    /// # Errors
    /// If a parameter is not as the class requires.
    pub fn make_light(
        &mut self,
        class: &str,
        params: &Parameters,
        placed: &DAffine3,
        exposure: f64,
    ) -> Result<PbrtLight> {
        let light = |model| {
            PbrtLight::Light(LightDescription {
                place: params.place.clone(),
                model,
            })
        };
        let made = match class {
            "point" => {
                let factor = exposure * self.power_over(params, 4.0 * PI)?;
                let from = params.point("from", DVec3::ZERO)?;
                light(LightModel::Point {
                    position: placed.transform_point3(from),
                    intensity: self.emitted(params, "I", factor)?,
                })
            }
            "spot" => light(self.spot(params, placed, exposure)?),
            "distant" => {
                let [from, to] = self.from_to(params)?;
                let illuminance = params.number("illuminance", -1.0)?;
                let factor = exposure * if illuminance > 0.0 { illuminance } else { 1.0 };
                let direction = placed.transform_vector3(to - from);
                light(LightModel::Distant {
                    direction: self.some_direction(params, direction)?,
                    irradiance: self.emitted(params, "L", factor)?,
                })
            }
            "infinite" => self.infinite(params, placed, exposure)?,
            "goniometric" | "projection" => {
                self.omitted(&params.place, format!("a {class} light was left out"));
                return Ok(PbrtLight::Nothing);
            }
            _ => return Err(params.error(unknown_name("light", class, CLASSES))),
        };
        self.note_unused(params);
        Ok(made)
    }

    fn spot(
        &mut self,
        params: &Parameters,
        placed: &DAffine3,
        exposure: f64,
    ) -> Result<LightModel> {
        let [from, to] = self.from_to(params)?;
        let what = "an angle above 0, at most 180 degrees";
        let cone = params.number_where("coneangle", 30.0, what, |x| x > 0.0 && x <= 180.0)?;
        let penumbra =
            params.number_where("conedeltaangle", 5.0, "an angle of at least 0", |x| {
                x >= 0.0
            })?;
        if penumbra > cone {
            self.decided(
                &params.place_of("conedeltaangle"),
                "the penumbra fills the cone of a spot light",
            );
        }
        let penumbra = penumbra.min(cone);
        let [edge, full] = [cone, cone - penumbra].map(|angle| cos(angle.to_radians()));
        let factor = exposure * self.power_over(params, 2.0 * PI * (1.0 - 0.5 * (edge + full)))?;
        let [position, target] = [from, to].map(|point| placed.transform_point3(point));
        self.some_direction(params, target - position)?;
        Ok(LightModel::Spot {
            position,
            target,
            intensity: self.emitted(params, "I", factor)?,
            cone: cone.to_radians(),
            penumbra: penumbra.to_radians(),
        })
    }

    fn infinite(
        &mut self,
        params: &Parameters,
        placed: &DAffine3,
        exposure: f64,
    ) -> Result<PbrtLight> {
        if params.has("portal") {
            let what =
                "a portal was ignored: the light enters through the scene's openings as well";
            self.approximated(&params.place_of("portal"), what);
        }
        let illuminance = params.number("illuminance", -1.0)?;
        let wanted = (illuminance > 0.0).then_some(illuminance);
        if params.text("filename")?.is_none() {
            let factor = exposure * wanted.map_or(1.0, |illuminance| illuminance / PI);
            return Ok(PbrtLight::Light(LightDescription {
                place: params.place.clone(),
                model: LightModel::Environment {
                    radiance: self.emitted(params, "L", factor)?.into(),
                    to_world: DMat3::IDENTITY,
                },
            }));
        }
        if params.has("L") {
            return Err(params.error_of("L", "expected either L or filename, not both"));
        }
        let image = self.image(params, "filename")?;
        if image.width() != image.height() {
            let (width, height) = (image.width(), image.height());
            let message = format!(
                "expected a square image, an octahedral map of the sphere, found {width} x {height}"
            );
            return Err(params.error_of("filename", message));
        }
        let scale = exposure * self.scale(params)?;
        let panorama = Panorama::new(image, scale, placed.matrix3, wanted);
        panorama.map(PbrtLight::Panorama).ok_or_else(|| {
            params.error(
                "expected a light of finite radiance, under a transform that is not singular",
            )
        })
    }

    /// Reads what the shapes that follow an `AreaLightSource` emit.
    ///
    /// # Errors
    /// If a parameter is not as pbrt requires.
    pub fn area_light(
        &mut self,
        class: &str,
        params: &Parameters,
        exposure: f64,
    ) -> Result<AreaLight> {
        if class != "diffuse" {
            return Err(params.error(unknown_name("area light", class, &["diffuse"])));
        }
        let is_two_sided = params.truth("twosided", false)?;
        let power = params.number("power", -1.0)?;
        let mut mean = 1.0;
        let emission = if params.text("filename")?.is_some() {
            if params.has("L") {
                return Err(params.error_of("L", "expected either L or filename, not both"));
            }
            let image = self.image(params, "filename")?;
            let average: Rgb = image.mean().map(|x| x as f32).into();
            mean = f64::from(average.luminance());
            let scale = (exposure * self.scale(params)?) as f32;
            let texture = Texture::Image { image, scale };
            if !texture.brightest().is_finite() {
                return Err(params.error("expected radiance within single precision"));
            }
            ColourDescription::Texture(Arc::new(texture))
        } else {
            self.emitted(params, "L", exposure)?.into()
        };
        self.note_unused(params);
        Ok(AreaLight {
            emission,
            is_two_sided,
            power: (power > 0.0).then_some(power),
            mean,
        })
    }

    /// The colour of a light, white by default, times its scale and a factor.
    fn emitted(&mut self, params: &Parameters, name: &str, factor: f64) -> Result<Rgb> {
        let white = params.gamut_of(name).light(DVec3::ONE);
        let colour = self.light(params, name)?.unwrap_or(white);
        let factor = factor * self.scale(params)?;
        let emitted = colour.map(|x| (f64::from(x) * factor) as f32);
        if emitted.is_finite() {
            Ok(emitted)
        } else {
            Err(params.error_of(name, "expected a light within single precision"))
        }
    }

    fn scale(&self, params: &Parameters) -> Result<f64> {
        params.number_where("scale", 1.0, "a number of at least 0", |x| x >= 0.0)
    }

    /// The power of a light over that of unit intensity; 1 if it is not given.
    fn power_over(&self, params: &Parameters, unit: f64) -> Result<f64> {
        let power = params.number("power", -1.0)?;
        Ok(if power > 0.0 { power / unit } else { 1.0 })
    }

    fn from_to(&self, params: &Parameters) -> Result<[DVec3; 2]> {
        let from = params.point("from", DVec3::ZERO)?;
        Ok([from, params.point("to", DVec3::Z)?])
    }

    fn some_direction(&self, params: &Parameters, direction: DVec3) -> Result<DVec3> {
        let is_some = direction.is_finite() && direction.try_normalize().is_some();
        let what = "expected `from` and `to` to be different points";
        is_some
            .then_some(direction)
            .ok_or_else(|| params.error_of("to", what))
    }
}
