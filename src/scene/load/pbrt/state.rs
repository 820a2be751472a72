//! The graphics state that pbrt's statements change, and its stack.
//!
//! Measure: world units; angles in degrees.
//! Range: at most 1024 blocks within one another.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::gamut::Gamut;
use super::light::AreaLight;
use super::material::PbrtMaterial;
use super::parameter::Parameter;
use crate::math::transform;
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::Place;
use std::rc::Rc;

/// The depth of blocks beyond which a file is refused.
const MAX_BLOCKS: usize = 1024;

/// The targets of `Attribute`, in the order of [`GraphicsState::defaults`].
pub const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// The graphics state: settings by statements for those that follow.
#[derive(Debug, Clone)]
pub struct GraphicsState {
    /// The transforms from an object's space to the world's, at the start and at the end.
    pub transforms: [DAffine3; 2],
    /// The transforms of the two that transform statements change.
    pub active: [bool; 2],
    pub reverse: bool,
    pub material: Option<PbrtMaterial>,
    pub area_light: Option<Rc<AreaLight>>,
    pub gamut: Gamut,
    /// Default parameters for each target of `Attribute`.
    pub defaults: [Rc<Vec<Rc<Parameter>>>; 5],
}

impl Default for GraphicsState {
    fn default() -> Self {
        Self {
            transforms: [DAffine3::IDENTITY; 2],
            active: [true; 2],
            reverse: false,
            material: None,
            area_light: None,
            gamut: Gamut::default(),
            defaults: Default::default(),
        }
    }
}

impl GraphicsState {
    /// Changes the active transforms.
    pub fn change(&mut self, f: impl Fn(DAffine3) -> DAffine3) {
        for (transform, active) in self.transforms.iter_mut().zip(self.active) {
            if active {
                *transform = f(*transform);
            }
        }
    }

    /// The default parameters for statements of this kind.
    pub fn defaults_for(&self, target: &str) -> Vec<Rc<Parameter>> {
        let index = TARGETS.iter().position(|known| *known == target);
        index.map_or(vec![], |index| self.defaults[index].to_vec())
    }

    /// Whether the object moves.
    pub fn is_animated(&self) -> bool {
        self.transforms[0] != self.transforms[1]
    }
}

/// The statement that begins a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockStatement {
    Attribute,
    Object,
}

/// The states to return to, innermost last.
#[derive(Debug, Default)]
pub struct StateStack(Vec<(BlockStatement, GraphicsState, Place)>);

impl StateStack {
    /// Begins a block.
    ///
    /// # Errors
    /// If there are too many within one another.
    pub fn push(
        &mut self,
        block: BlockStatement,
        state: &GraphicsState,
        place: &Place,
    ) -> Result<(), String> {
        if self.0.len() >= MAX_BLOCKS {
            return Err(format!(
                "expected at most {MAX_BLOCKS} blocks within one another"
            ));
        }
        self.0.push((block, state.clone(), place.clone()));
        Ok(())
    }

    /// Ends a block and returns the state before it.
    ///
    /// # Errors
    /// If the innermost block is of another kind, or there is none.
    pub fn pop(&mut self, block: BlockStatement) -> Result<GraphicsState, String> {
        match (self.0.pop(), block) {
            (Some((begun, state, _)), _) if begun == block => Ok(state),
            (Some(_), BlockStatement::Attribute) => {
                Err("expected ObjectEnd before AttributeEnd".to_owned())
            }
            (Some(_), BlockStatement::Object) => {
                Err("expected AttributeEnd before ObjectEnd".to_owned())
            }
            (None, BlockStatement::Attribute) => {
                Err("AttributeEnd without AttributeBegin".to_owned())
            }
            (None, BlockStatement::Object) => Err("ObjectEnd without ObjectBegin".to_owned()),
        }
    }

    /// The number of open blocks.
    pub fn depth(&self) -> usize {
        self.0.len()
    }

    /// The innermost open block and where it begins.
    pub fn innermost(&self) -> Option<(BlockStatement, &Place)> {
        self.0.last().map(|(block, _, place)| (*block, place))
    }
}

/// A rotation by an angle in degrees about an axis; `None` if that has no direction.
pub fn rotation(angle: f64, axis: DVec3) -> Option<DAffine3> {
    let axis = axis.try_normalize()?;
    Some(DAffine3::from_mat3(transform::rotation(
        axis,
        angle.to_radians(),
    )))
}

/// The transform from the world to a camera at `eye` that looks along +z at `target`, with x to the right in pbrt's
/// left-handed space; `None` if that has no direction.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let forward = (target - eye).try_normalize()?;
    let across = up.try_normalize()?.cross(forward);
    let right = (across.length() > 1e-9).then(|| across.normalize())?;
    let placed = DAffine3 {
        matrix3: DMat3::from_cols(right, forward.cross(right), forward),
        translation: eye,
    };
    Some(placed.inverse())
}
