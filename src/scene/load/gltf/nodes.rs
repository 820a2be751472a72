//! The node hierarchy of glTF, flattened: what is placed, and where in the world.
//!
//! Measure: the file's units, in double precision.
//! Range: a forest, as the format requires: a node that is reached twice is an error. Animations are ignored.
//! Source: glTF 2.0, chapter 3.5. Tested in `tests/loading/gltf.rs`.

use super::super::wording::shown;
use super::buffers::Asset;
use crate::error::Result;
use crate::math::vec::{DAffine3, DMat4, DQuat, DVec3};
use gltf::scene::Transform;
use gltf::{Node, Scene};

/// A node with its transform to the world.
#[derive(Clone)]
pub struct PlacedNode<'a> {
    pub node: Node<'a>,
    pub to_world: DAffine3,
}

impl PlacedNode<'_> {
    /// The name of the node.
    pub fn name(&self) -> String {
        let unnamed = || format!("node {}", self.node.index());
        self.node
            .name()
            .filter(|name| !name.is_empty())
            .map_or_else(unnamed, shown)
    }
}

/// Returns all nodes of the default scene in the order of the hierarchy, or those of the first scene if none is the
/// default, or all if there is no scene.
///
/// # Errors
/// If a node is reached twice, or its transform is not one of finite numbers.
pub fn nodes<'a>(asset: &'a Asset<'_>) -> Result<Vec<PlacedNode<'a>>> {
    let document = &asset.document;
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let roots = match &scene {
        Some(scene) => of_scene(scene),
        None => without_parent(asset),
    };
    let mut is_reached = vec![false; document.nodes().len()];
    let mut placed = vec![];
    // An explicit stack, since a chain of nodes may be as long as the file.
    let mut ahead: Vec<PlacedNode<'a>> = roots
        .into_iter()
        .rev()
        .map(|node| PlacedNode {
            node,
            to_world: DAffine3::IDENTITY,
        })
        .collect();
    while let Some(next) = ahead.pop() {
        let index = next.node.index();
        if std::mem::replace(&mut is_reached[index], true) {
            return Err(asset.error(
                format!("nodes[{index}]"),
                "expected a tree of nodes, but this one is reached twice: it has two parents, or is in a cycle",
            ));
        }
        let to_world = next.to_world * transform(asset, &next.node)?;
        let children = ahead.len();
        let beneath = next.node.children();
        ahead.extend(beneath.map(|node| PlacedNode { node, to_world }));
        ahead[children..].reverse();
        placed.push(PlacedNode {
            node: next.node,
            to_world,
        });
    }
    Ok(placed)
}

fn of_scene<'a>(scene: &Scene<'a>) -> Vec<Node<'a>> {
    scene.nodes().collect()
}

/// The nodes that are no children.
fn without_parent<'a>(asset: &'a Asset<'_>) -> Vec<Node<'a>> {
    let mut is_child = vec![false; asset.document.nodes().len()];
    for node in asset.document.nodes() {
        for child in node.children() {
            is_child[child.index()] = true;
        }
    }
    let nodes = asset.document.nodes();
    nodes.filter(|node| !is_child[node.index()]).collect()
}

/// The transform of a node to its parent.
fn transform(asset: &Asset<'_>, node: &Node<'_>) -> Result<DAffine3> {
    let wrong = |message: &str| asset.error(format!("nodes[{}]", node.index()), message);
    let transform = match node.transform() {
        Transform::Matrix { matrix } => {
            let columns = matrix.map(|column| column.map(f64::from));
            let matrix = DMat4::from_cols_array_2d(&columns);
            if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
                return Err(wrong("expected a matrix whose last row is 0, 0, 0, 1"));
            }
            DAffine3::from_mat4(matrix)
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            // A unit quaternion, up to the rounding of the file.
            let length = rotation.length();
            let rotation = if length > 0.0 && length.is_finite() {
                rotation / length
            } else {
                return Err(wrong("expected a rotation of unit length"));
            };
            let [scale, translation] =
                [scale, translation].map(|it| DVec3::from_array(it.map(f64::from)));
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    if transform.is_finite() {
        Ok(transform)
    } else {
        Err(wrong("expected a transform of finite numbers"))
    }
}
