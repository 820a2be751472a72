//! The intervals of a ray in which a query in single precision may hit a primitive: they decide between two backends
//! that disagree.
//!
//! A query in single precision gives the exact answer for a ray and a primitive displaced slightly relative to each
//! other, except for rounding in the sums and products that it then computes. The displacement is bounded by four times
//! the error bound of a hit point, which is what the re-check of Embree's hits accepts. The rounding of each sum of
//! products is bounded by gamma_n times the same sum of absolute values. A ray that is inside by more than both bounds
//! is a certain hit; one that is outside by more is a miss.
//!
//! Measure: parameters in multiples of the ray's direction, computed in double precision.
//! Range: finite rays. Where the determinant is not above its error, the parameter is unknown.
//! Source: Higham 2002, section 3.1, for the sums; Möller and Trumbore 1997, and the edge tests by Plücker coordinates
//! of Woop, Benthin and Wald 2013, for their terms. Tested in `lab/tests/bench/agreement.rs`.

use etendue::internals::accel::PrimitiveId;
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::disk::Disk;
use etendue::internals::geometry::sphere::Sphere;
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::robust;
use etendue::internals::math::vec::DVec3;

/// An interval of a ray in which a query may hit a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HitInterval {
    /// The start of the interval.
    pub from: f64,
    /// The end of the interval.
    pub to: f64,
    /// Whether every query has to find the primitive there.
    pub certain: bool,
}

impl HitInterval {
    /// Whether the interval contains a hit at `t`.
    pub fn holds(&self, t: f32) -> bool {
        (self.from..=self.to).contains(&t.into())
    }

    /// Whether two hits may be at the same distance.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.from <= other.to && other.from <= self.to
    }

    /// Whether the ray is so nearly parallel to the surface that the distance is undetermined.
    pub fn is_grazing(&self) -> bool {
        !self.to.is_finite()
    }
}

/// The intervals of a ray in which a primitive may be hit, at a shutter time: two for a sphere.
pub fn hit_intervals(
    world: &World,
    id: PrimitiveId,
    ray: &Ray,
    time: f32,
) -> [Option<HitInterval>; 2] {
    let query = Query::new(world, id, ray, time);
    match world.geometry(id.shape) {
        Geometry::Mesh(mesh) => {
            let vertices = mesh.triangle(id.primitive).map(|v| v.as_dvec3());
            [query.triangle(vertices), None]
        }
        Geometry::Sphere(sphere) => query.sphere(sphere),
        Geometry::Disk(disk) => [query.disk(disk), None],
    }
}

/// A ray in the primitive's local coordinates.
struct Query {
    origin: DVec3,
    dir: DVec3,
    t_min: f64,
    t_max: f64,
    /// The bound on the displacement of ray and primitive relative to each other, along each axis.
    room: DVec3,
}

impl Query {
    fn new(world: &World, id: PrimitiveId, ray: &Ray, time: f32) -> Self {
        let bounds = world.geometry(id.shape).primitive_bounds(id.primitive);
        let (size, extent) = (bounds.min.abs().max(bounds.max.abs()), bounds.extent());
        // An upper bound on the error of a point on a triangle, a sphere or a disk.
        let point = gamma(8) * (size + 2.0 * extent);
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        let in_world = Self {
            origin,
            dir,
            t_min: ray.t_min.into(),
            t_max: ray.t_max.into(),
            room: 4.0 * (point + gamma(4) * (2.0 * origin.abs() + size)),
        };
        let (Some(placed), Some(instance)) =
            (world.placed(id.shape, time), world.placement(id.shape))
        else {
            return in_world;
        };
        let to_world = instance.at(time);
        let centre = bounds.centre().as_vec3a();
        let apart = origin - to_world.transform_point3(centre.as_dvec3());
        let reach = apart.abs() + to_world.matrix3.abs() * extent;
        let (p, error) = placed.point(centre, point.as_vec3a(), reach);
        let room = 4.0 * (error + gamma(4) * (origin.abs() + p.abs() + reach));
        let to_local = to_world.inverse();
        Self {
            origin: to_local.transform_point3(origin),
            dir: to_local.transform_vector3(dir),
            room: to_local.matrix3.abs() * room,
            ..in_world
        }
    }

