//! Spectra as colours: of light, of surfaces, and refractive indices.
//!
//! Measure: wavelengths in nm; colours in linear Rec. 709. Light is seen by the CIE 1931 2 degree observer, a surface as
//! it is lit by D65, an index is taken at the wavelengths that stand for the channels.
//! Range: any samples at increasing wavelengths; the spectrum is 0 beyond them. A colour outside of the gamut loses its
//! negative channels.
//! Source: CIE 015; Planck's law. Tested below.

use super::cie::{FIRST, STEP, TABLE};
use super::named_spectra;
use crate::math::functions::exp_m1;
use crate::math::rgb::Rgb;
use crate::math::vec::{DMat3, DVec3};
use std::sync::LazyLock;

/// The wavelengths of red, green and blue for refractive indices, as for `bsdf::conductor::PRESETS`.
const CHANNELS: [f64; 3] = [630.0, 532.0, 465.0];

/// The wavelength at which the index of glass is stated, in nm: the helium d line.
pub const D_LINE: f64 = 587.6;

/// Planck's second radiation constant, hc/k, in nm K.
const C2: f64 = 1.438_776_877e7;

/// Twice Planck's constant and the square of the speed of light, for wavelengths in micrometres and power per nm.
const C1: f64 = 1.191_042_972e5;

/// The primaries of Rec. 709.
const REC709: [[f64; 2]; 3] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]];

/// A spectrum that is linear between its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum(Vec<[f64; 2]>);

/// A spectrum with a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NamedSpectrum {
    /// The colour of an illuminant, of luminance 1.
    Light(Rgb),
    /// The real or imaginary part of a refractive index.
    Index(Rgb),
}

impl Spectrum {
    /// Creates a spectrum of wavelengths and values.
    ///
    /// # Errors
    /// If there are none, or the wavelengths do not increase, or a value is negative.
    pub fn new(samples: Vec<[f64; 2]>) -> Result<Self, String> {
        if samples.is_empty() {
            return Err("expected pairs of wavelength and value, found none".to_owned());
        }
        if let Some(pair) = samples.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
            return Err(format!(
                "expected increasing wavelengths, but {} follows {}",
                pair[1][0], pair[0][0]
            ));
        }
        let is_fine = |&[wavelength, value]: &[f64; 2]| {
            wavelength.is_finite() && (0.0..f64::INFINITY).contains(&value)
        };
        match samples.iter().find(|sample| !is_fine(sample)) {
            Some(bad) => Err(format!(
                "expected values of at least 0, found {} at {} nm",
                bad[1], bad[0]
            )),
            None => Ok(Self(samples)),
        }
    }

    /// Reads a text with a wavelength and a value on each line; `#` begins a comment.
    ///
    /// # Errors
    /// The line and what was expected there.
    pub fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut samples = vec![];
        for (index, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or("");
            let numbers: Vec<&str> = content.split_whitespace().collect();
            let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
            match numbers.as_slice() {
                [] => {}
                [wavelength, value] => match (number(wavelength), number(value)) {
                    (Some(wavelength), Some(value)) => samples.push([wavelength, value]),
                    _ => return Err((index + 1, "expected two numbers".to_owned())),
                },
                _ => return Err((index + 1, "expected a wavelength and a value".to_owned())),
            }
        }
        Self::new(samples).map_err(|why| (1, why))
    }

    /// The value at a wavelength.
    pub fn at(&self, wavelength: f64) -> f64 {
        let after = self.0.partition_point(|sample| sample[0] <= wavelength);
        match (after.checked_sub(1).map(|i| self.0[i]), self.0.get(after)) {
            (Some(a), Some(b)) => a[1] + (wavelength - a[0]) / (b[0] - a[0]) * (b[1] - a[1]),
            (Some(last), None) if last[0] == wavelength => last[1],
            _ => 0.0,
        }
    }

    /// The largest value.
    pub fn max(&self) -> f64 {
        self.0.iter().map(|sample| sample[1]).fold(0.0, f64::max)
    }

    /// The colour of light with this spectrum, of luminance 1; `None` if it is invisible.
    pub fn light(&self) -> Option<Rgb> {
        of_luminance_one(xyz(|wavelength| self.at(wavelength)))
    }

    /// The colour of light with this spectrum, of which one that is 1 everywhere has luminance 1.
    pub fn emitted(&self) -> Rgb {
        emitted(|wavelength| self.at(wavelength))
    }

    /// The colour of a surface with this reflectance in the light of D65, in [0, 1].
    pub fn surface(&self) -> Rgb {
        self.in_daylight().map(|x| x.min(1.0))
    }

    /// The colour of a factor that D65 is multiplied by, of any size.
    pub fn in_daylight(&self) -> Rgb {
        let reflected = xyz_with(|wavelength, d65| d65 * self.at(wavelength));
        let white = xyz_with(|_, d65| d65);
        to_rgb(*FROM_XYZ * (reflected / white.y))
    }

    /// The values at the wavelengths that stand for the channels.
    pub fn index(&self) -> Rgb {
        Rgb::from(CHANNELS.map(|wavelength| self.at(wavelength) as f32))
    }
}

