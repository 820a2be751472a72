//! Closed meshes, and segments that lead out of them: what such a segment fails to meet is a leak.
//!
//! Measure: normalised scene units.
//! Range: at least four squares an edge for the bumpy sphere, which has to hold where segments begin.
//! Source: none needed. Tested in `lab/tests/bench/scenes.rs`.

use super::random::Random;
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::mesh::Mesh;
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DVec3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Segments begin in a cube from minus this to this.
const START: f64 = 0.25;

/// How thick the walls of a room are, of half its width.
const WALL: f64 = 1.0 / 1024.0;

/// Where a segment is aimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// In a random direction.
    Anywhere,
    /// At a random point of an edge.
    Edge,
    /// At a vertex.
    Vertex,
}

impl Aim {
    /// Every aim.
    pub const ALL: &'static [Self] = &[Self::Anywhere, Self::Edge, Self::Vertex];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Anywhere => "anywhere",
            Self::Edge => "edge",
            Self::Vertex => "vertex",
        }
    }
}

/// What is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A sphere with hills and valleys; segments end far outside.
    BumpySphere,
    /// A room between thin walls; segments end within a wall.
    Room,
}

/// A closed mesh, and where it is.
#[derive(Debug)]
pub struct ClosedMesh {
    form: Form,
    size: f64,
    offset: f64,
    world: Arc<World>,
    /// The triangles to aim at, which are the first of the mesh.
    facing: usize,
}

impl ClosedMesh {
    /// Every form with `n` squares along each edge of the cube that it is made from: at the origin, a thousand times as
    /// small, and moved away by a hundred times its size.
    pub fn all(n: u32) -> Vec<Self> {
        let places = [(1.0, 0.0), (1e-3, 0.0), (1.0, 100.0)];
        let form = |form| places.map(|(size, offset)| Self::new(form, n, size, offset));
        [Form::BumpySphere, Form::Room]
            .into_iter()
            .flat_map(form)
            .collect()
    }

    /// A form of about this size, moved by the offset along each axis.
    pub fn new(form: Form, n: u32, size: f64, offset: f64) -> Self {
        let placed = |p: Vec3, grown: f64| (offset + size * grown * p.as_dvec3()).as_vec3a();
        let (mut positions, mut indices) = match form {
            Form::BumpySphere => cube_surface(n, |p| {
                let p = p.normalize();
                let [x, y, z] = p.as_dvec3().to_array();
                let bump = (7.0 * x).sin() * (5.0 * y + 1.0).sin() * (6.0 * z + 2.0).sin();
                placed(p, 1.0 + 0.2 * bump)
            }),
            Form::Room => cube_surface(n, |p| placed(p, 1.0)),
        };
        let facing = indices.len();
        if form == Form::Room {
            let (outside, triangles) = cube_surface(n, |p| placed(p, 1.0 + WALL));
            let first = positions.len() as u32;
            positions.extend(outside);
            indices.extend(triangles.into_iter().map(|t| t.map(|i| first + i)));
        }
        let mesh = Mesh::new(positions, vec![], vec![], indices);
        Self {
            form,
            size,
            offset,
            world: Arc::new(World::new(vec![Geometry::Mesh(mesh)], vec![], vec![])),
            facing,
        }
    }

    /// What it is, in words.
    pub fn name(&self) -> String {
        let form = match self.form {
            Form::BumpySphere => "bumpy sphere",
            Form::Room => "room between thin walls",
        };
        format!("{form}, size {}, moved by {}", self.size, self.offset)
    }

    /// The mesh in a world of its own.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// A segment from within that ends outside, or within the wall.
    pub fn segment(&self, aim: Aim, random: &mut Random) -> Ray {
        let from = (self.offset + self.size * START * random.in_cube()).as_vec3a();
        let dir = match aim {
            Aim::Anywhere => self.size as f32 * random.direction(),
            Aim::Edge | Aim::Vertex => self.seam(aim, random) - from,
        };
        let begin = (from.as_dvec3() - self.offset) / self.size;
        let end = self.end(begin, dir.as_dvec3() / self.size);
        Ray {
            t_max: end as f32,
            ..Ray::new(from, dir)
        }
    }

    fn seam(&self, aim: Aim, random: &mut Random) -> Vec3 {
        let [Geometry::Mesh(mesh)] = self.world.geometries() else {
            return Vec3::ZERO;
        };
        let triangle = mesh.triangle(random.below(self.facing) as u32);
        let corner = random.below(3);
        let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
        match aim {
            Aim::Vertex => a,
            _ => a + random.uniform() * (b - a),
        }
    }

    /// Where a segment of the form at size 1 about the origin ends: surely outside, or half a wall behind the inner face.
    fn end(&self, from: DVec3, dir: DVec3) -> f64 {
        match self.form {
            Form::BumpySphere => 4.0 / dir.length(),
            Form::Room => {
                let exits = (dir.signum() - from) / dir;
                exits.min_element() + 0.5 * WALL / dir.abs().max_element()
            }
        }
    }
}

/// The surface of the cube from -1 to 1 in `n` x `n` squares a face, each of two triangles, with its vertices put where
/// `place` says: positions and indices. Neighbouring triangles share their vertices.
pub fn cube_surface(n: u32, place: impl Fn(Vec3) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions: Vec<Vec3> = Vec::new();
    let mut indices = Vec::new();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let mut vertex = |steps: [u32; 3]| {
        *known.entry(steps).or_insert_with(|| {
            let p = steps.map(|step| 2.0 * step as f32 / n as f32 - 1.0);
            positions.push(place(Vec3::from_array(p)));
            positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            let mut at = |i: u32, j: u32| {
                let mut steps = [side; 3];
                steps[(axis + 1) % 3] = i;
                steps[(axis + 2) % 3] = j;
                vertex(steps)
            };
            for i in 0..n {
                for j in 0..n {
                    let square = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    indices.push([square[0], square[1], square[2]]);
                    indices.push([square[0], square[2], square[3]]);
                }
            }
        }
    }
    (positions, indices)
}
