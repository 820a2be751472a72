//! The scattering of light that arrives along light paths towards given directions, in lanes.
//!
//! Measure: BSDFs with the factors of light paths; densities per steradian.
//! Range: any surfaces. Delta lobes are left out.
//! Source: Veach 1997, section 5.3. Tested in `tests/rendering/light_paths.rs`.

use super::super::super::bidirectional::vertex::{Densities, SubpathVertex, adjoint};
use super::super::light_path_weights::tilted_lanes;
use super::super::scattering::replace;
use super::super::shading::{BsdfLanes, PrincipledStage};
use crate::effects::{Effects, Slot};
use crate::light::types::Receiver;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::LaneVec3;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

/// Light at the surfaces of a block that scatters towards the camera.
pub(super) struct TowardsCamera {
    /// The lanes with such light.
    pub active: ActiveLanes<LANES>,
    /// The BSDFs with the factors of light paths: the cosine, and the adjoint of shading normals.
    pub factor: Lanes3,
    /// The densities with which camera paths continue towards the light.
    pub pdf_to_light: Lanes<f32>,
    /// The lanes where the light goes through the surface.
    pub is_transmitted: ActiveLanes<LANES>,
    /// The receivers as seen from the camera, in the lanes that are computed one by one.
    pub receivers: Lanes<Option<Receiver>>,
}

/// The subpath vertex of a lane, for scalar code.
pub(super) fn vertex<'a, E: Effects>(
    scene: &'a Scene,
    at: &InteractionLanes<E>,
    lane: usize,
) -> SubpathVertex<'a, E> {
    let at: Interaction<E> = at.get(lane);
    SubpathVertex::new(scene, at, Rgb::WHITE, Densities::default(), [0.0; 4])
}

/// Evaluates the scattering of the light that arrives along the rays of some lanes towards the camera along the unit vectors
/// `w`, without delta lobes. `is_sampled` is whether these are the directions that were sampled last, at which the principled
/// BSDFs have been evaluated.
pub(super) fn towards_camera<E: Effects>(
    scene: &Scene,
    lanes: &ActiveLanes<LANES>,
    at: &InteractionLanes<E>,
    bsdfs: &mut BsdfLanes<E>,
    w: &Lanes3,
    is_sampled: bool,
) -> TowardsCamera {
    let mut towards = TowardsCamera {
        active: *lanes,
        factor: [[0.0; LANES]; 3],
        pdf_to_light: [0.0; LANES],
        is_transmitted: ActiveLanes::NONE,
        receivers: [None; LANES],
    };
    let (mut to_camera, mut to_light) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    diffuse::<E>(at, bsdfs, w, &mut to_camera, &mut to_light, &mut towards);
    if let Some(stage) = bsdfs.principled.get_mut()
        && stage.active.any()
    {
        // The BSDFs are bound to the direction to the light, and reciprocal.
        let PrincipledStage {
            active,
            bsdfs,
            f,
            pdf,
            reverse_pdf_of_bsdf_sample: pdf_to_light,
            ..
        } = stage;
        if !is_sampled {
            bsdfs.eval_both_ways(&to_camera, f, pdf, pdf_to_light);
        }
        for (to, of) in towards.factor.iter_mut().zip(&*f) {
            replace(active, to, of);
        }
        replace(active, &mut towards.pdf_to_light, pdf_to_light);
    }
    multiply_by_adjoint::<E>(at, w, &to_light, &mut towards);
    let tilted = tilted_lanes::<E>(at, w, lanes);
    let one_by_one = lanes.and(|lane| bsdfs.scalar_lanes.has(lane) || tilted.has(lane));
    for lane in one_by_one.each() {
        let vertex = vertex(scene, at, lane);
        let w = load(w, lane);
        let scattering = vertex.scattering(scene, w, vertex.at.wo);
        towards.active.set(lane, scattering.is_some());
        if let Some(scattering) = scattering {
            store(
                &mut towards.factor,
                lane,
                scattering.to_camera * scattering.adjoint,
            );
            towards.pdf_to_light[lane] = scattering.pdf_to_light.0;
            towards.is_transmitted.set(lane, scattering.is_transmitted);
            let seen = vertex.at.with_wo(w, vertex.transmits);
            towards.receivers[lane] = Some(seen.receiver(vertex.transmits));
        }
    }
    towards
}

vectorised! {
    /// The values of diffuse surfaces and their densities, and the directions to both ends in the shading frames.
    fn diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
        w: &Lanes3,
        to_camera: &mut Lanes3,
        to_light: &mut Lanes3,
        towards: &mut TowardsCamera,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let to_camera_local = at.frame.to_local(load::<LaneVec3>(w, lane));
            let light = at.frame.to_local(at.wo);
            let value = bsdfs.diffuse_bsdf(lane).eval(to_camera_local, light);
            store(to_camera, lane, to_camera_local);
            store(to_light, lane, light);
            store(&mut towards.factor, lane, value.f);
            towards.pdf_to_light[lane] = value.pdf.0;
        }
    }
}

vectorised! {
    /// Multiplies the values of opaque surfaces by the factors of light paths, and marks those that are lit.
    fn multiply_by_adjoint<E: Effects>(
        at: &InteractionLanes<E>,
        w: &Lanes3,
        to_light: &Lanes3,
        towards: &mut TowardsCamera,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let along: LaneVec3 = load(w, lane);
            let f: Rgb<LaneVec3> = load(&towards.factor, lane);
            let light: LaneVec3 = load(to_light, lane);
            let cos = light.z.abs();
            let factor = f * (cos * adjoint(&at, along, at.wo));
            let is_lit = towards.active.has(lane) & at.is_consistent_side(along, false) & !factor.is_black();
            store(&mut towards.factor, lane, factor);
            towards.active.set(lane, is_lit);
        }
    }
}
