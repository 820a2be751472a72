//! The stages of a bounce, each a loop over the lanes of every block.

use crate::MAX_BOUNCES;
use crate::block::{Block, get, set};
use crate::light::Light;
use crate::random::jump;
use crate::tables::{Camera, Tables};
use etendue::internals::accel::lanes::NO_ID;
use etendue::internals::math::lanes::{LANES, Lanes};
use etendue::internals::math::measure::PdfSolidAngle;
use etendue::internals::math::robust::gamma;
use etendue::internals::math::trig::sin_cos_eighth;
use etendue::internals::math::vec::{LaneVec3 as Vec3, Vec2};
use etendue::internals::sampling::mis;
use multiversion::multiversion;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

/// Moves a point off a surface, as `math::robust::offset_point` does.
#[inline(always)]
pub fn offset_point(p: Vec3, error: Vec3, n: Vec3) -> Vec3 {
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
pub fn power_heuristic(p: f32, q: f32) -> f32 {
    mis::power_heuristic(PdfSolidAngle(p), PdfSolidAngle(q))
}

#[inline(always)]
pub fn lane_mask(is_active: bool) -> i32 {
    if is_active { -1 } else { 0 }
}

/// Begins sixteen samples whose random streams are given: the camera rays.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn sample_camera(camera: &Camera, block: &mut Block, pixels: &[Lanes<f32>; 2]) {
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
pub fn draw_numbers(blocks: &mut [Block]) {
    for Block {
        random, numbers, ..
    } in blocks
    {
        random.draw([jump(0), jump(1), jump(4), jump(5)], numbers);
    }
}

/// Copies the triangles that were hit into lanes; paths that leave the scene end.
pub fn fetch_surfaces(tables: &Tables<'_>, blocks: &mut [Block]) {
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
pub fn shade(light: &Light, blocks: &mut [Block]) {
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
            block.shadow_ray_lanes.0[lane] = lane_mask(samples_light);

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
pub fn add_light(blocks: &mut [Block]) {
    for block in blocks {
        for lane in 0..LANES {
            let is_visible =
                (block.shadow_ray_lanes.0[lane] != 0) & (block.shadow.t_max[lane] > 0.0);
            let contribution = get(&block.contribution, lane);
            let contribution = if is_visible { contribution } else { Vec3::ZERO };
            let radiance = get(&block.radiance, lane) + contribution;
            set(&mut block.radiance, lane, radiance);
        }
    }
}
