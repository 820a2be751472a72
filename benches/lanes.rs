//! The least that a path tracer on Embree costs beyond its rays: diffuse triangles under one rectangle light, in lanes from
//! the camera ray to the film. The rays of the same paths, traced alone, are the floor.
//!
//! Sixteen paths make a block, and a block's state is a structure of arrays. Each stage is a loop over the lanes of a block
//! without branches or calls, written for one lane in scalar code, which the compiler vectorises. Only vertices are copied
//! one lane at a time. Lanes whose paths end are refilled with samples whose camera rays have been traced as coherent
//! packets of 4 x 4 pixels. docs/architecture.md has the results.
//!
//! Run: `cargo bench --bench lanes [-- SCENE]`, with a scene file of the kind described, by default the Cornell box. It prints
//! nanoseconds on one thread.
// A loop over lanes indexes several arrays alike.
#![allow(clippy::needless_range_loop)]

mod common;

use common::ready;
use etendue::internals::accel::Accel;
use etendue::internals::accel::embree::EmbreeAccel;
use etendue::internals::accel::lanes::{ActiveLanes, NO_ID, RayHitLanes, RayLanes};
use etendue::internals::effects::kernel::types::Matte;
use etendue::internals::geometry::Geometry;
use etendue::internals::math::lanes::{LANES, Lanes};
use etendue::internals::math::measure::PdfArea;
use etendue::internals::math::robust::gamma;
use etendue::internals::math::trig::sin_cos_eighth;
use etendue::internals::math::vec::{LaneVec3 as Vec3, Vec2};
use etendue::internals::sampler::hash;
use etendue::internals::sampling::linear::LinearSquare;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{ColourDescription, MaterialModel, SceneDescription};
use etendue::internals::scene::load::load;
use multiversion::multiversion;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// The edge of the square image, in pixels.
const SIZE: usize = 256;
/// The edge of a tile, in pixels.
const TILE: usize = 16;
/// Samples per pixel.
const SPP: usize = 64;
/// Scattering events of a path; there is no roulette.
const MAX_BOUNCES: u32 = 7;
/// Blocks that a thread works on at a time.
const BLOCKS: usize = 16;
/// Measurements, of which the median is printed.
const ROUNDS: usize = 7;
/// Tiles whose rays are recorded for the floor: one of so many.
const RECORDED: usize = 11;
/// The sample index that marks a lane without a path.
const NO_SAMPLE: u32 = u32::MAX;

type Lanes3 = [Lanes<f32>; 3];

/// Sixteen paths.
#[derive(Clone)]
#[repr(C, align(64))]
struct Block {
    /// Extension rays, and their hits.
    extension: RayHitLanes<LANES>,
    /// The lanes whose extension rays are to be traced.
    to_trace: ActiveLanes<LANES>,
    shadow: RayLanes<LANES>,
    to_shadow: ActiveLanes<LANES>,
    /// The lanes with a path that has not ended.
    active: ActiveLanes<LANES>,
    /// The index of each path's sample in the tile.
    sample: Lanes<u32>,
    bounce: Lanes<u32>,
    beta: Lanes3,
    radiance: Lanes3,
    /// The contribution of the light sample, if it is not occluded.
    contribution: Lanes3,
    /// The density of the last direction; infinite for camera rays, which light samples do not compete with.
    pdf: Lanes<f32>,
    random: RandomLanes,
    /// The random numbers of a bounce: for the point on the light, and for the direction.
    numbers: [Lanes<f32>; 4],
    surfaces: SurfaceLanes,
}

/// The triangles that were hit.
#[derive(Clone)]
struct SurfaceLanes {
    vertices: [Lanes3; 3],
    reflectance: Lanes3,
    /// 1 on the light, 0 elsewhere.
    is_light: Lanes<f32>,
}

/// A PCG stream for each lane (O'Neill 2014), with the state of the next decision.
#[derive(Clone)]
struct RandomLanes {
    state: Lanes<u64>,
    increment: Lanes<u64>,
}