/// The spectrum of this name, if there is one.
pub fn named(name: &str) -> Option<NamedSpectrum> {
    named_spectra::INDICES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|&(_, index)| NamedSpectrum::Index(Rgb::from(index)))
        .or_else(|| {
            let mut lights = named_spectra::ILLUMINANTS.iter();
            let (_, xy) = lights.find(|(known, _)| *known == name)?;
            Some(NamedSpectrum::Light(chromaticity(*xy)))
        })
}

/// The names of all spectra that have one.
pub fn names() -> Vec<&'static str> {
    let indices = named_spectra::INDICES.iter().map(|(name, _)| *name);
    indices
        .chain(named_spectra::ILLUMINANTS.iter().map(|(name, _)| *name))
        .collect()
}

/// The colour of a black body at a temperature in kelvins, of luminance 1; `None` where it emits no visible light.
pub fn blackbody(kelvin: f64) -> Option<Rgb> {
    of_luminance_one(xyz(|wavelength| planck(wavelength, kelvin)))
}

/// The colour of light that has the same power at every wavelength, of luminance 1.
pub fn equal_energy() -> Rgb {
    emitted(|_| 1.0)
}

/// The colour of the radiance of a black body at a temperature in kelvins, in W m^-2 sr^-1 nm^-1, of which only these
/// wavelengths count. A spectrum that is 1 everywhere has luminance 1.
pub fn blackbody_radiance(kelvin: f64, [from, to]: [f64; 2]) -> Rgb {
    emitted(|wavelength| match (from..=to).contains(&wavelength) {
        true => C1 * planck(wavelength, kelvin),
        false => 0.0,
    })
}

/// The colour of light with a spectrum, of which one that is 1 everywhere has luminance 1.
fn emitted(power: impl Fn(f64) -> f64) -> Rgb {
    let white = xyz(|_| 1.0);
    to_rgb(*FROM_XYZ * (xyz(power) / white.y))
}

/// Planck's law up to the factor `C1`.
fn planck(wavelength: f64, kelvin: f64) -> f64 {
    let x = 1e-3 * wavelength;
    x.powi(-5) / exp_m1(C2 / (wavelength * kelvin))
}

/// The colour of a chromaticity, of luminance 1.
pub fn chromaticity([x, y]: [f64; 2]) -> Rgb {
    to_rgb(*FROM_XYZ * (of_chromaticity([x, y])))
}

/// The matrix from the linear RGB of these primaries and this white to linear Rec. 709, without adaptation.
pub fn to_rec709(primaries: [[f64; 2]; 3], white: [f64; 2]) -> DMat3 {
    *FROM_XYZ * to_xyz(primaries, of_chromaticity(white))
}

/// The matrix from XYZ to linear Rec. 709, whose white is D65 as the observer sees it.
static FROM_XYZ: LazyLock<DMat3> = LazyLock::new(|| {
    let white = xyz_with(|_, d65| d65);
    to_xyz(REC709, white / white.y).inverse()
});

/// The matrix from the linear RGB of these primaries and this white to XYZ.
fn to_xyz(primaries: [[f64; 2]; 3], white: DVec3) -> DMat3 {
    let [r, g, b] = primaries.map(of_chromaticity);
    let unscaled = DMat3::from_cols(r, g, b);
    unscaled * DMat3::from_diagonal(unscaled.inverse() * white)
}

/// XYZ of a chromaticity, with Y = 1.
fn of_chromaticity([x, y]: [f64; 2]) -> DVec3 {
    // The blue primary of ACES has a negative y.
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// XYZ of a spectrum, up to a factor.
fn xyz(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    xyz_with(|wavelength, _| spectrum(wavelength))
}

/// XYZ of a function of wavelength and D65, up to a factor: by a sum over every nanometre, so that narrow lines count.
fn xyz_with(spectrum: impl Fn(f64, f64) -> f64) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (index, rows) in TABLE.windows(2).enumerate() {
        for step in 0..STEP as usize {
            let share = step as f64 / STEP;
            let between =
                |column: usize| rows[0][column] + share * (rows[1][column] - rows[0][column]);
            let wavelength = FIRST + STEP * index as f64 + step as f64;
            let observer = DVec3::new(between(0), between(1), between(2));
            sum += spectrum(wavelength, between(3)) * observer;
        }
    }
    sum
}

fn of_luminance_one(xyz: DVec3) -> Option<Rgb> {
    let scaled = xyz / xyz.y;
    (xyz.y > 0.0 && scaled.is_finite()).then(|| to_rgb(*FROM_XYZ * scaled))
}

