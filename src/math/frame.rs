//! An orthonormal frame around a normal, and transforms to and from it.
//!
//! Measure: unit vectors; local z is the normal.
//! Range: any unit normal, also (0, 0, -1).
//! Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited" (JCGT 6-1), listing 3. Tested below.

use super::vec::{Vec3, Vector};

/// A right-handed orthonormal frame (s, t, n).
#[derive(Debug, Clone, Copy)]
pub struct Frame<V = Vec3> {
    /// First tangent: local x.
    pub s: V,
    /// Second tangent: local y.
    pub t: V,
    /// Normal: local z.
    pub n: V,
}

impl<V: Vector> Frame<V> {
    /// The frame whose z axis is the unit vector `n`.
    #[inline(always)]
    pub fn from_normal(n: V) -> Self {
        let [x, y, z] = n.into();
        let sign = 1.0_f32.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        Self {
            s: V::new(1.0 + sign * x * x * a, sign * b, -sign * x),
            t: V::new(b, sign + y * y * a, -y),
            n,
        }
    }

    /// Transforms a vector from world to local coordinates.
    #[inline(always)]
    pub fn to_local(&self, v: V) -> V {
        V::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Transforms a vector from local to world coordinates.
    #[inline(always)]
    pub fn to_world(&self, v: V) -> V {
        self.s * v.x() + self.t * v.y() + self.n * v.z()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed_also_at_the_poles() {
        let mut normals = vec![Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(1e-20, 0.0, -1.0)];
        for i in 0..100 {
            let (a, b) = (i as f32 * 0.7, i as f32 * 1.3);
            normals.push(Vec3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos()).normalize());
        }
        for n in normals {
            let frame = Frame::from_normal(n);
            assert!((frame.s.cross(frame.t) - frame.n).length() < 2e-6, "{n}");
            assert!(frame.s.dot(frame.t).abs() < 1e-6, "{n}");
            let v = Vec3::new(0.3, -0.5, 0.8);
            assert!((frame.to_world(frame.to_local(v)) - v).length() < 2e-6);
        }
    }
}
