//! Textures: colours that vary over a surface.
//!
//! Measure: linear Rec. 709; uv in [0, 1] over the image, v up: v = 0 is the lower edge of its last row.
//! Range: any finite uv: the image repeats. For other uv the colour is unspecified and may not be finite.
//! Source: bilinear interpolation between texel centres. Tested below.

use super::texture_image::TextureImage;
use super::uv_map::{UvMap, Wrap};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use serde::Serialize;
use std::sync::Arc;

/// A texture.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub enum Texture {
    /// An image.
    Image {
        /// The texels, in linear values.
        image: Arc<TextureImage>,
        /// The factor of every value.
        scale: f32,
    },
    /// An image that does not simply repeat over [0, 1].
    Placed {
        /// The texels, in linear values.
        image: Arc<TextureImage>,
        /// The factor of every value, by channel.
        tint: Rgb,
        /// The place of the image on the surface.
        uv_map: UvMap,
    },
    /// A checkerboard of two colours.
    Checker {
        /// The colours; the first one is at uv = (0, 0).
        colours: [Rgb; 2],
        /// The number of fields over [0, 1] in u and in v.
        repeat: Vec2,
    },
}

impl Texture {
    /// The colour at `uv`.
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        self.lookup_with(uv, |texel| texel)
    }

    /// The colour at `uv`, with a function of the texels of an image in their place.
    #[inline]
    pub fn lookup_with(&self, uv: Vec2, decode: impl Fn(Rgb) -> Rgb) -> Rgb {
        match self {
            Self::Image { image, scale } => *scale * image.lookup_with(uv, decode),
            Self::Placed {
                image,
                tint,
                uv_map,
            } => *tint * image.lookup_with(uv_map.apply(image.size(), uv), decode),
            Self::Checker { colours, repeat } => {
                let field = uv * *repeat;
                decode(colours[usize::from(is_odd(field.x) != is_odd(field.y))])
            }
        }
    }

    /// The derivatives of the luminance by u and v: the difference over one texel, which varies continuously where the
    /// derivative of the bilinear interpolation has steps. A checkerboard has none.
    #[inline]
    pub fn gradient(&self, uv: Vec2) -> Vec2 {
        match self {
            Self::Image { image, scale } => {
                let at = |offset| image.lookup(uv + offset).luminance();
                *scale * difference_quotients(image.size(), at)
            }
            Self::Placed {
                image,
                tint,
                uv_map,
            } => {
                let uv = uv_map.mapped(uv);
                let at = |offset| {
                    let uv = uv_map.wrapped(image.size(), uv + offset);
                    (*tint * image.lookup(uv)).luminance()
                };
                uv_map.pull_back(difference_quotients(image.size(), at))
            }
            Self::Checker { .. } => Vec2::ZERO,
        }
    }

    /// The largest value in each channel.
    pub fn brightest(&self) -> Rgb {
        match self {
            Self::Image { image, scale } => *scale * brightest(image),
            Self::Placed { image, tint, .. } => *tint * brightest(image),
            Self::Checker { colours, .. } => larger(colours[0], colours[1]),
        }
    }

    /// The mean over the image, or over both colours.
    pub fn mean(&self) -> Rgb {
        let of_image = |image: &TextureImage| Rgb::from(image.mean().map(|x| x as f32));
        match self {
            Self::Image { image, scale } => *scale * of_image(image),
            Self::Placed { image, tint, .. } => *tint * of_image(image),
            Self::Checker { colours, .. } => 0.5 * (colours[0] + colours[1]),
        }
    }

    /// The texture with a function of each of its values.
    pub fn map(&self, f: impl Fn(Rgb) -> Rgb) -> Self {
        match self {
            Self::Image { image, scale } => Self::Image {
                image: Arc::new(image.map(|texel| f(*scale * texel))),
                scale: 1.0,
            },
            Self::Placed {
                image,
                tint,
                uv_map,
            } => Self::Placed {
                image: Arc::new(image.map(|texel| f(*tint * texel))),
                tint: Rgb::WHITE,
                uv_map: *uv_map,
            },
            Self::Checker { colours, repeat } => Self::Checker {
                colours: colours.map(f),
                repeat: *repeat,
            },
        }
    }

    /// The texture of an image that continues in this way beyond its edges; others as they are.
    pub fn continued(self, wrap: Wrap) -> Self {
        match self {
            Self::Image { image, scale } if wrap != Wrap::Repeat => Self::Placed {
                image,
                tint: Rgb::grey(scale),
                uv_map: UvMap {
                    wrap: [wrap; 2],
                    ..UvMap::default()
                },
            },
            texture => texture,
        }
    }

    /// The texture times a factor.
    pub fn scaled(&self, by: f32) -> Self {
        match self {
            Self::Image { image, scale } => Self::Image {
                image: Arc::clone(image),
                scale: by * scale,
            },
            Self::Placed {
                image,
                tint,
                uv_map,
            } => Self::Placed {
                image: Arc::clone(image),
                tint: by * *tint,
                uv_map: *uv_map,
            },
            Self::Checker { colours, repeat } => Self::Checker {
                colours: colours.map(|colour| by * colour),
                repeat: *repeat,
            },
        }
    }

    /// The colour, if it is the same everywhere; identical to that of [`Texture::lookup`].
    pub fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Image { image, scale } => only_colour(image).map(|colour| *scale * colour),
            Self::Placed { image, tint, .. } => only_colour(image).map(|colour| *tint * colour),
            Self::Checker { colours, .. } => (colours[0] == colours[1]).then_some(colours[0]),
        }
    }
}