impl Block {
    fn new() -> Self {
        let zero = [0.0; LANES];
        Self {
            extension: RayHitLanes::default(),
            to_trace: ActiveLanes::NONE,
            shadow: RayLanes::default(),
            to_shadow: ActiveLanes::NONE,
            active: ActiveLanes::NONE,
            sample: [NO_SAMPLE; LANES],
            bounce: [0; LANES],
            beta: [zero; 3],
            radiance: [zero; 3],
            contribution: [zero; 3],
            pdf: zero,
            random: RandomLanes {
                state: [0; LANES],
                increment: [0; LANES],
            },
            numbers: [zero; 4],
            surfaces: SurfaceLanes {
                vertices: [[zero; 3]; 3],
                reflectance: [zero; 3],
                is_light: zero,
            },
        }
    }
}

#[inline(always)]
fn get(from: &Lanes3, lane: usize) -> Vec3 {
    Vec3::new(from[0][lane], from[1][lane], from[2][lane])
}

#[inline(always)]
fn set(to: &mut Lanes3, lane: usize, v: Vec3) {
    to[0][lane] = v.x;
    to[1][lane] = v.y;
    to[2][lane] = v.z;
}

/// The multiplier of PCG's congruential generator.
const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
/// The numbers that a bounce, or the camera, owns in a stream.
const NUMBERS: u64 = 8;
/// The steps from one sample of a pixel to the next.
const SAMPLE_STRIDE: u64 = 1025;

/// The multiplier of the state and that of the increment which advance a generator by `steps` (Brown 1994).
const fn jump(mut steps: u64) -> (u64, u64) {
    let (mut of_state, mut of_increment) = (1_u64, 0_u64);
    let (mut power, mut sum) = (MULTIPLIER, 1_u64);
    while steps > 0 {
        if steps & 1 == 1 {
            of_state = of_state.wrapping_mul(power);
            of_increment = of_increment.wrapping_mul(power).wrapping_add(sum);
        }
        sum = power.wrapping_add(1).wrapping_mul(sum);
        power = power.wrapping_mul(power);
        steps >>= 1;
    }
    (of_state, of_increment)
}

#[inline(always)]
const fn advance(state: u64, increment: u64, (of_state, of_increment): (u64, u64)) -> u64 {
    state
        .wrapping_mul(of_state)
        .wrapping_add(increment.wrapping_mul(of_increment))
}

impl RandomLanes {
    /// Draws the numbers at these places of each lane's decision, and advances to the next decision.
    #[inline(always)]
    fn draw<const N: usize>(&mut self, places: [(u64, u64); N], numbers: &mut [Lanes<f32>; 4]) {
        for (numbers, place) in numbers.iter_mut().zip(places) {
            for lane in 0..LANES {
                let state = advance(self.state[lane], self.increment[lane], place);
                let mixed = (((state >> 18) ^ state) >> 27) as u32;
                let bits = mixed.rotate_right((state >> 59) as u32) >> 8;
                numbers[lane] = bits as i32 as f32 * (1.0 / 16_777_216.0);
            }
        }
        const NEXT: (u64, u64) = jump(NUMBERS);
        for lane in 0..LANES {
            self.state[lane] = advance(self.state[lane], self.increment[lane], NEXT);
        }
    }
}

/// A rectangle light that emits to one side.
struct Light {
    corner: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    radiance: Vec3,
    /// One over the area.
    pdf_area: f32,
    over_radius2: f32,
    half_edges2: Vec2,
    over_edges2: Vec2,
}

