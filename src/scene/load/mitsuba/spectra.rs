//! Spectra of a Mitsuba scene as colours, by what they stand for.
//!
//! Measure: wavelengths in nm; linear Rec. 709. Reflectances and refractive indices are seen in the light of D65. Light
//! has W m^-2 sr^-1 nm^-1, and luminance 1 where its spectrum is 1.
//! Range: values from 0 to 1e30. A spectrum is 0 beyond its samples.
//! Source: Mitsuba 3 documentation, "Spectra". Tested in `tests/loading/mitsuba_spectra.rs`.

use super::super::spectrum::{Spectrum, equal_energy};
use super::super::wording::shown;
use crate::math::rgb::Rgb;
use std::rc::Rc;

/// The largest value of a spectrum, so that integrals of it are finite.
const MAX_VALUE: f64 = 1e30;

/// The meaning of a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMeaning {
    /// Colours of surfaces, and numbers for which a colour stands: images of eight bits are sRGB codes unless `raw`.
    Colour,
    /// The colour and strength of light; images as above.
    Light,
    /// Refractive indices.
    Index,
    /// Normals, which are as they are.
    Normals,
}

/// A spectrum as written.
#[derive(Debug, Clone)]
pub enum Spectral {
    /// One value at every wavelength.
    Uniform(f64),
    Sampled(Rc<Spectrum>),
}

impl Spectral {
    /// Takes samples whose values are within the range.
    ///
    /// # Errors
    /// If one is too large: a text that says what was expected.
    pub fn of_samples(samples: Spectrum) -> Result<Self, String> {
        match samples.max() {
            max if max > MAX_VALUE => Err(format!(
                "expected values of at most {MAX_VALUE:e}, found {max}"
            )),
            _ => Ok(Self::Sampled(Rc::new(samples))),
        }
    }

    /// Reads one value, or pairs of a wavelength and a value with a colon between them.
    ///
    /// # Errors
    /// If it is neither: a text that says what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite());
        let words = || {
            let words = text.split([' ', ',', '\t', '\n', '\r']);
            words.filter(|word| !word.is_empty())
        };
        if !text.contains(':') {
            let mut words = words().map(number);
            return match (words.next(), words.next()) {
                (Some(Some(value)), None) if (0.0..=MAX_VALUE).contains(&value) => {
                    Ok(Self::Uniform(value))
                }
                _ => Err(format!(
                    "expected one value from 0 to {MAX_VALUE:e}, or pairs of wavelength and value such as 400:0.5, found {}",
                    shown(text)
                )),
            };
        }
        let pair = |word| -> Result<[f64; 2], String> {
            let pair = str::split_once(word, ':');
            let numbers = pair.and_then(|(nm, value)| Some([number(nm)?, number(value)?]));
            numbers.ok_or_else(|| {
                format!(
                    "expected a wavelength and a value such as 400:0.5, found {}",
                    shown(word)
                )
            })
        };
        let samples = words().map(pair).collect::<Result<_, _>>()?;
        Spectrum::new(samples).and_then(Self::of_samples)
    }

    /// The colour that the spectrum is seen as.
    pub fn colour(&self, kind: ColourMeaning) -> Rgb {
        match (self, kind) {
            // The white of linear Rec. 709 is that of D65, and light of equal energy is more reddish.
            (Self::Uniform(value), ColourMeaning::Light) => *value as f32 * equal_energy(),
            (Self::Uniform(value), _) => Rgb::grey(*value as f32),
            (Self::Sampled(samples), ColourMeaning::Light) => samples.emitted(),
            (Self::Sampled(samples), ColourMeaning::Index) => samples.in_daylight(),
            (Self::Sampled(samples), _) => samples.surface(),
        }
    }
}