    /// The interval of a triangle, which is hit if the volumes d . (p_i x p_j) that the ray spans with its edges have
    /// the same sign.
    fn triangle(&self, vertices: [DVec3; 3]) -> Option<HitInterval> {
        let Self { dir, room, .. } = *self;
        let p = vertices.map(|vertex| vertex - self.origin);
        let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
        let edges = e1.abs() + e2.abs();
        let reach = p[0].abs() + p[1].abs() + p[2].abs();
        // Seven roundings in each volume, as many in the determinant, and two to compute the third volume from the
        // others; the products of these sums are at most twice the permanent.
        let rounding = gamma(18) * permanent(dir, edges, reach) + permanent(dir, room, room);
        let moments = p.map(|p| dir.cross(p).abs());
        let sides: [(f64, f64); 3] = std::array::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let volume = dir.dot(p[i].cross(p[j]));
            (volume, rounding + room.dot(moments[i] + moments[j]))
        });
        let all = |sign: f64, inside: f64| {
            let mut sides = sides.iter();
            sides.all(|(volume, error)| sign * volume >= inside * error)
        };
        if !all(1.0, -1.0) && !all(-1.0, -1.0) {
            return None;
        }
        let normal = e1.cross(e2);
        let determinant = dir.dot(normal);
        let lowest = determinant.abs() - sides.iter().map(|(_, error)| error).sum::<f64>();
        if lowest <= 0.0 {
            return self.grazing();
        }
        let t = p[0].dot(normal) / determinant;
        // A vertex displaced by `room` moves the intersection of ray and plane by at most normal . room / normal . d.
        // The tilt of the plane by rounding acts from a vertex on; the remaining terms are the roundings of two scalar
        // products and of their quotient.
        let wide = edges + 4.0 * room;
        let tilt = gamma(4) * unsigned_cross(wide, wide);
        let steep =
            normal.abs() + tilt + (unsigned_cross(wide, wide) - unsigned_cross(edges, edges));
        let products = gamma(4) * steep.dot(p[0].abs() + t.abs() * dir.abs());
        let moved = normal.abs().dot(room) + tilt.dot(wide) + products;
        let error = moved / lowest + gamma(4) * t.abs();
        self.within(t - error, t + error, all(1.0, 1.0) || all(-1.0, 1.0))
    }

    /// The intervals at both ends of the chord, whose half length follows from the line's distance from the centre.
    fn sphere(&self, sphere: &Sphere) -> [Option<HitInterval>; 2] {
        let (to_center, radius) = (
            sphere.center.as_dvec3() - self.origin,
            f64::from(sphere.radius),
        );
        let per_length = self.dir.length().recip();
        let middle = to_center.dot(self.dir) * per_length * per_length;
        let distance = (to_center - middle * self.dir).length();
        // Six roundings of the projection, two more of its difference from the centre; as many for the squares.
        let error = self.room.length() + gamma(16) * (to_center.length() + radius);
        if distance > radius + error {
            return [None; 2];
        }
        let half = |distance: f64| {
            let square = (radius - distance) * (radius + distance);
            square.max(0.0).sqrt() * per_length
        };
        let (least, most) = (half(distance + error), half((distance - error).max(0.0)));
        let along = error * per_length + gamma(8) * (middle.abs() + most);
        let certain = distance + error < radius;
        [
            self.within(middle - most - along, middle - least + along, certain),
            self.within(middle + least - along, middle + most + along, certain),
        ]
    }

    fn disk(&self, disk: &Disk) -> Option<HitInterval> {
        let (to_center, radius) = (disk.center.as_dvec3() - self.origin, f64::from(disk.radius));
        let normal = disk.normal.as_dvec3();
        let determinant = normal.dot(self.dir);
        let products = |v: DVec3| gamma(4) * normal.abs().dot(v.abs());
        let lowest = determinant.abs() - products(self.dir);
        if lowest <= 0.0 {
            return self.grazing();
        }
        let t = to_center.dot(normal) / determinant;
        let moved = normal.abs().dot(self.room) + products(to_center) + products(t * self.dir);
        let along = moved / lowest + gamma(4) * t.abs();
        let across = self.room.length()
            + along * self.dir.length()
            + gamma(8) * (to_center.length() + radius);
        let distance = (t * self.dir - to_center).length();
        if distance > radius + across {
            return None;
        }
        self.within(t - along, t + along, distance + across < radius)
    }

    fn grazing(&self) -> Option<HitInterval> {
        self.within(f64::NEG_INFINITY, f64::INFINITY, false)
    }

    /// Clips an interval to the ray's ends: `None` if it lies outside of them, not certain if it is not fully inside.
    fn within(&self, from: f64, to: f64, certain: bool) -> Option<HitInterval> {
        (to >= self.t_min && from <= self.t_max).then_some(HitInterval {
            from,
            to,
            certain: certain && from > self.t_min && to <= self.t_max,
        })
    }
}

fn gamma(n: u32) -> f64 {
    robust::gamma(n).into()
}

/// The cross product of absolute values, with sums in place of differences.
fn unsigned_cross(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}

/// The determinant of absolute values, with sums in place of differences.
fn permanent(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    a.abs().dot(unsigned_cross(b, c))
}