impl Light {
    /// Creates the light of a rectangle's two triangles.
    fn new([a, b, c]: [Vec3; 3], radiance: Vec3) -> Self {
        let edges = [b - a, c - b];
        let lengths2 = edges.map(|edge| edge.length_squared());
        let radius2 = 0.25 * (lengths2[0] + lengths2[1]);
        Self {
            corner: a,
            edges,
            normal: edges[0].cross(edges[1]).normalize(),
            radiance,
            pdf_area: 1.0 / (lengths2[0] * lengths2[1]).sqrt(),
            over_radius2: 1.0 / radius2,
            half_edges2: Vec2::from(lengths2) * (0.25 / radius2),
            over_edges2: 1.0 / Vec2::from(lengths2),
        }
    }

    /// The density for a receiver, given the corner relative to it: 1 / r^3 at the midpoint of each edge, as in
    /// `src/light/rectangle.rs`.
    #[inline(always)]
    fn density(&self, corner: Vec3) -> LinearSquare {
        let center = corner + 0.5 * (self.edges[0] + self.edges[1]);
        let distance2 = self.over_radius2 * center.length_squared();
        let along = self.edges.map(|edge| self.over_radius2 * center.dot(edge));
        let far = self.half_edges2 + Vec2::splat(distance2);
        let weight = |r2: f32| (1.0 / r2) * (1.0 / r2).sqrt();
        let weights = |r2: Vec2| Vec2::new(weight(r2.x), weight(r2.y));
        let along = Vec2::from(along);
        LinearSquare::new(weights(far - along), weights(far + along))
    }

    #[inline(always)]
    fn per_steradian(&self, of_shares: f32, distance2: f32, cos: f32) -> f32 {
        let pdf = PdfArea(of_shares * self.pdf_area).to_solid_angle(distance2, cos);
        pdf.map_or(f32::INFINITY, |pdf| pdf.0)
    }

    /// The density of sampling the point at `towards` from a receiver, where the light's cosine is `cos`.
    #[inline(always)]
    fn pdf(&self, receiver: Vec3, towards: Vec3, cos: f32) -> f32 {
        let corner = self.corner - receiver;
        let from_corner = towards - corner;
        let along = Vec2::from(self.edges.map(|edge| from_corner.dot(edge)));
        let of_shares = self.density(corner).pdf(self.over_edges2 * along);
        self.per_steradian(of_shares, towards.length_squared(), cos)
    }
}

/// What the stages need of a scene.
struct Tables<'a> {
    accel: &'a EmbreeAccel,
    triangles: Vec<[[f32; 3]; 3]>,
    /// The index of the first triangle of each shape.
    first: Vec<u32>,
    reflectance: Vec<[f32; 3]>,
    is_light: Vec<f32>,
    light: Light,
    camera: Camera,
}

/// A pinhole camera.
struct Camera {
    eye: Vec3,
    /// The direction to the upper left corner, and the steps to the next pixel, at viewing depth 1.
    corner: Vec3,
    steps: [Vec3; 2],
}

impl Camera {
    fn new(scene: &Scene) -> Self {
        let ray = |x: f32, y: f32| {
            let film = SIZE as f32 * Vec2::new(x, y);
            let ray = scene.camera.ray::<Matte>(film, Vec2::ZERO, 0.0);
            [ray.origin, ray.dir].map(|v| Vec3::from(v.to_array()))
        };
        let [eye, axis] = ray(0.5, 0.5);
        let [corner, right, below] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| {
            let [_, dir] = ray(x, y);
            dir / dir.dot(axis)
        });
        Self {
            eye,
            corner,
            steps: [right, below].map(|dir| (dir - corner) / SIZE as f32),
        }
    }
}

fn constant(colour: &ColourDescription) -> [f32; 3] {
    let colour = colour.constant().expect("a constant colour");
    colour.to_array()
}

