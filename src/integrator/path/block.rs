//! The state of sixteen paths, as a structure of arrays.
//!
//! Measure: normalised scene units; radiance.
//! Range: the state of effects that are absent from `E` has size zero.
//! Source: none needed. Tested in `tests/rendering/effects.rs`.

use super::super::SampleLanes;
use crate::accel::lanes::{ExcludedLanes, RayHitLanes};
use crate::effects::{EffectState, Effects, Slot};
use crate::light::types::Receiver;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store};
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::robust::offset_point;
use crate::math::vec::{Vec3, Vector};
use crate::planted::planted;
use crate::scene::ShapeTraits;
use crate::scene::interaction::Interaction;

/// Marks a path for which no light was sampled.
const NO_LIGHT: u32 = u32::MAX;

/// Sixteen paths.
#[repr(align(64))]
#[derive(Debug, Clone)]
pub struct PathBlock<E: Effects> {
    /// The lanes with a path that has not ended.
    pub active: ActiveLanes<LANES>,
    /// The indices of the paths' samples in the wavefront.
    pub sample_index: Lanes<u32>,
    /// The current rays, with their hits and times.
    pub packet: RayHitLanes<LANES>,
    /// The primitives that the rays leave.
    pub excluded: ExcludedLanes,
    /// The path throughputs: factors of the radiance along the rays.
    pub beta: Lanes3,
    /// The radiance found so far.
    pub radiance: Lanes3,
    /// The product of eta^2 over the refractions of each path. Russian roulette multiplies the throughput by it to get
    /// the survival probability: transmission divides the throughput by eta^2 on the way into glass and restores it on
    /// the way out, which is no reason to end a path.
    pub eta_scale: EffectState<E::Transmission, Lanes<f32>>,
    /// The ratios of the densities of light paths and of these paths, without that of the light path's first ray; zero
    /// on camera rays.
    light_path_ratio: EffectState<E::LightPaths, Lanes<f32>>,
    /// The lanes whose path is a caustic if it ends here: of a camera path, any surface but the first is glossy or smooth; of
    /// a light path, any but the last.
    caustic: EffectState<E::LightPaths, ActiveLanes<LANES>>,
    /// The points of the last scattering events, and their normals as receivers of light.
    prev_point: Lanes3,
    prev_normal: EffectState<E::ManyLights, Lanes3>,
    /// The BSDF densities of the current rays; infinite on camera rays and after delta lobes.
    prev_pdf: Lanes<f32>,
    /// The lights that were last chosen by light sampling.
    chosen_light: Lanes<u32>,
    /// The rays traced for each path, without those from the camera.
    closest_rays: Lanes<u32>,
    shadow_rays: Lanes<u32>,
}

impl<E: Effects> Default for PathBlock<E> {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            active: ActiveLanes::NONE,
            sample_index: [0; LANES],
            packet: RayHitLanes::default(),
            excluded: ExcludedLanes::NONE,
            beta: [zero; 3],
            radiance: [zero; 3],
            eta_scale: Slot::new(|| zero),
            light_path_ratio: Slot::new(|| zero),
            caustic: Slot::new(|| ActiveLanes::NONE),
            prev_point: [zero; 3],
            prev_normal: Slot::new(|| [zero; 3]),
            prev_pdf: zero,
            chosen_light: [NO_LIGHT; LANES],
            closest_rays: [0; LANES],
            shadow_rays: [0; LANES],
        }
    }
}

impl<E: Effects> PathBlock<E> {
    /// Begins the paths of sixteen samples, of which the first has the index `first` in the wavefront.
    pub(super) fn begin(&mut self, first: usize, samples: &SampleLanes) {
        let zero = [0.0; LANES];
        self.active = samples.active;
        self.sample_index = std::array::from_fn(|lane| (first + lane) as u32);
        self.packet.clone_from(&samples.packet);
        self.excluded = ExcludedLanes::NONE;
        self.beta = planted!(
            "begun-block-keeps-throughputs",
            self.beta,
            [[1.0; LANES]; 3]
        );
        self.radiance = [zero; 3];
        if let Some(eta_scale) = self.eta_scale.get_mut() {
            *eta_scale = [1.0; LANES];
        }
        if let Some(ratio) = self.light_path_ratio.get_mut() {
            *ratio = zero;
        }
        if let Some(caustic) = self.caustic.get_mut() {
            *caustic = ActiveLanes::NONE;
        }
        self.prev_pdf = [f32::INFINITY; LANES];
        self.chosen_light = [NO_LIGHT; LANES];
        self.closest_rays = [0; LANES];
        self.shadow_rays = [0; LANES];
    }

