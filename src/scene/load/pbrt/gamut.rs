//! The colour spaces that `rgb` parameters may be given in.
//!
//! Measure: linear RGB of each space; the result in linear Rec. 709.
//! Range: the four spaces of pbrt-v4. Colours outside of Rec. 709 lose their negative channels.
//! Source: the primaries and white points of each standard. Tested in `tests/loading/pbrt/`.

use crate::math::rgb::Rgb;
use crate::math::vec::{DMat3, DVec3};
use crate::scene::load::spectrum::{to_rec709, to_rgb};

/// A colour space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gamut {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

/// The white of Rec. 2020 and of DCI-P3 as displays have it.
const D65: [f64; 2] = [0.3127, 0.3290];

impl Gamut {
    /// All spaces by name.
    pub const ALL: &'static [(&'static str, Self)] = &[
        ("srgb", Self::Srgb),
        ("dci-p3", Self::DciP3),
        ("rec2020", Self::Rec2020),
        ("aces2065-1", Self::Aces),
    ];

    /// The colour of light.
    pub fn light(self, rgb: DVec3) -> Rgb {
        match self.matrix() {
            None => to_rgb(rgb),
            Some(matrix) => to_rgb(matrix * rgb),
        }
    }

    /// The colour of a surface: what reflects all light is white in every space. At most 1 in each channel if the
    /// channels are.
    pub fn surface(self, rgb: DVec3) -> Rgb {
        match self.matrix() {
            None => to_rgb(rgb),
            Some(matrix) => {
                let adapted = matrix * rgb / (matrix * DVec3::ONE);
                to_rgb(adapted).map(|x| x.min(1.0))
            }
        }
    }

    fn matrix(self) -> Option<DMat3> {
        let (primaries, white) = match self {
            Self::Srgb => return None,
            Self::DciP3 => ([[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]], D65),
            Self::Rec2020 => ([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], D65),
            Self::Aces => (
                [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077]],
                [0.32168, 0.33767],
            ),
        };
        Some(to_rec709(primaries, white))
    }
}