impl<'a> Tables<'a> {
    fn new(description: &SceneDescription, scene: &'a Scene) -> Self {
        let Accel::Embree(accel) = &*scene.accel else {
            panic!("the preferred backend is Embree");
        };
        let (mut triangles, mut first) = (Vec::new(), Vec::new());
        let (mut reflectance, mut is_light, mut light) = (Vec::new(), Vec::new(), None);
        for (geometry, shape) in scene.world.geometries().iter().zip(&description.shapes) {
            let Geometry::Mesh(mesh) = geometry else {
                panic!("{} is not a mesh", shape.name);
            };
            let of_mesh = 0..mesh.indices().len() as u32;
            first.push(triangles.len() as u32);
            triangles.extend(of_mesh.map(|t| mesh.triangle(t).map(|v| v.to_array())));
            let model = &description.materials[shape.material].model;
            let MaterialModel::Diffuse {
                reflectance: of_shape,
            } = model
            else {
                panic!("{} is not diffuse", shape.name);
            };
            reflectance.push(constant(of_shape));
            is_light.push(if shape.emission.is_some() { 1.0 } else { 0.0 });
            if let Some(emission) = &shape.emission {
                let corners = mesh.triangle(0).map(|v| Vec3::from(v.to_array()));
                light = Some(Light::new(corners, Vec3::from(constant(emission))));
            }
        }
        Self {
            accel,
            triangles,
            first,
            reflectance,
            is_light,
            light: light.expect("a light"),
            camera: Camera::new(scene),
        }
    }
}

/// Moves a point off a surface, as `math::robust::offset_point` does.
#[inline(always)]
fn offset_point(p: Vec3, error: Vec3, n: Vec3) -> Vec3 {
    let offset = n.abs().dot(error) * n;
    let moved = p + offset;
    let away = |offset: f32, moved: f32| {
        let step = (f32::EPSILON * moved.abs()).copysign(offset);
        moved + if offset == 0.0 { 0.0 } else { step }
    };
    Vec3::new(
        away(offset.x, moved.x),
        away(offset.y, moved.y),
        away(offset.z, moved.z),
    )
}

/// The weight of the power heuristic for a sample of density `p`, where the other strategy has the density `q`.
#[inline(always)]
fn power_heuristic(p: f32, q: f32) -> f32 {
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}

#[inline(always)]
fn lane_mask(is_active: bool) -> i32 {
    if is_active { -1 } else { 0 }
}

/// Begins sixteen samples whose random streams are given: the camera rays.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn sample_camera(camera: &Camera, block: &mut Block, pixels: &[Lanes<f32>; 2]) {
    block.random.draw([jump(0), jump(1)], &mut block.numbers);
    for lane in 0..LANES {
        let [x, y] = [0, 1].map(|axis| pixels[axis][lane] + block.numbers[axis][lane]);
        let dir = camera.corner + x * camera.steps[0] + y * camera.steps[1];
        let dir = dir * (1.0 / dir.length());
        set(&mut block.extension.rays.origin, lane, camera.eye);
        set(&mut block.extension.rays.dir, lane, dir);
        block.extension.rays.t_max[lane] = f32::INFINITY;
        block.extension.hits.geometry[lane] = NO_ID;
        block.active.0[lane] = -1;
    }
}

/// Draws the random numbers of a bounce.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn draw_numbers(blocks: &mut [Block]) {
    for Block {
        random, numbers, ..
    } in blocks
    {
        random.draw([jump(0), jump(1), jump(4), jump(5)], numbers);
    }
}

/// Copies the triangles that were hit into lanes; paths that leave the scene end.
fn fetch_surfaces(tables: &Tables<'_>, blocks: &mut [Block]) {
    for block in blocks {
        for lane in 0..LANES {
            let shape = block.extension.hits.geometry[lane];
            if shape == NO_ID {
                block.active.0[lane] = 0;
            }
            if block.active.0[lane] == 0 {
                continue;
            }
            let shape = shape as usize;
            let primitive = tables.first[shape] + block.extension.hits.primitive[lane];
            let surfaces = &mut block.surfaces;
            let vertices = &tables.triangles[primitive as usize];
            for (to, vertex) in surfaces.vertices.iter_mut().zip(vertices) {
                set(to, lane, Vec3::from(*vertex));
            }
            let reflectance = Vec3::from(tables.reflectance[shape]);
            set(&mut surfaces.reflectance, lane, reflectance);
            surfaces.is_light[lane] = tables.is_light[shape];
        }
    }
}

