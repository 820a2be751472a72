//! The traits of a shape that decide how its hits are processed.
//!
//! Measure: none.
//! Range: any shape.
//! Source: none needed. Tested through `tests/rendering/effects.rs`.

/// A set of traits, as the bits of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ShapeTraits(pub u32);

impl ShapeTraits {
    /// The shape emits.
    pub const EMISSIVE: u32 = 1;
    /// The back of its surface absorbs everything.
    pub const ONE_SIDED: u32 = 1 << 1;
    /// A ray that leaves it in any direction cannot truly hit the same primitive again: top-level meshes and disks.
    pub const FLAT: u32 = 1 << 2;
    /// Its material transmits light, so that its two sides differ.
    pub const TRANSMISSIVE: u32 = 1 << 3;
    /// Its material or its emission needs texture coordinates.
    pub const TEXTURED: u32 = 1 << 4;
    /// Its material has an opacity below 1 anywhere.
    pub const ALPHA: u32 = 1 << 5;
    /// Its material tilts normals.
    pub const NORMAL_MAPPED: u32 = 1 << 6;

    /// Its material has a lobe that is narrower than a diffuse one.
    pub const GLOSSY: u32 = 1 << 7;

    /// Whether the shape has a trait.
    #[inline]
    pub fn has(self, one: u32) -> bool {
        self.0 & one != 0
    }

    /// The set with a trait, if a condition holds.
    pub fn with_if(self, one: u32, condition: bool) -> Self {
        Self(if condition { self.0 | one } else { self.0 })
    }
}
