//! Closed meshes, and segments that lead out of them: a segment that misses the mesh is a leak.
//!
//! Measure: normalised scene units.
//! Range: at least four squares per edge for the bumpy sphere, which must enclose the origins of the segments.
//! Source: none needed. Tested in `lab/tests/bench/scenes.rs`.

use super::random::Random;
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::mesh::Mesh;
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DVec3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Half the edge of the cube, centred at the origin, in which segments begin.
const START: f64 = 0.25;

/// Thickness of the walls of a room, relative to half its width.
const WALL: f64 = 1.0 / 1024.0;

/// The target at which a segment is aimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// A random direction.
    Anywhere,
    /// A random point of an edge.
    Edge,
    /// A vertex.
    Vertex,
}

impl Aim {
    /// Every aim.
    pub const ALL: &'static [Self] = &[Self::Anywhere, Self::Edge, Self::Vertex];

    /// The name of the aim in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Anywhere => "anywhere",
            Self::Edge => "edge",
            Self::Vertex => "vertex",
        }
    }
}

/// The form of a closed mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClosedForm {
    /// A sphere with bumps; segments end far outside.
    BumpySphere,
    /// A room with thin walls; segments end within a wall.
    Room,
}

/// A closed mesh with its form, size and position.
#[derive(Debug)]
pub struct ClosedMesh {
    form: ClosedForm,
    size: f64,
    offset: f64,
    world: Arc<World>,
    /// The number of triangles to aim at; they are the first of the mesh.
    target_count: usize,
}

impl ClosedMesh {
    /// Every form with `n` squares along each edge of the cube from which it is made: at the origin, scaled by 1/1000,
    /// and translated by a hundred times its size.
    pub fn all(n: u32) -> Vec<Self> {
        let places = [(1.0, 0.0), (1e-3, 0.0), (1.0, 100.0)];
        let form = |form| places.map(|(size, offset)| Self::new(form, n, size, offset));
        [ClosedForm::BumpySphere, ClosedForm::Room]
            .into_iter()
            .flat_map(form)
            .collect()
    }

    /// A form of about the given size, translated by `offset` along each axis.
    pub fn new(form: ClosedForm, n: u32, size: f64, offset: f64) -> Self {
        let placed = |p: Vec3, grown: f64| (offset + size * grown * p.as_dvec3()).as_vec3a();
        let (mut positions, mut indices) = match form {
            ClosedForm::BumpySphere => cube_surface(n, |p| {
                let p = p.normalize();
                let [x, y, z] = p.as_dvec3().to_array();
                let bump = (7.0 * x).sin() * (5.0 * y + 1.0).sin() * (6.0 * z + 2.0).sin();
                placed(p, 1.0 + 0.2 * bump)
            }),
            ClosedForm::Room => cube_surface(n, |p| placed(p, 1.0)),
        };
        let target_count = indices.len();
        if form == ClosedForm::Room {
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
            target_count,
        }
    }

    /// Describes the mesh in words.
    pub fn name(&self) -> String {
        let form = match self.form {
            ClosedForm::BumpySphere => "bumpy sphere",
            ClosedForm::Room => "room between thin walls",
        };
        format!("{form}, size {}, moved by {}", self.size, self.offset)
    }

    /// The mesh as the only shape of a world.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// Samples a segment that begins inside the mesh and ends outside, or within the wall of a room.
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
        let triangle = mesh.triangle(random.below(self.target_count) as u32);
        let corner = random.below(3);
        let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
        match aim {
            Aim::Vertex => a,
            _ => a + random.uniform() * (b - a),
        }
    }

    /// The parameter at which a segment ends, for the form of size 1 at the origin: far outside, or half a wall behind
    /// the inner face.
    fn end(&self, from: DVec3, dir: DVec3) -> f64 {
        match self.form {
            ClosedForm::BumpySphere => 4.0 / dir.length(),
            ClosedForm::Room => {
                let exits = (dir.signum() - from) / dir;
                exits.min_element() + 0.5 * WALL / dir.abs().max_element()
            }
        }
    }
}

/// Tessellates the surface of the cube from -1 to 1 into `n` x `n` squares per face, each of two triangles, and maps
/// the vertices by `place`: positions and indices. Neighbouring triangles share their vertices.
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