/// Adds emission, samples the light and the next direction: writes the shadow rays and the extension rays.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn shade(light: &Light, blocks: &mut [Block]) {
    for block in blocks {
        for lane in 0..LANES {
            // Surface interaction.
            let hits = &block.extension.hits;
            let (u, v) = (hits.u[lane], hits.v[lane]);
            let [a, b, c] = [0, 1, 2].map(|i| get(&block.surfaces.vertices[i], lane));
            let (wa, ub, vc) = ((1.0 - u - v) * a, u * b, v * c);
            let p = wa + ub + vc;
            let (e1, e2) = (b - a, c - a);
            let cross = e1.cross(e2);
            let ng = cross * (1.0 / cross.length());
            let error =
                gamma(7) * (wa.abs() + ub.abs() + vc.abs()) + gamma(6) * (e1.abs() + e2.abs());
            let rays = &mut block.extension.rays;
            let cos_o = -get(&rays.dir, lane).dot(ng);
            let n = ng * if cos_o < 0.0 { -1.0 } else { 1.0 };
            let mut beta = get(&block.beta, lane);

            // Emission.
            let is_light = block.surfaces.is_light[lane] > 0.0;
            let is_active = block.active.0[lane] != 0;
            let from = get(&rays.origin, lane);
            let pdf_light = light.pdf(from, p - from, cos_o);
            let weight = power_heuristic(block.pdf[lane], pdf_light);
            let is_lit = is_active & is_light & (cos_o > 0.0);
            let weight = if is_lit { weight } else { 0.0 };
            let radiance = get(&block.radiance, lane) + beta * light.radiance * weight;
            set(&mut block.radiance, lane, radiance);
            let continues = is_active & !is_light & (block.bounce[lane] < MAX_BOUNCES);

            // Light sample.
            let u_light = Vec2::new(block.numbers[0][lane], block.numbers[1][lane]);
            let density = light.density(light.corner - p);
            let shares = density.sample(u_light);
            let q = light.corner + shares.x * light.edges[0] + shares.y * light.edges[1];
            let distance2 = (q - p).length_squared();
            let wi = (q - p) * (1.0 / distance2.sqrt());
            let (cos_light, cos_i) = (-wi.dot(light.normal), wi.dot(n));
            let pdf_light = light.per_steradian(density.pdf(shares), distance2, cos_light);
            let pdf_bsdf = cos_i * FRAC_1_PI;
            let samples_light =
                continues & (cos_light > 0.0) & (cos_i > 0.0) & (pdf_light < f32::INFINITY);
            let factor = pdf_bsdf * power_heuristic(pdf_light, pdf_bsdf) / pdf_light;
            beta *= get(&block.surfaces.reflectance, lane);
            set(
                &mut block.contribution,
                lane,
                beta * light.radiance * factor,
            );
            let origin = offset_point(p, error, n);
            let end_error = gamma(9) * q.abs() + gamma(8) * (q - p).abs();
            let end = offset_point(q, end_error, light.normal);
            set(&mut block.shadow.origin, lane, origin);
            set(&mut block.shadow.dir, lane, end - origin);
            block.shadow.t_max[lane] = 1.0;
            block.to_shadow.0[lane] = lane_mask(samples_light);

            // BSDF sample: a concentric disk, projected onto the hemisphere, in the frame of Duff et al. 2017.
            let x = 2.0 * block.numbers[2][lane] - 1.0;
            let y = 2.0 * block.numbers[3][lane] - 1.0;
            let along_x = x.abs() > y.abs();
            let (radius, across) = if along_x { (x, y) } else { (y, x) };
            let share = across / if radius == 0.0 { 1.0 } else { radius };
            let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * share);
            let (x, y) = if along_x { (cos, sin) } else { (sin, cos) };
            let (x, y) = (radius * x, radius * y);
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let sign = 1.0_f32.copysign(n.z);
            let k = -1.0 / (sign + n.z);
            let m = n.x * n.y * k;
            let s = Vec3::new(1.0 + sign * n.x * n.x * k, sign * m, -sign * n.x);
            let t = Vec3::new(m, sign + n.y * n.y * k, -n.y);
            set(&mut block.beta, lane, beta);
            block.pdf[lane] = z * FRAC_1_PI;
            block.bounce[lane] += 1;
            set(&mut rays.origin, lane, origin);
            set(&mut rays.dir, lane, x * s + y * t + z * n);
            rays.t_max[lane] = f32::INFINITY;
            block.extension.hits.geometry[lane] = NO_ID;
            block.active.0[lane] = lane_mask(continues);
            block.to_trace.0[lane] = lane_mask(continues);
        }
    }
}

