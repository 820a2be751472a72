//! The place of an image on a surface: an affine map of texture coordinates, and the continuation beyond the image.
//!
//! Measure: uv of the surface to uv of the image, [0, 1] over the image, v up.
//! Range: any finite map. Mirrored and clamped coordinates stay between the centres of the outermost texels, where a
//! lookup that repeats the image gives the same colours.
//! Source: glTF 2.0, samplers, and KHR_texture_transform. Tested below and in `tests/loading/gltf.rs`.

use crate::math::vec::Vec2;
use crate::planted::planted;
use serde::Serialize;

/// The continuation of an image beyond its edges, along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, every second one mirrored.
    Mirror,
    /// The texels of the edge continue.
    Clamp,
}

impl Wrap {
    /// All continuations with their names in scene files.
    pub const ALL: &[(&str, Self)] = &[
        ("repeat", Self::Repeat),
        ("mirror", Self::Mirror),
        ("clamp", Self::Clamp),
    ];

    /// The place in a row of `count` texels that repeats, for a coordinate `t` of a row that continues in this way.
    #[inline]
    fn fold(self, t: f32, count: u32) -> f32 {
        let folded = match self {
            Self::Repeat => return t,
            Self::Mirror => {
                let t = t - 2.0 * (0.5 * t).floor();
                planted!("unmirrored-wrap", t, if t > 1.0 { 2.0 - t } else { t })
            }
            Self::Clamp => t,
        };
        let centre = 0.5 / count as f32;
        folded.clamp(centre, 1.0 - centre)
    }
}

/// An affine map from the uv of a surface to the uv of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UvMap {
    /// The map as a matrix of 2 x 3, row by row: u of the image is `rows[0]` times (u, v, 1).
    pub rows: [[f32; 3]; 2],
    /// The continuation along u and along v.
    pub wrap: [Wrap; 2],
}

impl Default for UvMap {
    fn default() -> Self {
        Self {
            rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            wrap: [Wrap::Repeat; 2],
        }
    }
}

impl UvMap {
    /// The uv at which to look up an image of this width and height, as if it repeated.
    #[inline]
    pub fn apply(&self, size: (u32, u32), uv: Vec2) -> Vec2 {
        self.wrapped(size, self.mapped(uv))
    }

    /// The uv of the image, which may be beyond its edges.
    #[inline]
    pub(super) fn mapped(&self, uv: Vec2) -> Vec2 {
        let rows = self.rows;
        rows.map(|[along_u, along_v, offset]| along_u * uv.x + along_v * uv.y + offset)
            .into()
    }

    /// The uv at which to look up an image of this width and height as if it repeated, for a uv of the image.
    #[inline]
    pub(super) fn wrapped(&self, (width, height): (u32, u32), uv: Vec2) -> Vec2 {
        Vec2::new(
            self.wrap[0].fold(uv.x, width),
            self.wrap[1].fold(uv.y, height),
        )
    }

    /// The derivatives by the uv of the surface, from those by the uv of the image.
    #[inline]
    pub(super) fn pull_back(&self, gradient: Vec2) -> Vec2 {
        let [u, v] = self.rows;
        Vec2::new(
            u[0] * gradient.x + v[0] * gradient.y,
            u[1] * gradient.x + v[1] * gradient.y,
        )
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.rows.as_flattened().iter().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folded(wrap: Wrap, t: f32) -> f32 {
        wrap.fold(t, 10)
    }

    #[test]
    fn wrap_modes_mirror_and_clamp_between_texel_centres() {
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5, "{a} {b}");
        near(folded(Wrap::Repeat, -7.25), -7.25);
        for (t, mirrored, clamped) in [
            (0.25, 0.25, 0.25),
            (1.25, 0.75, 0.95),
            (2.25, 0.25, 0.95),
            (-0.25, 0.25, 0.05),
            (-1.25, 0.75, 0.05),
            (0.01, 0.05, 0.05),
            (0.99, 0.95, 0.95),
        ] {
            near(folded(Wrap::Mirror, t), mirrored);
            near(folded(Wrap::Clamp, t), clamped);
        }
    }

    #[test]
    fn uv_map_applies_its_affine_transform() {
        let map = UvMap {
            rows: [[0.0, -2.0, 0.5], [3.0, 0.0, 0.25]],
            ..UvMap::default()
        };
        let uv = map.apply((4, 4), Vec2::new(0.1, 0.2));
        assert!((uv - Vec2::new(0.1, 0.55)).length() < 1e-6, "{uv}");
    }

    #[test]
    fn wrapping_does_not_panic_for_extreme_coordinates() {
        for t in [f32::NAN, f32::INFINITY, -f32::MAX, f32::MAX] {
            for &(_, wrap) in Wrap::ALL {
                folded(wrap, t);
                wrap.fold(t, 1);
            }
        }
    }
}
