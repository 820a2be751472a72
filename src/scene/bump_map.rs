//! Bump maps: the shading normals of a surface that an image raises by its heights.
//!
//! Measure: heights in normalised units, along the shading normal.
//! Range: heights that are small beside the size of the surface, whose own curvature is that of the surface without them.
//! Source: Blinn 1978, "Simulation of Wrinkled Surfaces"; Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the
//! GPU", for the surface gradient. Tested below and in `tests/scattering/materials.rs`.

use super::description::BumpMapDescription;
use crate::geometry::texture::Texture;
use crate::math::vec::{Vec2, Vec3};
use std::sync::Arc;

/// A map of heights.
#[derive(Debug, Clone)]
pub struct BumpMap {
    texture: Arc<Texture>,
    /// The height of a value of 1.
    height: f32,
}

impl BumpMap {
    /// Returns the map of a description, whose lengths are multiplied by `unit`; `None` if it has no effect.
    pub fn new(description: &BumpMapDescription, unit: f32) -> Option<Self> {
        let BumpMapDescription { texture, height } = description;
        let varies = matches!(**texture, Texture::Image { .. } | Texture::Placed { .. });
        let is_flat = !varies || texture.constant().is_some() || *height == 0.0;
        (!is_flat).then(|| Self {
            texture: Arc::clone(texture),
            height: unit * height,
        })
    }

    /// Returns the shading normal `ns` of the raised surface at `uv`. The tangents are the derivatives of a point of the
    /// surface by u and v.
    #[inline]
    pub fn tilt(&self, uv: Vec2, ns: Vec3, [along_u, along_v]: [Vec3; 2]) -> Vec3 {
        let by_u = along_v.cross(ns);
        let by_v = ns.cross(along_u);
        let determinant = along_u.dot(by_u);
        let slope = self.height * self.texture.gradient(uv);
        // Equation 4 of Mikkelsen times the determinant, which is 0 without texture coordinates.
        let gradient = slope.x * by_u + slope.y * by_v;
        (determinant.abs() * ns - determinant.signum() * gradient).normalize_or(ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::math::rgb::Rgb;

    /// Heights that rise along u from 0 to 1 over two texels.
    fn ramp() -> Arc<Texture> {
        let heights = [0.0, 0.0, 0.5, 1.0, 1.0, 1.0].map(Rgb::grey);
        let image = Arc::new(Image::new(6, 1, heights.to_vec()).into());
        Arc::new(Texture::Image { image, scale: 1.0 })
    }

    fn tilted(height: f32, unit: f32, ns: Vec3, tangents: [Vec3; 2]) -> Vec3 {
        let texture = ramp();
        let map = BumpMap::new(&BumpMapDescription { texture, height }, unit).expect("it tilts");
        // Between two texels that differ by 0.5, a sixth of the image apart.
        map.tilt(Vec2::new(2.0 / 6.0, 0.5), ns, tangents)
    }

    fn near(got: Vec3, expected: Vec3) {
        assert!((got - expected.normalize()).length() < 1e-6, "{got}");
    }

    #[test]
    fn bump_normals_follow_slope_in_scene_lengths() {
        // A rise of 3 times the height over u, which is 2 long.
        let tangents = [2.0 * Vec3::X, Vec3::Y];
        near(
            tilted(0.2, 1.0, Vec3::Z, tangents),
            Vec3::new(-0.3, 0.0, 1.0),
        );
        near(
            tilted(-0.2, 1.0, Vec3::Z, tangents),
            Vec3::new(0.3, 0.0, 1.0),
        );
        // Ten times as large a unit, of tangents and heights alike.
        let large = tangents.map(|tangent| 10.0 * tangent);
        near(tilted(0.2, 10.0, Vec3::Z, large), Vec3::new(-0.3, 0.0, 1.0));
        // Mirrored coordinates, and those of which v is not orthogonal to u.
        let mirrored = [-2.0 * Vec3::X, Vec3::Y];
        near(
            tilted(0.2, 1.0, Vec3::Z, mirrored),
            Vec3::new(0.3, 0.0, 1.0),
        );
        // u is constant along X - Y, so that heights rise along X + Y, by 0.6 over the length sqrt(2).
        let skewed = [2.0 * Vec3::X, Vec3::X - Vec3::Y];
        near(
            tilted(0.2, 1.0, Vec3::Z, skewed),
            Vec3::new(-0.3, -0.3, 1.0),
        );
    }

    #[test]
    fn bump_map_without_texture_coordinates_keeps_the_normal() {
        let ns = Vec3::new(0.0, 0.6, 0.8);
        assert_eq!(tilted(0.2, 1.0, ns, [Vec3::ZERO; 2]), ns);
    }

    #[test]
    fn flat_bump_maps_are_omitted() {
        let checker = Texture::Checker {
            colours: [Rgb::BLACK, Rgb::WHITE],
            repeat: Vec2::ONE,
        };
        let constant = Texture::Image {
            image: Arc::new(Image::filled(4, 4, Rgb::grey(0.3)).into()),
            scale: 1.0,
        };
        let map = |texture: Arc<Texture>, height| {
            BumpMap::new(&BumpMapDescription { texture, height }, 1.0)
        };
        assert!(map(Arc::new(checker), 1.0).is_none());
        assert!(map(Arc::new(constant), 1.0).is_none());
        assert!(map(ramp(), 0.0).is_none());
    }
}