/// Adds the contributions of light samples that are not occluded.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_light(blocks: &mut [Block]) {
    for block in blocks {
        for lane in 0..LANES {
            let is_visible = (block.to_shadow.0[lane] != 0) & (block.shadow.t_max[lane] > 0.0);
            let contribution = get(&block.contribution, lane);
            let contribution = if is_visible { contribution } else { Vec3::ZERO };
            let radiance = get(&block.radiance, lane) + contribution;
            set(&mut block.radiance, lane, radiance);
        }
    }
}

/// Rays as they were before they were traced.
#[derive(Default)]
struct Recording {
    camera: Vec<(ActiveLanes<LANES>, RayHitLanes<LANES>)>,
    extension: Vec<(ActiveLanes<LANES>, RayHitLanes<LANES>)>,
    shadow: Vec<(ActiveLanes<LANES>, RayLanes<LANES>)>,
}

impl Recording {
    /// The number of rays of each kind.
    fn rays(&self) -> [usize; 3] {
        let lanes = |list: &[(ActiveLanes<LANES>, RayHitLanes<LANES>)]| {
            list.iter().map(|(active, _)| active.count()).sum()
        };
        let shadow = self.shadow.iter().map(|(active, _)| active.count()).sum();
        [lanes(&self.camera), lanes(&self.extension), shadow]
    }

    /// Traces all rays, and returns the seconds for each kind.
    fn trace(&mut self, tables: &Tables<'_>) -> [f64; 3] {
        let kinds = [(&mut self.camera, true), (&mut self.extension, false)];
        let [camera, extension] = kinds.map(|(packets, coherent)| {
            let start = Instant::now();
            for (active, packet) in packets {
                packet.rays.t_max = [f32::INFINITY; LANES];
                packet.hits.geometry = [NO_ID; LANES];
                tables.accel.intersect_lanes(active, packet, coherent);
            }
            start.elapsed().as_secs_f64()
        });
        let start = Instant::now();
        for (active, packet) in &mut self.shadow {
            packet.t_max = [1.0; LANES];
            tables.accel.occluded_lanes(active, packet);
        }
        [camera, extension, start.elapsed().as_secs_f64()]
    }
}

/// The samples of tiles.
struct Worker<'a> {
    tables: &'a Tables<'a>,
    blocks: Vec<Block>,
    /// Samples whose camera rays have been traced, the first `used` of which are in blocks already.
    ready: Block,
    used: usize,
    /// The generator of each pixel at its next sample.
    pixels: Vec<(u64, u64)>,
    samples: Vec<Vec3>,
    recording: Option<Recording>,
}

impl<'a> Worker<'a> {
    fn new(tables: &'a Tables<'a>) -> Self {
        Self {
            tables,
            blocks: vec![Block::new(); BLOCKS],
            ready: Block::new(),
            used: LANES,
            pixels: Vec::new(),
            samples: vec![Vec3::ZERO; TILE * TILE * SPP],
            recording: None,
        }
    }