    /// Begins the path of this sample of the wavefront in a lane, with the camera ray of lane `from` of `samples`.
    pub(super) fn begin_lane(
        &mut self,
        lane: usize,
        sample_index: usize,
        samples: &SampleLanes,
        from: usize,
    ) {
        let (camera_ray, hit) = samples.camera_ray(from);
        self.active.set(lane, true);
        self.sample_index[lane] = sample_index as u32;
        self.packet.rays.set(lane, &camera_ray.ray);
        self.packet.rays.time[lane] = camera_ray.time;
        self.packet.set_hit(lane, hit);
        self.excluded.set(lane, None);
        let beta = planted!(
            "begun-path-keeps-a-throughput",
            load(&self.beta, lane),
            Rgb::WHITE
        );
        store(&mut self.beta, lane, beta);
        store(&mut self.radiance, lane, Rgb::BLACK);
        if let Some(eta_scale) = self.eta_scale.get_mut() {
            eta_scale[lane] = 1.0;
        }
        self.set_light_path_ratio(lane, 0.0);
        if let Some(caustic) = self.caustic.get_mut() {
            caustic.set(lane, false);
        }
        self.set_prev_vertex(lane, None);
        self.chosen_light[lane] = NO_LIGHT;
        self.closest_rays[lane] = 0;
        self.shadow_rays[lane] = 0;
    }

    /// Moves a path, without its hit, from a lane of another block into a lane.
    pub(super) fn move_from(&mut self, lane: usize, other: &mut Self, from: usize) {
        let copy = |to: &mut Lanes3, of: &Lanes3| store(to, lane, load::<[f32; 3]>(of, from));
        self.active.set(lane, true);
        other.active.set(from, false);
        self.sample_index[lane] = other.sample_index[from];
        let (to, of) = (&mut self.packet.rays, &other.packet.rays);
        copy(&mut to.origin, &of.origin);
        copy(&mut to.dir, &of.dir);
        to.t_min[lane] = of.t_min[from];
        to.t_max[lane] = of.t_max[from];
        to.time[lane] = of.time[from];
        self.excluded.set(lane, other.excluded.get(from));
        copy(&mut self.beta, &other.beta);
        copy(&mut self.radiance, &other.radiance);
        if let (Some(to), Some(of)) = (self.eta_scale.get_mut(), other.eta_scale.get()) {
            to[lane] = of[from];
        }
        if let Some(of) = other.light_path_ratio.get() {
            self.set_light_path_ratio(lane, of[from]);
        }
        if let (Some(to), Some(of)) = (self.caustic.get_mut(), other.caustic.get()) {
            to.set(lane, of.has(from));
        }
        copy(&mut self.prev_point, &other.prev_point);
        if let (Some(to), Some(of)) = (self.prev_normal.get_mut(), other.prev_normal.get()) {
            copy(to, of);
        }
        self.prev_pdf[lane] = other.prev_pdf[from];
        self.chosen_light[lane] = other.chosen_light[from];
        self.closest_rays[lane] = other.closest_rays[from];
        self.shadow_rays[lane] = other.shadow_rays[from];
    }

    /// Ends the path of a lane: stores its estimate in its sample.
    #[inline]
    pub fn finish_path(&mut self, lane: usize, samples: &mut [SampleLanes]) {
        let sample = self.sample_index[lane] as usize;
        samples[sample / LANES].set_estimate(
            sample % LANES,
            load(&self.radiance, lane),
            self.closest_rays[lane],
            self.shadow_rays[lane],
        );
    }

    /// Adds to the radiance of a path.
    #[inline(always)]
    pub fn add(&mut self, lane: usize, contribution: Rgb) {
        let radiance: Rgb = load(&self.radiance, lane);
        store(&mut self.radiance, lane, radiance + contribution);
    }

    /// The last scattering event as a receiver of light, and the density of its direction.
    #[inline(always)]
    pub fn prev_vertex(&self, lane: usize) -> Option<(Receiver, PdfSolidAngle)> {
        let pdf = self.prev_pdf[lane];
        (pdf < f32::INFINITY).then(|| {
            let normal = self.prev_normal.get();
            let receiver = Receiver {
                p: load(&self.prev_point, lane),
                normal: normal.map_or(Vec3::ZERO, |normal| load(normal, lane)),
            };
            (receiver, PdfSolidAngle(pdf))
        })
    }

    /// Sets the last scattering event as a receiver of light, and the density of its direction.
    #[inline(always)]
    pub fn set_prev_vertex(&mut self, lane: usize, vertex: Option<(Receiver, PdfSolidAngle)>) {
        let camera = (Receiver::default(), PdfSolidAngle(f32::INFINITY));
        let (receiver, pdf) = vertex.unwrap_or(camera);
        store(&mut self.prev_point, lane, receiver.p);
        self.set_prev_normal(lane, receiver.normal);
        self.prev_pdf[lane] = pdf.0;
    }

