//! The statements before `WorldBegin`: camera, film, filter, sampler and integrator.
//!
//! Measure: world units; angles in degrees; the filter's radius in pixels.
//! Range: perspective cameras whose transform neither stretches nor skews. pbrt's camera looks along its z axis with x to
//! the right, ours along -z: a camera that is not mirrored shows the world mirrored, see [`to_ours`].
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::camera::GivenCamera;
use super::library::Library;
use super::params::Parameters;
use crate::error::Result;
use crate::image::MAX_SIDE;
use crate::math::vec::{DAffine3, DVec3};
use crate::planted::planted;
use crate::scene::description::{
    CameraDescription, FilmDescription, FilterDescription, FilterKind, Place, RenderDescription,
    WithLine,
};
use crate::scene::load::wording::unknown_name;

/// A statement of a class and parameters.
#[derive(Debug)]
pub struct ClassStatement {
    pub class: String,
    pub params: Parameters,
}

/// The statements before `WorldBegin` so far.
#[derive(Debug, Default)]
pub struct Options {
    pub camera: Option<GivenCamera>,
    pub film: Option<ClassStatement>,
    pub filter: Option<ClassStatement>,
    pub sampler: Option<ClassStatement>,
    pub integrator: Option<ClassStatement>,
    pub seed: Option<u64>,
}

/// The camera, film and render settings that follow from the statements before `WorldBegin`.
#[derive(Debug)]
pub struct PbrtSettings {
    pub camera: CameraDescription,
    pub film: FilmDescription,
    pub render: RenderDescription,
    /// The imaging ratio: what the radiance of every light is multiplied by.
    pub exposure: f64,
    /// The transform from pbrt's world to ours: the identity or a reflection.
    pub to_ours: DAffine3,
    /// The times at which the shutter opens and closes.
    pub shutter: [f64; 2],
}

impl Options {
    /// Reads everything; called at `WorldBegin`.
    ///
    /// # Errors
    /// If a parameter is not as pbrt requires, or the camera is of a kind that is not supported.
    pub fn settings(&mut self, place: &Place, library: &mut Library) -> Result<PbrtSettings> {
        let film = self.film(library)?;
        let camera = self.camera.take();
        let camera = camera.unwrap_or_else(|| GivenCamera::default_at(place));
        let to_ours = to_ours(&camera);
        let (camera, shutter) = camera.read(film.size, &to_ours, library)?;
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
        Ok(PbrtSettings {
            camera,
            film,
            render,
            exposure: (shutter[1] - shutter[0]) * iso / 100.0,
            to_ours,
            shutter,
        })
    }

    fn film(&self, library: &mut Library) -> Result<FilmDescription> {
        let filter = self.filter(library)?;
        let Some(ClassStatement { class, params }) = &self.film else {
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
        let Some(ClassStatement { class, params }) = &self.filter else {
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

    fn render(&self, library: &mut Library) -> Result<RenderDescription> {
        let mut render = RenderDescription {
            spp: Some(16),
            max_bounces: Some(5),
            ..RenderDescription::default()
        };
        if let Some(sampler) = &self.sampler {
            read_sampler(sampler, &mut render)?;
        }
        if let Some(integrator) = &self.integrator {
            read_integrator(integrator, &mut render, library)?;
        }
        Ok(render)
    }
}

fn read_sampler(
    ClassStatement { class, params }: &ClassStatement,
    render: &mut RenderDescription,
) -> Result<()> {
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
    Ok(())
}

fn read_integrator(
    ClassStatement { class, params }: &ClassStatement,
    render: &mut RenderDescription,
    library: &mut Library,
) -> Result<()> {
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
    Ok(())
}

fn written(value: &str, params: &Parameters) -> WithLine<String> {
    WithLine {
        value: value.to_owned(),
        line: params.place.line.unwrap_or(1),
    }
}

/// The reflection from pbrt's world to ours, or the identity. A camera with x to the right, y up and z forward is
/// left-handed; files of right-handed worlds mirror it, and need no other change.
fn to_ours(camera: &GivenCamera) -> DAffine3 {
    let keeps = planted!("pbrt-world-not-mirrored", true, camera.is_mirrored());
    match keeps {
        true => DAffine3::IDENTITY,
        false => DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
    }
}
