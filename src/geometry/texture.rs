//! A colour that varies over a surface.
//!
//! Measure: linear Rec. 709; uv in [0, 1] over the picture, v up.
//! Range: any finite uv: the picture repeats.
//! Source: bilinear interpolation between texel centres. Tested below.

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// A texture.
#[derive(Debug, Clone)]
pub enum Texture {
    /// A picture.
    Image {
        /// Linear values; shared by all textures of one file.
        image: Arc<Image>,
        /// Multiplies every value.
        scale: f32,
    },
    /// Two colours in turn.
    Checker {
        /// The colours; the first one is at uv = (0, 0).
        colours: [Rgb; 2],
        /// Fields over [0, 1] in u and in v.
        repeat: Vec2,
    },
}

impl Texture {
    /// The colour at a texture coordinate.
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Image { image, scale } => *scale * bilinear(image, uv),
            Self::Checker { colours, repeat } => {
                let field = (uv * *repeat).floor();
                let odd = (field.x + field.y).rem_euclid(2.0) >= 1.0;
                colours[usize::from(odd)]
            }
        }
    }

    /// The one colour that the texture has everywhere, if that is so.
    pub fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Image { image, scale } => {
                let first = *image.pixels().first()?;
                let same = image.pixels().iter().all(|pixel| *pixel == first);
                same.then_some(*scale * first)
            }
            Self::Checker { colours, .. } => (colours[0] == colours[1]).then_some(colours[0]),
        }
    }
}

/// Interpolates between the four nearest texel centres.
#[inline]
fn bilinear(image: &Image, uv: Vec2) -> Rgb {
    // A texel's centre is half a texel from its corner; rows go down while v goes up.
    let (x0, x1, fx) = neighbours(uv.x, image.width());
    let (y0, y1, fy) = neighbours(1.0 - uv.y, image.height());
    let top = image.get(x0, y0).lerp(image.get(x1, y0), fx);
    let bottom = image.get(x0, y1).lerp(image.get(x1, y1), fx);
    top.lerp(bottom, fy)
}

/// The two texels on either side of a coordinate in [0, 1], repeated, and how far it is from the first to the second.
#[inline]
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let position = coordinate.rem_euclid(1.0) * size as f32 - 0.5;
    let first = position.floor();
    let index = (first + size as f32) as u32 % size;
    (index, (index + 1) % size, position - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Texture {
        let pixels = (0..4).map(|i| Rgb::grey(i as f32)).collect();
        Texture::Image {
            image: Arc::new(Image::new(2, 2, pixels)),
            scale: 2.0,
        }
    }

    fn at(texture: &Texture, u: f32, v: f32) -> f32 {
        texture.lookup(Vec2::new(u, v)).to_array()[0]
    }

    #[test]
    fn texel_centres_show_their_texels_the_right_way_up() {
        let texture = gradient();
        // Row 0 is on top, where v is large.
        assert_eq!(at(&texture, 0.25, 0.75), 0.0);
        assert_eq!(at(&texture, 0.75, 0.75), 2.0);
        assert_eq!(at(&texture, 0.25, 0.25), 4.0);
        assert_eq!(at(&texture, 0.75, 0.25), 6.0);
        assert_eq!(at(&texture, 0.5, 0.5), 3.0);
    }

    #[test]
    fn the_picture_repeats_for_any_finite_coordinate() {
        let texture = gradient();
        assert_eq!(at(&texture, 0.25, 0.75), at(&texture, -6.75, 9.75));
        for coordinate in [-1e30, -1e-30, 1e9, 1e30, f32::MAX] {
            assert!(at(&texture, coordinate, -coordinate).is_finite());
        }
    }

    #[test]
    fn checkers_alternate_also_below_zero() {
        let colours = [Rgb::WHITE, Rgb::BLACK];
        let texture = Texture::Checker {
            colours,
            repeat: Vec2::new(2.0, 2.0),
        };
        assert_eq!(at(&texture, 0.1, 0.1), 1.0);
        assert_eq!(at(&texture, 0.6, 0.1), 0.0);
        assert_eq!(at(&texture, 0.6, 0.6), 1.0);
        assert_eq!(at(&texture, -0.1, 0.1), 0.0);
    }

    #[test]
    fn one_colour_everywhere_is_a_constant() {
        assert_eq!(gradient().constant(), None);
        let image = Arc::new(Image::new(2, 1, vec![Rgb::grey(0.5); 2]));
        assert_eq!(
            Texture::Image { image, scale: 2.0 }.constant(),
            Some(Rgb::WHITE)
        );
    }
}
