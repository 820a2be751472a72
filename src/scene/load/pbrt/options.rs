//! The statements before `WorldBegin`: camera, film, filter, sampler and integrator.
//!
//! Measure: world units; angles in degrees; the filter's radius in pixels.
//! Range: perspective cameras whose transform neither stretches nor skews. pbrt's camera looks along its z axis with x to
//! the right, ours along -z: a camera that is not mirrored shows the world mirrored, see [`Options::to_ours`].
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt.rs`.

use super::library::Library;
use super::params::Parameters;
use crate::error::Result;
use crate::image::MAX_SIDE;
use crate::math::transform::{is_invertible, orientation};
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{
    CameraDescription, FilmDescription, FilterDescription, FilterKind, Key, RenderDescription,
    Written,
};
use crate::scene::load::wording::unknown_name;

/// A statement of a class and parameters.
#[derive(Debug)]
pub struct Given {
    pub class: String,
    pub params: Parameters,
}

/// The statements before `WorldBegin` so far.
#[derive(Debug, Default)]
pub struct Options {
    /// The camera, the transform from world to camera at the start and the end, and the times of these.
    pub camera: Option<(Given, [DAffine3; 2], [f64; 2])>,
    pub film: Option<Given>,
    pub filter: Option<Given>,
    pub sampler: Option<Given>,
    pub integrator: Option<Given>,
    pub seed: Option<u64>,
}

/// What follows from the statements before `WorldBegin`.
#[derive(Debug)]
pub struct Settings {
    pub camera: CameraDescription,
    pub film: FilmDescription,
    pub render: RenderDescription,
    /// The imaging ratio: what the radiance of every light is multiplied by.
    pub exposure: f64,
    /// From pbrt's world to ours: the identity or a reflection.
    pub to_ours: DAffine3,
    /// The times at which the shutter opens and closes.
    pub shutter: [f64; 2],
}

/// The maximum deviation of a camera's axes from being orthonormal, which files with few digits have.
const SKEW: f64 = 1e-3;

impl Options {
    /// Reads everything; called at `WorldBegin`.
    ///
    /// # Errors
    /// If a parameter is not as pbrt requires, or the camera is of a kind that is not supported.
    pub fn settings(&self, defaults: &Parameters, library: &mut Library) -> Result<Settings> {
        let film = self.film(library)?;
        let to_ours = self.to_ours();
        let (camera, exposure, shutter) = self.camera(defaults, film.size, &to_ours, library)?;
        let iso = match &self.film {
            Some(film) => film
                .params
                .number_where("iso", 100.0, "a number above 0", |x| x > 0.0)?,
            None => 100.0,
        };
        let mut render = self.render(library)?;
        render.seed = self.seed;
        for given in [&self.film, &self.filter, &self.sampler, &self.integrator]
            .into_iter()
            .flatten()
        {
            library.note_unused(&given.params);
        }
        Ok(Settings {
            camera,
            film,
            render,
            exposure: exposure * iso / 100.0,
            to_ours,
            shutter,
        })
    }

    /// The reflection from pbrt's world to ours, or the identity. A camera with x to the right, y up and z forward is
    /// left-handed; files of right-handed worlds mirror it, and need no other change.
    fn to_ours(&self) -> DAffine3 {
        let is_mirrored =
            |camera: &(Given, [DAffine3; 2], [f64; 2])| camera.1[0].matrix3.determinant() < 0.0;
        if self.camera.as_ref().is_some_and(is_mirrored) {
            DAffine3::IDENTITY
        } else {
            DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))
        }
    }

    fn film(&self, library: &mut Library) -> Result<FilmDescription> {
        let filter = self.filter(library)?;
        let Some(Given { class, params }) = &self.film else {
            return Ok(FilmDescription {
                size: (1280, 720),
                filter,
            });
        };
        if !["rgb", "gbuffer", "spectral"].contains(&class.as_str()) {
            return Err(params.error(unknown_name("film", class, &["gbuffer", "rgb", "spectral"])));
        }
        let side = |name, default| params.whole(name, default, [1, MAX_SIDE as u32]);
        let size = (side("xresolution", 1280)?, side("yresolution", 720)?);
        for crop in ["cropwindow", "pixelbounds"] {
            if params.has(crop) {
                library.approximated(
                    &params.place_of(crop),
                    "the whole image is rendered, not only a part of it",
                );
            }
        }
        let sensor = params.text("sensor")?.unwrap_or("cie1931");
        if sensor != "cie1931" {
            let what = format!(
                "the sensor `{sensor}` became that of the CIE 1931 observer, without white balance"
            );
            library.approximated(&params.place_of("sensor"), what);
            params.has("whitebalance");
        } else if params.number("whitebalance", 0.0)? != 0.0 {
            library.omitted(
                &params.place_of("whitebalance"),
                "white balance was left out",
            );
        }
        if params.has("maxcomponentvalue") {
            library.omitted(
                &params.place_of("maxcomponentvalue"),
                "samples are not clamped",
            );
        }
        for ignored in [
            "filename",
            "savefp16",
            "diagonal",
            "coordinatesystem",
            "nbuckets",
            "lambdamin",
            "lambdamax",
        ] {
            params.has(ignored);
        }
        Ok(FilmDescription { size, filter })
    }

    fn filter(&self, library: &mut Library) -> Result<FilterDescription> {
        let Some(Given { class, params }) = &self.filter else {
            return Ok(FilterDescription {
                kind: FilterKind::Gaussian,
                radius: 1.5,
            });
        };
        let (kind, default) = match class.as_str() {
            "box" => (FilterKind::Box, 0.5),
            "triangle" => (FilterKind::Tent, 2.0),
            "gaussian" => (FilterKind::Gaussian, 1.5),
            "mitchell" => (FilterKind::Mitchell, 2.0),
            "sinc" => (FilterKind::BlackmanHarris, 4.0),
            _ => {
                let known = ["box", "gaussian", "mitchell", "sinc", "triangle"];
                return Err(params.error(unknown_name("filter", class, &known)));
            }
        };
        let radius = |name| {
            params.number_where(name, default, "a number above 0, up to 32", |x| {
                x > 0.0 && x <= 32.0
            })
        };
        let (x, y) = (radius("xradius")?, radius("yradius")?);
        if x != y {
            let what = format!("a filter of two radii became one of {x} pixels");
            library.approximated(&params.place, what);
        }
        match kind {
            FilterKind::BlackmanHarris => {
                params.has("tau");
                library.approximated(&params.place, "the filter `sinc` became `blackman-harris`");
            }
            FilterKind::Gaussian => {
                let sigma =
                    params.number_where("sigma", 0.5, "a number above 0", |sigma| sigma > 0.0)?;
                // Ours has a radius of three standard deviations.
                if (x - 3.0 * sigma).abs() > 1e-3 * x {
                    let what = format!(
                        "a Gaussian of standard deviation {sigma} became one of {}",
                        x / 3.0
                    );
                    library.approximated(&params.place, what);
                }
            }
            FilterKind::Mitchell => {
                let third = |name| params.number(name, 1.0 / 3.0);
                if [third("B")?, third("C")?]
                    .iter()
                    .any(|b| (b - 1.0 / 3.0).abs() > 1e-3)
                {
                    library
                        .approximated(&params.place, "B and C of the Mitchell filter became 1/3");
                }
            }
            _ => {}
        }
        Ok(FilterDescription { kind, radius: x })
    }

    /// The camera, the time that the shutter is open, and when it is.
    fn camera(
        &self,
        defaults: &Parameters,
        size: (u32, u32),
        to_ours: &DAffine3,
        library: &mut Library,
    ) -> Result<(CameraDescription, f64, [f64; 2])> {
        let still = [DAffine3::IDENTITY; 2];
        let (params, placed, times) = match &self.camera {
            Some((Given { class, params }, placed, times)) => {
                let known = ["orthographic", "perspective", "realistic", "spherical"];
                if class != "perspective" && known.contains(&class.as_str()) {
                    return Err(params.error(format!(
                        "cameras of class `{class}` are not supported, only perspective"
                    )));
                }
                if class != "perspective" {
                    return Err(params.error(unknown_name("camera", class, &known)));
                }
                (params, placed, *times)
            }
            None => (defaults, &still, [0.0, 1.0]),
        };
        let (open, close) = (
            params.number("shutteropen", 0.0)?,
            params.number("shutterclose", 1.0)?,
        );
        if open >= close {
            return Err(params.error_of(
                "shutterclose",
                "expected a shutter that closes after it opens",
            ));
        }
        let (to_world, scale) = camera_to_world(&placed[0], to_ours, params)?;
        let mut camera = CameraDescription {
            fov: vertical_fov(params, size, library)?,
            lens_radius: scale
                * params.number_where("lensradius", 0.0, "a number of at least 0", |x| x >= 0.0)?,
            focus_distance: scale
                * params.number_where("focaldistance", 1e6, "a number above 0", |x| x > 0.0)?,
            place: params.place.clone(),
            ..CameraDescription::pinhole(to_world, 1.0)
        };
        if placed[0] != placed[1] {
            let (last, _) = camera_to_world(&placed[1], to_ours, params)?;
            camera.motion = keys([to_world, last], times, params)?;
        }
        library.note_unused(params);
        Ok((camera, close - open, [open, close]))
    }

    fn render(&self, library: &mut Library) -> Result<RenderDescription> {
        let written = |value: &str, params: &Parameters| Written {
            value: value.to_owned(),
            line: params.place.line.unwrap_or(1),
        };
        let mut render = RenderDescription {
            spp: Some(16),
            max_bounces: Some(5),
            ..RenderDescription::default()
        };
        if let Some(Given { class, params }) = &self.sampler {
            let whole = |name, default| params.whole(name, default, [1, i32::MAX as u32]);
            let ours = match class.as_str() {
                "independent" => Some("independent"),
                "stratified" => Some("stratified"),
                "halton" | "paddedsobol" | "pmj02bn" | "sobol" | "zsobol" => None,
                _ => {
                    let known = [
                        "halton",
                        "independent",
                        "paddedsobol",
                        "pmj02bn",
                        "sobol",
                        "stratified",
                        "zsobol",
                    ];
                    return Err(params.error(unknown_name("sampler", class, &known)));
                }
            };
            render.sampler = ours.map(|name| written(name, params));
            render.spp = Some(match class.as_str() {
                "stratified" => u64::from(whole("xsamples", 4)?) * u64::from(whole("ysamples", 4)?),
                _ => u64::from(whole("pixelsamples", 16)?),
            });
            for ignored in ["randomization", "jitter", "seed"] {
                params.has(ignored);
            }
        }
        let Some(Given { class, params }) = &self.integrator else {
            return Ok(render);
        };
        render.max_bounces = Some(params.whole("maxdepth", 5, [0, i32::MAX as u32])?);
        let ours = match class.as_str() {
            "path" | "simplepath" | "volpath" | "simplevolpath" => "path",
            "bdpt" => "bdpt",
            "mlt" => "mlt",
            "ambientocclusion" | "function" | "lightpath" | "randomwalk" | "sppm" => {
                library.approximated(
                    &params.place,
                    format!("the integrator `{class}` became `path`"),
                );
                "path"
            }
            _ => {
                let known = [
                    "ambientocclusion",
                    "bdpt",
                    "function",
                    "lightpath",
                    "mlt",
                    "path",
                    "randomwalk",
                    "simplepath",
                    "simplevolpath",
                    "sppm",
                    "volpath",
                ];
                return Err(params.error(unknown_name("integrator", class, &known)));
            }
        };
        if params.truth("regularize", false)? {
            library.omitted(&params.place_of("regularize"), "BSDFs are not regularized");
        }
        // How pbrt computes the image, not which.
        for ignored in [
            "lightsampler",
            "usemis",
            "samplebsdf",
            "samplelights",
            "bootstrapsamples",
            "chains",
            "mutationsperpixel",
            "largestepprobability",
            "sigma",
            "photonsperiteration",
            "radius",
            "seed",
            "cossample",
            "maxdistance",
            "visualizestrategies",
            "visualizeweights",
        ] {
            params.has(ignored);
        }
        render.integrator = Some(written(ours, params));
        Ok(render)
    }
}

/// Keyframes of a motion between two transforms.
///
/// # Errors
/// If the times are not in order.
pub fn keys(transforms: [DAffine3; 2], times: [f64; 2], params: &Parameters) -> Result<Vec<Key>> {
    if times[0] >= times[1] {
        let [start, end] = times;
        return Err(params.error(format!(
            "expected TransformTimes in order, found {start} and {end}"
        )));
    }
    Ok(vec![
        Key {
            time: times[0],
            transform: transforms[0],
        },
        Key {
            time: times[1],
            transform: transforms[1],
        },
    ])
}

/// Our camera to our world, and the scale of the camera's units, from pbrt's world to its camera.
fn camera_to_world(
    from_world: &DAffine3,
    to_ours: &DAffine3,
    params: &Parameters,
) -> Result<(DAffine3, f64)> {
    let refuse =
        || params.error("expected a camera transform that neither flattens, stretches nor skews");
    if !from_world.is_finite() || !is_invertible(&from_world.matrix3) {
        return Err(refuse());
    }
    let placed = *to_ours * from_world.inverse();
    let [right, up, forward] = [
        placed.matrix3.x_axis,
        placed.matrix3.y_axis,
        placed.matrix3.z_axis,
    ];
    let scale = placed.matrix3.determinant().abs().cbrt();
    let lengths = [right, up, forward].map(|axis| axis.length() / scale);
    let cosines =
        [right.dot(up), up.dot(forward), forward.dot(right)].map(|dot| dot / (scale * scale));
    let is_rigid = lengths.iter().all(|length| (length - 1.0).abs() < SKEW)
        && cosines.iter().all(|cos| cos.abs() < SKEW);
    let matrix3 = orientation(-forward, up).filter(|axes| is_rigid && axes.x_axis.dot(right) > 0.0);
    let to_world = DAffine3 {
        matrix3: matrix3.ok_or_else(refuse)?,
        translation: placed.translation,
    };
    if to_world.is_finite() {
        Ok((to_world, scale))
    } else {
        Err(refuse())
    }
}

/// The vertical field of view in radians. pbrt's is that of the shorter side of the image.
fn vertical_fov(params: &Parameters, size: (u32, u32), library: &mut Library) -> Result<f64> {
    let fov = params.number_where("fov", 90.0, "an angle above 0 and below 180", |x| {
        x > 0.0 && x < 180.0
    })?;
    let aspect = f64::from(size.0) / f64::from(size.1);
    let frame = params.number_where("frameaspectratio", aspect, "a number above 0", |x| x > 0.0)?;
    let window = params.numbers("screenwindow")?;
    let [left, right, bottom, top] = match *window {
        [] if frame > 1.0 => [-frame, frame, -1.0, 1.0],
        [] => [-1.0, 1.0, -1.0 / frame, 1.0 / frame],
        [left, right, bottom, top] if left < right && bottom < top => [left, right, bottom, top],
        _ => {
            return Err(params.error_of(
                "screenwindow",
                "expected four numbers: left, right, bottom and top",
            ));
        }
    };
    let (width, height) = (right - left, top - bottom);
    let is_centred = (left + right).abs() < 1e-6 * width && (bottom + top).abs() < 1e-6 * height;
    if !is_centred {
        library.approximated(
            &params.place_of("screenwindow"),
            "the screen window was moved to the centre of the view",
        );
    }
    if (width / height - aspect).abs() > 1e-3 * aspect {
        let what = "the image is not as wide as the screen window: pixels are square, and the height counts";
        library.approximated(&params.place, what);
    }
    Ok(2.0 * (0.5 * height * (0.5 * fov).to_radians().tan()).atan())
}