/// The largest value of each channel.
fn brightest(image: &TextureImage) -> Rgb {
    image.texels().fold(Rgb::BLACK, larger)
}

/// The colour of every texel, if it is the same.
fn only_colour(image: &TextureImage) -> Option<Rgb> {
    let first = image.get(0, 0);
    image.texels().all(|texel| texel == first).then_some(first)
}

/// The larger value in each channel.
fn larger(a: Rgb, b: Rgb) -> Rgb {
    let (a, b) = (a.to_array(), b.to_array());
    Rgb::from([0, 1, 2].map(|i| a[i].max(b[i])))
}

/// The derivatives by u and v over one texel of an image of this width and height, of a function of the offset from the
/// place of the lookup.
#[inline]
fn difference_quotients((width, height): (u32, u32), at: impl Fn(Vec2) -> f32) -> Vec2 {
    let texels = Vec2::new(width as f32, height as f32);
    let across = |offset: Vec2| at(offset) - at(-offset);
    texels
        * Vec2::new(
            across(0.5 * Vec2::X / texels),
            across(0.5 * Vec2::Y / texels),
        )
}

/// Whether the largest whole number not above `x` is odd.
fn is_odd(x: f32) -> bool {
    let half = 0.5 * x.floor();
    half != half.floor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use proptest::prelude::*;

    /// Texels 0 1 2 / 3 4 5, the row of 0 on top.
    fn numbers() -> Texture {
        let pixels = (0..6_u8).map(|i| Rgb::grey(f32::from(i))).collect();
        Texture::Image {
            image: Arc::new(Image::new(3, 2, pixels).into()),
            scale: 1.0,
        }
    }

    fn at(texture: &Texture, u: f32, v: f32) -> f32 {
        texture.lookup(Vec2::new(u, v)).to_array()[0]
    }

    #[test]
    fn texel_centre_lookup_returns_the_texel_with_v_up() {
        let texture = numbers();
        for (v, first) in [(0.75, 0.0), (0.25, 3.0)] {
            for (u, column) in [(0.5 / 3.0, 0.0), (0.5, 1.0), (2.5 / 3.0, 2.0)] {
                assert!((at(&texture, u, v) - (first + column)).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn bilinear_lookup_wraps_around_at_the_edges() {
        let texture = numbers();
        // Half way between the last column and the first one.
        assert!((at(&texture, 0.0, 0.75) - 1.0).abs() < 1e-5);
        assert!((at(&texture, 1.0, 0.75) - 1.0).abs() < 1e-5);
        // Half way between the two rows.
        assert!((at(&texture, 0.5, 0.0) - 2.5).abs() < 1e-5);
        assert!((at(&texture, 0.5, 0.5) - 2.5).abs() < 1e-5);
        // A quarter of the way from column 1 to column 2.
        assert!((at(&texture, 1.75 / 3.0, 0.75) - 1.25).abs() < 1e-5);
    }

    #[test]
    fn gradient_is_the_slope_between_texels_and_continuous() {
        let texture = numbers();
        // Between the centres of columns 0 and 1, and of both rows.
        let between = texture.gradient(Vec2::new(1.0 / 3.0, 0.5));
        assert!(
            (between - Vec2::new(3.0, -6.0)).length() < 1e-4,
            "{between}"
        );
        // At the centre of the middle column, both sides rise alike; at its edge, the image falls back to its start.
        let middle = texture.gradient(Vec2::new(0.5, 0.5)).x;
        assert!((middle - 3.0).abs() < 1e-4, "{middle}");
        let edge = texture.gradient(Vec2::new(0.0, 0.5)).x;
        assert!((edge + 6.0).abs() < 1e-4, "{edge}");
        // From texel to texel it changes by 9 at most.
        for i in 0..300 {
            let at = |i: u16| texture.gradient(Vec2::new(f32::from(i) / 300.0, 0.5)).x;
            let step = at(i + 1) - at(i);
            assert!(step.abs() < 0.1, "{step} at {i}");
        }
        let one = Texture::Image {
            image: Arc::new(Image::filled(1, 1, Rgb::WHITE).into()),
            scale: 2.0,
        };
        assert_eq!(one.gradient(Vec2::new(0.3, 0.4)), Vec2::ZERO);
    }

    #[test]
    fn gradient_of_a_placed_texture_follows_its_uv_map() {
        let Texture::Image { image, .. } = numbers() else {
            unreachable!("it is an image");
        };
        let placed = |rows, wrap| Texture::Placed {
            image: Arc::clone(&image),
            tint: Rgb::grey(2.0),
            uv_map: UvMap { rows, wrap },
        };
        // u of the image is 2 v, v of the image is u.
        let rows = [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0]];
        let turned = placed(rows, [Wrap::Repeat; 2]);
        let gradient = turned.gradient(Vec2::new(0.5, 1.0 / 6.0));
        assert!(
            (gradient - Vec2::new(-12.0, 12.0)).length() < 1e-4,
            "{gradient}"
        );
        // A mirrored image rises backwards, and beyond the edge of a clamped one nothing changes.
        let rows = UvMap::default().rows;
        let mirrored = placed(rows, [Wrap::Mirror; 2]);
        let slope = mirrored.gradient(Vec2::new(2.0 - 0.5, 0.5)).x;
        assert!((slope + 6.0).abs() < 1e-4, "{slope}");
        let clamped = placed(rows, [Wrap::Clamp; 2]);
        assert_eq!(clamped.gradient(Vec2::new(7.0, 0.5)).x, 0.0);
    }

    #[test]
    fn image_texture_repeats_outside_the_unit_square() {
        let texture = numbers();
        for (u, v) in [(0.1, 0.2), (0.6, 0.9), (0.95, 0.4)] {
            for (du, dv) in [(1.0, 0.0), (-1.0, 3.0), (-7.0, -2.0)] {
                assert!((at(&texture, u + du, v + dv) - at(&texture, u, v)).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn placed_texture_applies_uv_map_wrap_and_tint() {
        let Texture::Image { image, .. } = numbers() else {
            unreachable!("it is an image");
        };
        let placed = Texture::Placed {
            image,
            tint: Rgb::new(0.5, 1.0, 2.0),
            uv_map: UvMap {
                rows: [[0.5, 0.0, 0.25], [0.0, -1.0, 1.0]],
                wrap: [Wrap::Clamp, Wrap::Mirror],
            },
        };
        let [r, g, b] = placed.lookup(Vec2::new(0.5, 0.25)).to_array();
        assert_eq!((r, g, b), (0.5, 1.0, 2.0));
        // Left of the image is its first column, above it the mirrored image.
        assert!((placed.lookup(Vec2::new(-9.0, -0.25)).to_array()[1] - 0.0).abs() < 1e-5);
        assert_eq!(placed.brightest(), Rgb::new(2.5, 5.0, 10.0));
    }

    #[test]
    fn checkerboard_starts_with_first_colour_and_floors_negative_uv() {
        let checker = Texture::Checker {
            colours: [Rgb::BLACK, Rgb::WHITE],
            repeat: Vec2::new(4.0, 2.0),
        };
        for (u, v, expected) in [
            (0.0, 0.0, 0.0),
            (0.1, 0.1, 0.0),
            (0.3, 0.1, 1.0),
            (0.3, 0.6, 0.0),
            (-0.1, 0.1, 1.0),
            (-0.1, -0.1, 0.0),
            (-0.3, 0.1, 0.0),
        ] {
            assert_eq!(at(&checker, u, v), expected, "({u}, {v})");
        }
    }

    #[test]
    fn constant_textures_are_detected_and_return_their_colour() {
        let colour = Rgb::new(0.1, 0.7, 0.3);
        let image = Texture::Image {
            image: Arc::new(Image::filled(5, 3, colour).into()),
            scale: 0.3,
        };
        let checker = Texture::Checker {
            colours: [colour; 2],
            repeat: Vec2::ONE,
        };
        for texture in [image, checker] {
            let constant = texture.constant().expect("one colour");
            for i in 0..100 {
                let t = i as f32 * 0.37 - 11.0;
                assert_eq!(texture.lookup(Vec2::new(t, 0.3 * t)), constant);
            }
        }
        assert_eq!(numbers().constant(), None);
    }

    fn finite() -> impl Strategy<Value = f32> {
        use prop::num::f32::{NORMAL, SUBNORMAL, ZERO};
        NORMAL | SUBNORMAL | ZERO
    }

    proptest! {
        #[test]
        fn finite_uv_lookup_stays_in_the_image_value_range(
            (u, v) in prop_oneof![
                (finite(), finite()),
                (-2.0_f32..2.0, -2.0_f32..2.0),
            ],
        ) {
            let value = at(&numbers(), u, v);
            prop_assert!((0.0..=5.0).contains(&value), "{value}");
        }

        #[test]
        fn lookup_does_not_panic_for_any_uv(u: f32, v: f32) {
            at(&numbers(), u, v);
            at(&Texture::Checker { colours: [Rgb::BLACK; 2], repeat: Vec2::splat(1e30) }, u, v);
        }
    }
}
