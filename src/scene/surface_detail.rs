//! Shading detail that the geometry does not have, by a normal map or a bump map.
//!
//! Measure: directions in world axes.
//! Range: a normal that would point below the surface is left unchanged.
//! Source: `normal_map.rs`, `bump_map.rs`. Tested below and in `tests/scattering/materials.rs`.

use super::bump_map::BumpMap;
use super::description::MaterialDescription;
use super::normal_map::NormalMap;
use crate::math::vec::{Vec2, Vec3};

/// A map that tilts shading normals.
#[derive(Debug, Clone)]
pub enum SurfaceDetail {
    /// A map of normals.
    Normals(NormalMap),
    /// A map of heights.
    Heights(BumpMap),
}

impl SurfaceDetail {
    /// Returns the map of a material, whose lengths are multiplied by `unit`; `None` if it has none that has an effect.
    pub fn new(material: &MaterialDescription, unit: f32) -> Option<Self> {
        let normals = material.normal_map.as_ref().and_then(NormalMap::new);
        let heights = || BumpMap::new(material.bump_map.as_ref()?, unit);
        normals
            .map(Self::Normals)
            .or_else(|| heights().map(Self::Heights))
    }

    /// Returns the shading normal `ns` tilted by the map at `uv`. The tangents are the derivatives of a point of the
    /// surface by u and v; `ns` is on the side of the geometric normal `ng`, and so is the result.
    #[inline]
    pub fn tilt(&self, uv: Vec2, ns: Vec3, ng: Vec3, tangents: [Vec3; 2]) -> Vec3 {
        let tilted = match self {
            Self::Normals(map) => map.tilt(uv, ns, tangents),
            Self::Heights(map) => map.tilt(uv, ns, tangents),
        };
        if tilted.dot(ng) > 0.0 { tilted } else { ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::texture::Texture;
    use crate::math::rgb::Rgb;
    use crate::scene::description::{MaterialModel, NormalMapDescription, Place};
    use std::sync::Arc;

    #[test]
    fn tilted_normal_below_the_surface_is_ignored() {
        let colours = [Rgb::new(0.9, 0.5, 0.2), Rgb::new(0.5, 0.5, 1.0)];
        let repeat = Vec2::ONE;
        let model = MaterialModel::Diffuse {
            reflectance: Rgb::WHITE.into(),
        };
        let material = MaterialDescription {
            normal_map: Some(NormalMapDescription {
                texture: Arc::new(Texture::Checker { colours, repeat }),
                strength: 1.0,
                is_right_handed: false,
            }),
            ..MaterialDescription::new("steep", Place::default(), model)
        };
        let detail = SurfaceDetail::new(&material, 1.0).expect("it tilts");
        let tangents = [Vec3::X, Vec3::Y];
        let tilted = detail.tilt(Vec2::ZERO, Vec3::Z, Vec3::Z, tangents);
        assert_eq!(tilted, Vec3::Z);
    }
}
