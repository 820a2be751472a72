//! x
use etendue::accel::*;
use etendue::math::{rgb::Rgb, vec::*};
use etendue::render::{settings::*, *};
use etendue::scene::description::*;
fn main() {
    let m = |name: &str, r: [f32; 3]| MaterialDescription {
        name: name.into(),
        place: Default::default(),
        model: MaterialModel::Diffuse {
            reflectance: ColourDescription::Constant(Rgb::from(r)),
        },
    };
    let quad =
        |c: [f64; 3], u: [f64; 3], v: [f64; 3], mat: usize, e: Option<Rgb>| ShapeDescription {
            name: "q".into(),
            place: Default::default(),
            geometry: GeometryDescription::Rectangle {
                corner: DVec3::from(c),
                edge_u: DVec3::from(u),
                edge_v: DVec3::from(v),
            },
            transform: DAffine3::IDENTITY,
            material: mat,
            emission: e,
            two_sided_emission: false,
        };
    let bx = |min: [f64; 3], max: [f64; 3], angle: f64, t: [f64; 3]| ShapeDescription {
        name: "b".into(),
        place: Default::default(),
        geometry: GeometryDescription::Box {
            min: DVec3::from(min),
            max: DVec3::from(max),
        },
        transform: DAffine3::from_translation(DVec3::from(t))
            * DAffine3::from_rotation_y(angle.to_radians()),
        material: 0,
        emission: None,
        two_sided_emission: false,
    };
    let w = 555.0;
    let d = SceneDescription {
        file: "x".into(),
        camera: CameraDescription {
            to_world: DAffine3::from_rotation_translation(
                glam::DQuat::from_rotation_y(std::f64::consts::PI),
                DVec3::new(278.0, 273.0, -800.0),
            ),
            fov: 39.3f64.to_radians(),
            lens_radius: 0.0,
            focus_distance: 1.0,
        },
        film: FilmDescription {
            size: (1024, 1024),
            filter: FilterDescription {
                kind: FilterKind::Gaussian,
                radius: 1.5,
            },
        },
        render: Default::default(),
        materials: vec![
            m("white", [0.73; 3]),
            m("red", [0.63, 0.06, 0.05]),
            m("green", [0.15, 0.48, 0.09]),
            m("black", [0.0; 3]),
        ],
        shapes: vec![
            quad([0., 0., 0.], [w, 0., 0.], [0., 0., w], 0, None),
            quad([0., w, 0.], [w, 0., 0.], [0., 0., w], 0, None),
            quad([0., 0., w], [w, 0., 0.], [0., w, 0.], 0, None),
            quad([0., 0., 0.], [0., w, 0.], [0., 0., w], 2, None),
            quad([w, 0., 0.], [0., w, 0.], [0., 0., w], 1, None),
            quad(
                [213., 548.8, 227.],
                [130., 0., 0.],
                [0., 0., 105.],
                3,
                Some(Rgb::new(18.4, 15.6, 8.0)),
            ),
            bx([-82., 0., -82.], [82., 165., 82.], -17.0, [186., 0., 169.]),
            bx([-82., 0., -82.], [82., 330., 82.], 17.0, [368., 0., 351.]),
        ],
        environment: Rgb::BLACK,
        notes: vec![],
    };
    for precision in [Precision::Fast] {
        for backend in &Backend::ALL[..1] {
            for sampler in &[SamplerKind::Independent] {
                let p = etendue::scene::prepare::prepare(
                    &d,
                    AccelOptions {
                        backend: *backend,
                        precision,
                        threads: 2,
                    },
                )
                .unwrap();
                let filter = etendue::film::filter::Filter::new(&d.film.filter);
                let mut s = RenderSettings::new(d.film.size, 4);
                s.max_bounces = Some(8);
                s.sampler = *sampler;
                let r = render(&p.scene, &filter, d.film.size, &s, &Unwatched).unwrap();
                println!(
                    "{:?} {:?} {:?}: {:.3} Msamples/s, {:?} rays/sample {:.2}, mean {:?} err {:?} rej {:?}",
                    backend,
                    precision,
                    sampler,
                    4.0 * 1.048576 / r.elapsed.as_secs_f64(),
                    r.elapsed,
                    r.rays.total() as f64 / 4.0 / 1048576.0,
                    r.film.mean(),
                    r.film.error().map(|e| e.rel_rmse),
                    r.rejected
                );
                if *backend == Backend::ALL[0] {
                    let im = r.film.develop();
                    let mut out = format!("P6\n{} {}\n255\n", im.width(), im.height()).into_bytes();
                    for px in im.pixels() {
                        for c in px.to_array() {
                            out.push((c.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8);
                        }
                    }
                    std::fs::write("/tmp/c.ppm", out).unwrap();
                }
            }
        }
    }
}