    /// Renders a tile, whose upper left pixel is given, and returns the sum of its samples.
    fn render(&mut self, corner: [usize; 2]) -> [f64; 3] {
        self.pixels.clear();
        for pixel in 0..TILE * TILE {
            let pixel = [corner[0] + pixel % TILE, corner[1] + pixel / TILE];
            let seed = hash::pixel_seed(1, pixel.map(|i| i as u32));
            let increment = hash::combine(seed, 0) << 1 | 1;
            let state = advance(seed.wrapping_add(increment), increment, jump(1));
            self.pixels.push((state, increment));
        }
        let mut packets = 0..TILE * TILE / LANES * SPP;
        while self.refill(corner, &mut packets) {
            self.trace();
        }
        let mut sum = [0.0; 3];
        for sample in &self.samples {
            for (sum, channel) in sum.iter_mut().zip(sample.to_array()) {
                *sum += f64::from(channel);
            }
        }
        sum
    }

    /// Stores the samples whose paths have ended, and replaces them. Returns whether any path is left.
    fn refill(&mut self, corner: [usize; 2], packets: &mut Range<usize>) -> bool {
        let mut any = false;
        for place in 0..self.blocks.len() {
            any |= self.blocks[place].active.any();
            for lane in self.blocks[place].active.inactive() {
                let block = &mut self.blocks[place];
                let sample = std::mem::replace(&mut block.sample[lane], NO_SAMPLE);
                if sample != NO_SAMPLE {
                    self.samples[sample as usize] = get(&block.radiance, lane);
                }
                if self.used == LANES {
                    let Some(packet) = packets.next() else {
                        continue;
                    };
                    self.begin(corner, packet);
                }
                self.start(place, lane);
                any = true;
            }
        }
        any
    }

    /// Traces the camera rays of one sample of 4 x 4 pixels.
    fn begin(&mut self, corner: [usize; 2], packet: usize) {
        const STRIDE: (u64, u64) = jump(SAMPLE_STRIDE);
        let (index, place) = (packet / LANES, packet % LANES);
        let mut film = [[0.0; LANES]; 2];
        let ready = &mut self.ready;
        for lane in 0..LANES {
            let x = place % 4 * 4 + lane % 4;
            let y = place / 4 * 4 + lane / 4;
            let pixel = y * TILE + x;
            film[0][lane] = (corner[0] + x) as f32;
            film[1][lane] = (corner[1] + y) as f32;
            let (state, increment) = &mut self.pixels[pixel];
            ready.random.state[lane] = *state;
            ready.random.increment[lane] = *increment;
            *state = advance(*state, *increment, STRIDE);
            ready.sample[lane] = (pixel * SPP + index) as u32;
        }
        sample_camera(&self.tables.camera, ready, &film);
        if let Some(recording) = &mut self.recording {
            recording
                .camera
                .push((ready.active, ready.extension.clone()));
        }
        let accel = self.tables.accel;
        accel.intersect_lanes(&ready.active, &mut ready.extension, true);
        self.used = 0;
    }

    /// Copies the next ready sample into a lane.
    fn start(&mut self, place: usize, lane: usize) {
        let (ready, from, block) = (&self.ready, self.used, &mut self.blocks[place]);
        self.used += 1;
        let (rays, hits) = (&mut block.extension.rays, &mut block.extension.hits);
        set(
            &mut rays.origin,
            lane,
            get(&ready.extension.rays.origin, from),
        );
        set(&mut rays.dir, lane, get(&ready.extension.rays.dir, from));
        hits.u[lane] = ready.extension.hits.u[from];
        hits.v[lane] = ready.extension.hits.v[from];
        hits.geometry[lane] = ready.extension.hits.geometry[from];
        hits.primitive[lane] = ready.extension.hits.primitive[from];
        set(&mut block.beta, lane, Vec3::ONE);
        set(&mut block.radiance, lane, Vec3::ZERO);
        block.pdf[lane] = f32::INFINITY;
        block.bounce[lane] = 0;
        block.sample[lane] = ready.sample[from];
        block.random.state[lane] = ready.random.state[from];
        block.random.increment[lane] = ready.random.increment[from];
        block.active.0[lane] = -1;
    }

