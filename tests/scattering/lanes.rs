//! BSDFs that are evaluated and sampled in SIMD lanes give the same bits as those of each path alone.

use crate::common::TestRng;
use etendue::internals::bsdf::albedo::RowPlace;
use etendue::internals::bsdf::principled::lanes::{PrincipledLanes, RoughBsdf, SampledLanes};
use etendue::internals::bsdf::{
    Bsdf, BsdfSample, BsdfSampleInput, Conductor, Principled, PrincipledParameters,
};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::math::lanes::{ActiveLanes, LANES, load, store};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{Vec2, Vec3};
use std::borrow::Cow;

/// A direction anywhere on the sphere; one in eight is nearly tangential.
fn direction(rng: &mut TestRng) -> Vec3 {
    let mut v = || 2.0 * rng.uniform() - 1.0;
    let grazing = if v() > 0.75 { 1e-4 } else { 1.0 };
    (Vec3::new(v(), v(), grazing * v()) + Vec3::new(1e-3, 0.0, 0.0)).normalize()
}

/// A principled BSDF, or a conductor with this probability.
fn bsdf(rng: &mut TestRng, conductors: f32) -> Bsdf {
    let is_conductor = rng.uniform() < conductors;
    let mut u = || rng.uniform();
    let mut colour = || Rgb::new(u(), u(), u());
    let (a, b, tint) = (colour(), colour(), colour());
    let roughness = 0.011 + 0.989 * u();
    if is_conductor {
        let (eta, k) = (a * 3.0 + Rgb::grey(0.01), b * 4.0);
        return Bsdf::Conductor(Conductor::new(eta, k, roughness).tinted(tint));
    }
    Bsdf::Principled(Principled::new(&PrincipledParameters {
        base_color: a,
        metallic: (2.0 * u() - 0.5).clamp(0.0, 1.0),
        roughness,
        ior: 1.0 + u(),
        transmission: 0.0,
    }))
}

/// The BSDF as lanes take it, with its place in the table of albedos.
fn rough(bsdf: &Bsdf) -> (RoughBsdf<'_>, RowPlace) {
    let (rough, place) = match bsdf {
        Bsdf::Principled(bsdf) => (
            RoughBsdf::Principled(Cow::Borrowed(bsdf)),
            bsdf.place_in_lanes(),
        ),
        Bsdf::Conductor(bsdf) => (RoughBsdf::Conductor(bsdf), bsdf.place_in_lanes()),
        _ => unreachable!("it is made above"),
    };
    (rough, place.expect("it is rough and opaque"))
}

#[test]
fn simd_bsdf_lanes_are_bit_identical_to_scalar_code() {
    // Without a conductor among the lanes, another function evaluates them.
    for conductors in [0.0, 0.3, 1.0] {
        compare(conductors);
    }
}

fn compare(conductors: f32) {
    let mut rng = TestRng::new(11);
    let (mut lost, mut multiple) = (0, 0);
    let mut lanes = PrincipledLanes::default();
    for _ in 0..2000 {
        let bsdfs: [Bsdf; LANES] = std::array::from_fn(|_| bsdf(&mut rng, conductors));
        lanes.clear();
        let (mut wo, mut wi) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let (mut numbers, mut cosine_direction) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let inputs: [BsdfSampleInput; LANES] = std::array::from_fn(|lane| {
            let (rough, place) = rough(&bsdfs[lane]);
            lanes.set(lane, &rough, place);
            store(&mut wo, lane, direction(&mut rng));
            store(&mut wi, lane, direction(&mut rng));
            let u = [rng.uniform(), rng.uniform(), rng.uniform()];
            store(&mut numbers, lane, u);
            let input = BsdfSampleInput::new(u[2], Vec2::new(u[0], u[1]));
            store(&mut cosine_direction, lane, input.cosine_direction);
            input
        });
        let (mut f, mut pdf) = ([[0.0; LANES]; 3], [0.0; LANES]);
        let mut sampled = SampledLanes::default();
        lanes.bind(&wo);
        lanes.eval(&wi, &mut f, &mut pdf);
        let (mut f_again, mut pdf_again, mut reverse_pdf) = (f, pdf, pdf);
        lanes.eval_both_ways(&wi, &mut f_again, &mut pdf_again, &mut reverse_pdf);
        assert_eq!((f_again, pdf_again), (f, pdf));
        let all = ActiveLanes::first(LANES);
        let of_multiple = |lane: usize, u: Vec2| rough(&bsdfs[lane]).0.sample_multiple(u);
        lanes.sample(&all, &numbers, &cosine_direction, of_multiple, &mut sampled);
        let (mut f_sampled, mut pdf_sampled) = ([[0.0; LANES]; 3], [0.0; LANES]);
        let upper = sampled.wi[2];
        for lane in 0..LANES {
            sampled.wi[2][lane] = upper[lane].copysign(wo[2][lane]);
        }
        lanes.eval(&sampled.wi, &mut f_sampled, &mut pdf_sampled);
        for lane in 0..LANES {
            let alone = bsdfs[lane].bind::<Everything>(load(&wo, lane));
            let value = alone.eval::<Everything>(load(&wi, lane));
            assert_eq!(load::<Rgb>(&f, lane), value.f);
            assert_eq!(pdf[lane], value.pdf.0);
            let reversed = bsdfs[lane].bind::<Everything>(load(&wi, lane));
            let reversed = reversed.eval::<Everything>(load(&wo, lane));
            assert_eq!(reverse_pdf[lane], reversed.pdf.0);
            multiple += sampled.is_multiple[lane];
            match alone.sample::<Everything>(&inputs[lane]) {
                None => {
                    assert!(upper[lane] <= 0.0 || pdf_sampled[lane] <= 0.0);
                    lost += 1;
                }
                Some(BsdfSample {
                    wi, weight, pdf, ..
                }) => {
                    assert_eq!(load::<Vec3>(&sampled.wi, lane), wi);
                    assert_eq!(pdf.map(|pdf| pdf.0), Some(pdf_sampled[lane]));
                    let f: Rgb = load(&f_sampled, lane);
                    assert_eq!(f * (wi.z.abs() / pdf_sampled[lane]), weight);
                }
            }
        }
    }
    assert!(lost > 100 && multiple > 100, "{lost} {multiple}");
}
