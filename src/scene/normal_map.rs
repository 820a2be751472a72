//! Normal maps: shading detail that the mesh does not have.
//!
//! Measure: directions in world axes; the image stores x along u, y along v, z away from the surface, each mapped from
//! [-1, 1] to [0, 1], as in Blender and glTF.
//! Range: any map with texture coordinates.
//! Source: Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", for tangent space. Tested below and in
//! `tests/scattering/materials.rs`.

use super::description::NormalMapDescription;
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use std::sync::Arc;

/// A tangent-space normal map.
#[derive(Debug, Clone)]
pub struct NormalMap {
    texture: Arc<Texture>,
    strength: f32,
    is_right_handed: bool,
}

impl NormalMap {
    /// Returns the map of a description; `None` if it has no effect.
    pub fn new(description: &NormalMapDescription) -> Option<Self> {
        let NormalMapDescription {
            texture,
            strength,
            is_right_handed,
        } = description;
        let flat = texture
            .constant()
            .is_some_and(|colour| tangent_normal(colour.map(centred), *strength) == Vec3::Z);
        (!flat && *strength != 0.0).then(|| Self {
            texture: Arc::clone(texture),
            strength: *strength,
            is_right_handed: *is_right_handed,
        })
    }

    /// Returns the shading normal `ns` tilted by the map at `uv`. The tangents are the directions in which u and v grow.
    #[inline]
    pub fn tilt(&self, uv: Vec2, ns: Vec3, [along_u, along_v]: [Vec3; 2]) -> Vec3 {
        let Some(s) = (along_u - ns.dot(along_u) * ns).try_normalize() else {
            return ns;
        };
        let t = ns.cross(s);
        let is_mirrored = !self.is_right_handed && t.dot(along_v) < 0.0;
        let t = if is_mirrored { -t } else { t };
        let texel = self.texture.lookup_with(uv, |texel| texel.map(centred));
        let n = tangent_normal(texel, self.strength);
        (n.x * s + n.y * t + n.z * ns).normalize_or(ns)
    }
}

/// Returns the middle for the two codes of 8 bits beside it, and other values as they are: codes have no exact middle, and
/// both are written for 0.
#[inline]
fn centred(value: f32) -> f32 {
    const BESIDE: [f32; 2] = [(127.0_f64 / 255.0) as f32, (128.0_f64 / 255.0) as f32];
    if BESIDE.contains(&value) { 0.5 } else { value }
}

/// Decodes the normal of a texel.
fn tangent_normal(texel: Rgb, strength: f32) -> Vec3 {
    let [x, y, z] = texel.to_array().map(|c| 2.0 * c - 1.0);
    Vec3::new(strength * x, strength * y, z).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(texel: Rgb, strength: f32) -> NormalMapDescription {
        let colours = [texel, Rgb::new(0.5, 0.5, 1.0)];
        let repeat = Vec2::ONE;
        NormalMapDescription {
            texture: Arc::new(Texture::Checker { colours, repeat }),
            strength,
            is_right_handed: false,
        }
    }

    fn tilted(texel: Rgb, tangents: [Vec3; 2]) -> Vec3 {
        let map = NormalMap::new(&map(texel, 1.0)).expect("it tilts");
        map.tilt(Vec2::ZERO, Vec3::Z, tangents)
    }

    #[test]
    fn normal_map_axes_follow_tangents_also_when_mirrored() {
        let texel = Rgb::new(0.5 + 0.3, 0.5 + 0.1, 0.5 + 0.4);
        let expected = Vec3::new(0.6, 0.2, 0.8).normalize();
        let near = |got: Vec3, expected: Vec3| assert!((got - expected).length() < 1e-6, "{got}");
        near(tilted(texel, [Vec3::X, Vec3::Y]), expected);
        let mirrored = Vec3::new(-expected.x, expected.y, expected.z);
        near(tilted(texel, [-3.0 * Vec3::X, Vec3::Y]), mirrored);
        let turned = Vec3::new(-expected.y, expected.x, expected.z);
        near(tilted(texel, [Vec3::Y, -Vec3::X]), turned);
        let map = NormalMapDescription {
            is_right_handed: true,
            ..map(texel, 1.0)
        };
        let map = NormalMap::new(&map).expect("it tilts");
        let tilt = |tangents| map.tilt(Vec2::ZERO, Vec3::Z, tangents);
        near(tilt([Vec3::X, -Vec3::Y]), expected);
        near(
            tilt([-Vec3::X, Vec3::Y]),
            Vec3::new(-expected.x, -expected.y, expected.z),
        );
    }

    #[test]
    fn gentle_normal_map_tilts_without_steps() {
        // From the code of no tilt to the next, as an image of two texels.
        let texels = [128.0, 129.0].map(|code: f64| Rgb::new((code / 255.0) as f32, 0.5, 1.0));
        let image = Arc::new(crate::image::Image::new(2, 1, texels.to_vec()).into());
        let texture = Arc::new(Texture::Image { image, scale: 1.0 });
        let map = NormalMapDescription {
            texture,
            strength: 1.0,
            is_right_handed: false,
        };
        let map = NormalMap::new(&map).expect("it tilts");
        let tilt = |i: u16| {
            let u = 0.25 + 0.5 * f32::from(i) / 100.0;
            map.tilt(Vec2::new(u, 0.5), Vec3::Z, [Vec3::X, Vec3::Y]).x
        };
        assert_eq!(tilt(0), 0.0);
        let whole = tilt(100);
        for i in 0..100 {
            let step = tilt(i + 1) - tilt(i);
            assert!(
                (0.0..0.02 * whole).contains(&step),
                "{step} at {i} of {whole}"
            );
        }
    }

    #[test]
    fn flat_or_zero_strength_normal_map_is_omitted() {
        let flat = Rgb::new(128.0 / 255.0, 127.0 / 255.0, 1.0);
        let constant = Texture::Checker {
            colours: [flat; 2],
            repeat: Vec2::ONE,
        };
        let description = |texture, strength| NormalMapDescription {
            texture: Arc::new(texture),
            strength,
            is_right_handed: false,
        };
        assert!(NormalMap::new(&description(constant, 1.0)).is_none());
        assert!(NormalMap::new(&map(Rgb::new(1.0, 0.5, 0.5), 0.0)).is_none());
    }
}