    /// Sets the normal of the last scattering event as a receiver of light.
    #[inline(always)]
    pub fn set_prev_normal(&mut self, lane: usize, normal: impl Into<[f32; 3]>) {
        if let Some(to) = self.prev_normal.get_mut() {
            store(to, lane, normal);
        }
    }

    /// The densities of light paths over those of the paths, if the kernel has light paths.
    #[inline(always)]
    pub fn light_path_ratio(&self) -> Option<&Lanes<f32>> {
        self.light_path_ratio.get()
    }

    /// The densities of light paths over those of the paths, to be changed in their place.
    #[inline(always)]
    pub fn light_path_ratio_mut(&mut self) -> Option<&mut Lanes<f32>> {
        self.light_path_ratio.get_mut()
    }

    /// Sets the density of a light path over that of the path of a lane.
    #[inline(always)]
    pub fn set_light_path_ratio(&mut self, lane: usize, ratio: f32) {
        if let Some(to) = self.light_path_ratio.get_mut() {
            to[lane] = ratio;
        }
    }

    /// Whether the path of a lane is a caustic if it ends here.
    #[inline(always)]
    pub fn is_caustic(&self, lane: usize) -> bool {
        self.caustic.get().is_some_and(|caustic| caustic.has(lane))
    }

    /// Marks the paths as caustics whose current surface is glossy or smooth, by the traits of the surfaces.
    #[inline(always)]
    pub fn meet_surfaces(&mut self, traits: &Lanes<u32>) {
        if let Some(caustic) = self.caustic.get_mut() {
            for (lane, traits) in traits.iter().enumerate() {
                let is_glossy = traits & ShapeTraits::GLOSSY != 0;
                caustic.0[lane] |= if is_glossy { -1 } else { 0 };
            }
        }
    }

    /// The light that light sampling last chose, if any.
    #[inline(always)]
    pub fn chosen_light(&self, lane: usize) -> Option<u32> {
        let light = self.chosen_light[lane];
        (light != NO_LIGHT).then_some(light)
    }

    /// Sets the lights that light sampling chose in these lanes.
    #[inline(always)]
    pub fn set_chosen_lights(&mut self, lanes: &ActiveLanes<LANES>, lights: &Lanes<u32>) {
        for (lane, (chosen, light)) in self.chosen_light.iter_mut().zip(lights).enumerate() {
            *chosen = if lanes.has(lane) { *light } else { *chosen };
        }
    }

    /// Adds contributions of light sampling, times the visible shares of the lights, in these lanes.
    #[inline(always)]
    pub fn add_visible(
        &mut self,
        lanes: &ActiveLanes<LANES>,
        contribution: &Lanes3,
        visible: &Lanes<f32>,
    ) {
        for (radiance, contribution) in self.radiance.iter_mut().zip(contribution) {
            for lane in 0..LANES {
                let kept = radiance[lane];
                let sum = kept + contribution[lane] * visible[lane];
                let adds = lanes.has(lane) & (visible[lane] > 0.0);
                radiance[lane] = if adds { sum } else { kept };
            }
        }
    }

    /// Sets the extension ray of a lane along `wi`, with the excluded primitive, which for flat shapes needs no distance,
    /// and the density of `wi`, infinite for a delta lobe. Free of branches.
    #[inline(always)]
    pub fn spawn_extension_ray<V: Vector>(
        &mut self,
        lane: usize,
        at: &Interaction<E, V>,
        wi: V,
        pdf: f32,
        through: bool,
    ) {
        let origin = offset_point(at.p, at.error, at.exit_normal(through));
        self.packet.rays.set(lane, &Ray::new(origin, wi));
        self.excluded.shape[lane] = at.id.shape;
        self.excluded.primitive[lane] = at.id.primitive;
        self.excluded.free_distance[lane] = f32::INFINITY;
        if planted!(
            "mirror-weighted-as-what-it-shows",
            pdf < f32::INFINITY,
            true
        ) {
            store(&mut self.prev_point, lane, at.p);
            self.prev_pdf[lane] = pdf;
        }
    }

    /// Counts several shadow rays of a lane.
    #[inline(always)]
    pub fn count_shadow_rays(&mut self, lane: usize, count: u32) {
        self.shadow_rays[lane] += count;
    }

    /// Counts an extension ray or a shadow ray of a lane.
    #[inline(always)]
    pub fn count_rays(&mut self, lane: usize, closest: bool, shadow: bool) {
        self.closest_rays[lane] += u32::from(closest);
        self.shadow_rays[lane] += u32::from(shadow);
    }
}
