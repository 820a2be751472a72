//! The camera of a pbrt file.
//!
//! Measure: world units, degrees. pbrt's camera looks along its z axis with x to the right, ours along -z.
//! Range: perspective cameras whose transform neither stretches nor skews.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/worlds.rs`.

use super::gamut::Gamut;
use super::library::Library;
use super::params::Parameters;
use crate::error::Result;
use crate::math::functions::{atan, cbrt, tan};
use crate::math::transform::{is_invertible, orientation};
use crate::math::vec::DAffine3;
use crate::scene::description::{CameraDescription, Keyframe, Place};
use crate::scene::load::wording::unknown_name;

/// A `Camera` statement.
#[derive(Debug)]
pub struct GivenCamera {
    pub class: String,
    pub params: Parameters,
    /// The transforms from the world to the camera at the start and at the end, and the times of these.
    pub from_world: [DAffine3; 2],
    pub times: [f64; 2],
}

/// The maximum deviation of a camera's axes from being orthonormal, which files with few digits have.
const SKEW: f64 = 1e-3;

impl GivenCamera {
    /// The camera of files without one.
    pub fn default_at(place: &Place) -> Self {
        Self {
            class: "perspective".to_owned(),
            params: Parameters::new(place.clone(), vec![], vec![], Gamut::default()),
            from_world: [DAffine3::IDENTITY; 2],
            times: [0.0, 1.0],
        }
    }

    /// Whether the camera has x to the right in a right-handed world.
    pub fn is_mirrored(&self) -> bool {
        self.from_world[0].matrix3.determinant() < 0.0
    }

    /// The camera for an image of this size, and the times at which the shutter opens and closes.
    ///
    /// # Errors
    /// If a parameter is not as pbrt requires, or the camera is of a kind that is not supported.
    pub fn read(
        &self,
        size: (u32, u32),
        to_ours: &DAffine3,
        library: &mut Library,
    ) -> Result<(CameraDescription, [f64; 2])> {
        let known = ["orthographic", "perspective", "realistic", "spherical"];
        let (class, params) = (self.class.as_str(), &self.params);
        if class != "perspective" && known.contains(&class) {
            let message = format!("cameras of class `{class}` are not supported, only perspective");
            return Err(params.error(message));
        }
        if class != "perspective" {
            return Err(params.error(unknown_name("camera", class, &known)));
        }
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
        let (to_world, scale) = camera_to_world(&self.from_world[0], to_ours, params)?;
        let mut camera = CameraDescription {
            fov: vertical_fov(params, size, library)?,
            lens_radius: scale
                * params.number_where("lensradius", 0.0, "a number of at least 0", |x| x >= 0.0)?,
            focus_distance: scale
                * params.number_where("focaldistance", 1e6, "a number above 0", |x| x > 0.0)?,
            place: params.place.clone(),
            ..CameraDescription::pinhole(to_world, 1.0)
        };
        if self.from_world[0] != self.from_world[1] {
            let (last, _) = camera_to_world(&self.from_world[1], to_ours, params)?;
            camera.motion = keys([to_world, last], self.times, params)?;
        }
        library.note_unused(params);
        Ok((camera, [open, close]))
    }
}

/// Keyframes of a motion between two transforms.
///
/// # Errors
/// If the times are not in order.
pub fn keys(
    transforms: [DAffine3; 2],
    times: [f64; 2],
    params: &Parameters,
) -> Result<Vec<Keyframe>> {
    if times[0] >= times[1] {
        let [start, end] = times;
        return Err(params.error(format!(
            "expected TransformTimes in order, found {start} and {end}"
        )));
    }
    Ok(vec![
        Keyframe {
            time: times[0],
            transform: transforms[0],
        },
        Keyframe {
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
    let scale = cbrt(placed.matrix3.determinant().abs());
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
    Ok(2.0 * atan(0.5 * height * tan((0.5 * fov).to_radians())))
}