/// A colour without its negative channels.
pub fn to_rgb(linear: DVec3) -> Rgb {
    Rgb::from(linear.to_array().map(|x| x.max(0.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f32; 3], tolerance: f32) {
        let difference = a.to_array().into_iter().zip(b).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f32::max) <= tolerance, "{a:?} {b:?}");
    }

    /// The CIE's chromaticity of D65, and of illuminant A, which is a black body of 2855.5 K.
    #[test]
    fn illuminant_chromaticities_match_cie_values() {
        let d65 = xyz_with(|_, d65| d65);
        let xy = |c: DVec3| [c.x / (c.x + c.y + c.z), c.y / (c.x + c.y + c.z)];
        let [x, y] = xy(d65);
        assert!(
            (x - 0.3127).abs() < 1e-4 && (y - 0.3290).abs() < 1e-4,
            "{x} {y}"
        );
        let [x, y] = xy(xyz(|wavelength| planck(wavelength, 2855.5)));
        assert!(
            (x - 0.4476).abs() < 2e-4 && (y - 0.4074).abs() < 2e-4,
            "{x} {y}"
        );
        let [x, y] = xy(xyz(|_| 1.0));
        assert!(
            (x - 1.0 / 3.0).abs() < 2e-4 && (y - 1.0 / 3.0).abs() < 2e-4,
            "{x} {y}"
        );
    }

    #[test]
    fn blackbody_has_unit_luminance_and_grey_reflectance_is_grey() {
        for kelvin in [2000.0, 4000.0, 6500.0, 20_000.0] {
            let colour = blackbody(kelvin).expect("it glows");
            assert!((colour.luminance() - 1.0).abs() < 1e-3, "{colour:?}");
        }
        let [warm, cold] =
            [2500.0, 15_000.0].map(|kelvin| blackbody(kelvin).expect("it glows").to_array());
        assert!(warm[0] > warm[2] && cold[0] < cold[2]);
        for kelvin in [0.0, -1.0, 1.0, f64::NAN] {
            assert_eq!(blackbody(kelvin), None, "{kelvin}");
        }
        let grey = Spectrum::new(vec![[300.0, 0.5], [900.0, 0.5]]).expect("valid");
        near(grey.surface(), [0.5; 3], 1e-6);
    }

    #[test]
    fn monochromatic_light_has_the_hue_of_its_wavelength() {
        let line = |nm: f64| Spectrum::new(vec![[nm - 1.0, 0.0], [nm, 1.0], [nm + 1.0, 0.0]]);
        let colour = |nm| {
            line(nm)
                .expect("valid")
                .light()
                .expect("visible")
                .to_array()
        };
        let (red, green, blue) = (colour(650.0), colour(535.0), colour(450.0));
        assert!(
            red[0] > 10.0 * red[1] && green[1] > green[0].max(green[2]) && blue[2] > 10.0 * blue[1]
        );
        assert!(line(1000.0).expect("valid").light().is_none());
    }

    #[test]
    fn spectrum_is_linear_between_samples_and_zero_outside() {
        let ramp = Spectrum::new(vec![[400.0, 0.0], [600.0, 2.0]]).expect("valid");
        for (nm, expected) in [
            (399.0, 0.0),
            (400.0, 0.0),
            (500.0, 1.0),
            (600.0, 2.0),
            (601.0, 0.0),
        ] {
            assert_eq!(ramp.at(nm), expected, "{nm}");
        }
        near(ramp.index(), [0.0, 1.32, 0.65], 1e-6);
        assert!(Spectrum::new(vec![[500.0, 1.0], [500.0, 1.0]]).is_err());
        assert!(Spectrum::new(vec![[500.0, -1.0]]).is_err());
        assert!(Spectrum::new(vec![]).is_err());
    }

    #[test]
    fn spectrum_file_is_parsed_as_one_pair_per_line() {
        let read = Spectrum::parse("# a comment\n400 0.5\n\n700\t1 # the end\n");
        assert_eq!(read, Ok(Spectrum(vec![[400.0, 0.5], [700.0, 1.0]])));
        assert_eq!(Spectrum::parse("400 1\n500 x\n").expect_err("x").0, 2);
        assert_eq!(Spectrum::parse("400 1 2\n").expect_err("three").0, 1);
    }

    #[test]
    fn rgb_conversion_preserves_white_and_is_identity_for_rec709() {
        let p3 = to_rec709(
            [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]],
            [0.3127, 0.3290],
        );
        near(to_rgb(p3 * DVec3::ONE), [1.0; 3], 2e-3);
        let same = to_rec709(REC709, [0.3127, 0.3290]);
        assert!(
            (same - DMat3::IDENTITY)
                .to_cols_array()
                .iter()
                .all(|x| x.abs() < 2e-3)
        );
    }

    #[test]
    fn named_spectra_are_found_by_name() {
        assert!(matches!(
            named("metal-Cu-eta"),
            Some(NamedSpectrum::Index(_))
        ));
        let Some(NamedSpectrum::Light(d65)) = named("stdillum-D65") else {
            panic!("it has a name");
        };
        near(d65, [1.0; 3], 2e-3);
        assert_eq!(named("metal-Xx-eta"), None);
        assert!(names().iter().all(|name| named(name).is_some()));
    }
}