    /// Traces all paths to their next surface.
    fn trace(&mut self) {
        let accel = self.tables.accel;
        for block in self.blocks.iter_mut().filter(|block| block.to_trace.any()) {
            if let Some(recording) = &mut self.recording {
                let packet = (block.to_trace, block.extension.clone());
                recording.extension.push(packet);
            }
            accel.intersect_lanes(&block.to_trace, &mut block.extension, false);
        }
        draw_numbers(&mut self.blocks);
        fetch_surfaces(self.tables, &mut self.blocks);
        shade(&self.tables.light, &mut self.blocks);
        for block in self.blocks.iter_mut().filter(|block| block.to_shadow.any()) {
            if let Some(recording) = &mut self.recording {
                recording
                    .shadow
                    .push((block.to_shadow, block.shadow.clone()));
            }
            accel.occluded_lanes(&block.to_shadow, &mut block.shadow);
        }
        add_light(&mut self.blocks);
    }
}

/// The tiles of the image, by their upper left pixels.
fn tiles() -> impl Iterator<Item = [usize; 2]> {
    let starts = || (0..SIZE).step_by(TILE);
    starts().flat_map(move |y| starts().map(move |x| [x, y]))
}

fn median(mut values: [f64; ROUNDS]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[ROUNDS / 2]
}

fn main() {
    let default = format!(
        "{}/scenes/cornell-box/cornell-box.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mut description = load(Path::new(&file.unwrap_or(default))).expect("a scene that loads");
    description.film.size = (SIZE as u32, SIZE as u32);
    let scene = ready(&description);
    let tables = Tables::new(&description, &scene);

    let mut worker = Worker::new(&tables);
    worker.recording = Some(Recording::default());
    let mut recorded = 0;
    for tile in tiles().step_by(RECORDED) {
        worker.render(tile);
        recorded += TILE * TILE * SPP;
    }
    let mut recording = worker.recording.take().expect("it was set");
    let rays = recording.rays().map(|rays| rays as f64 / recorded as f64);
    println!(
        "rays per sample: camera {:.3}, extension {:.3}, shadow {:.3}",
        rays[0], rays[1], rays[2]
    );

    let samples = SIZE * SIZE * SPP;
    let (mut floors, mut wholes) = ([[0.0; 3]; ROUNDS], [0.0; ROUNDS]);
    let mut sum = [0.0; 3];
    for (floor, whole) in floors.iter_mut().zip(&mut wholes) {
        *floor = recording.trace(&tables).map(|s| s * 1e9 / recorded as f64);
        let start = Instant::now();
        sum = [0.0; 3];
        for tile in tiles() {
            for (sum, of_tile) in sum.iter_mut().zip(worker.render(tile)) {
                *sum += of_tile;
            }
        }
        *whole = start.elapsed().as_secs_f64() * 1e9 / samples as f64;
    }
    let kinds = [0, 1, 2].map(|kind| median(floors.map(|floor| floor[kind])));
    let factors = std::array::from_fn(|i| wholes[i] / floors[i].iter().sum::<f64>());
    println!(
        "ns per sample, medians of {ROUNDS}: rays alone {:.1} (camera {:.1}, extension {:.1}, shadow {:.1}), whole {:.1}; ratio {:.3}",
        kinds.iter().sum::<f64>(),
        kinds[0],
        kinds[1],
        kinds[2],
        median(wholes),
        median(factors),
    );
    let mean = sum.map(|channel| channel / samples as f64);
    let [r, g, b] = mean;
    println!("mean radiance {r:.5} {g:.5} {b:.5}");
}
