//! The settings of a render that the flags of `render` and `plan` share: the integrator, the sampler, and the image.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs` and `cli/tests/command/plan.rs`.

use super::values::{
    named, parse_bounces, parse_distance, parse_filter, parse_roulette, parse_size, parse_small,
};
use clap::Args;
use etendue::internals::film::filter::{FilterDescription, FilterSampling};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::light::types::LightChoice;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{
    BounceLimit, LightPathRule, PathReuseRule, SamplerKind,
};
use etendue::internals::scene::description::SceneDescription;

/// The settings of a render.
#[derive(Debug, Args)]
pub struct SettingsArguments {
    /// Integrator. Default: the scene's, or path.
    ///
    /// Path tracers, from the simplest to the best: naive (at each surface, a random choice between its emission, which
    /// ends the path, and a uniform direction), emit-or-reflect (a better choice probability), bsdf (no such choice;
    /// directions sampled from the BSDF), light-or-rest (a ray to one light, a uniform ray for all other light), nee
    /// (next event estimation), path (next event estimation with multiple importance sampling). bdpt: bidirectional
    /// path tracing, for caustics and hidden lamps. mlt: Metropolis light transport over bdpt. irradiance-cache: path
    /// with the indirect light of matte surfaces interpolated from few points, biased within --cache-error.
    /// direct-directional, direct-area: direct light only, by uniform directions or by uniform points on lights.
    /// ambient-occlusion: ambient occlusion only. auto: path, bdpt or mlt, chosen by a small pilot and printed with the
    /// reason; see `etendue plan`.
    #[arg(long, value_parser = named(IntegratorKind::ALL, IntegratorKind::name))]
    pub integrator: Option<IntegratorKind>,
    /// Sampler of the random numbers. Default: the scene's, or sobol.
    #[arg(long, value_parser = named(SamplerKind::ALL, SamplerKind::name))]
    pub sampler: Option<SamplerKind>,
    /// Maximum number of scattering events: 0 shows emitters only, 1 is direct light. Biased, except for none: no limit.
    /// Default: the scene's, or none.
    #[arg(long, value_name = "N|none", value_parser = parse_bounces)]
    pub max_bounces: Option<BounceLimit>,
    /// Russian roulette. Affects noise and time, not the mean. Default: the scene's, or the integrator's.
    ///
    /// none: never. albedo: by what the last surface reflected. throughput: by the path throughput. window=1/N: by the
    /// path throughput times N, so that paths are longer; N is 2 unless given. The default is window for irradiance-cache
    /// and for path, there with N = 4 where a pilot counts at most 15 % more rays; none for naive, which ends paths itself,
    /// and for those that scatter at most once; else throughput.
    #[arg(long, value_name = "none|albedo|throughput|window[=1/N]", value_parser = parse_roulette)]
    pub roulette: Option<Roulette>,
    /// Light paths beside the camera paths of the integrator path. Affects noise and time, not the mean. Default: the
    /// scene's, or auto.
    ///
    /// They find caustics of glass and metal, also those of point lights. off: none. 1/4, 1/2, 1, 2: this number for each
    /// camera path. caustics:1/4 and so on: connected to the lens beyond glossy and smooth surfaces only, which takes less
    /// time. auto: caustics:1/4, or 1/4 where the others pay as well, if a pilot shows that camera paths alone have more than
    /// 1.2 times the squared error; else off. Off with --roulette none.
    #[arg(long, value_parser = named(LightPathRule::ALL, LightPathRule::name))]
    pub light_paths: Option<LightPathRule>,
    /// Number of neighbouring pixels that share the paths of the integrator path. Affects noise and time, not the mean.
    /// Default: the scene's, or auto.
    ///
    /// Indirect light that one path finds is taken by a group of 4 or 16 pixels, where matte and rough surfaces see each
    /// other. The noise of these pixels is not independent. off: none. auto: the number with the least error in a pilot, if that pays;
    /// off with layers, adaptive sampling, light paths and --roulette none. With a number, --light-paths auto has none.
    #[arg(long, value_parser = named(PathReuseRule::ALL, PathReuseRule::name))]
    pub reuse: Option<PathReuseRule>,
    /// Selection of the light that is sampled, where there are several. Affects noise and time, not the mean. Default:
    /// contribution, but power for light-or-rest, nee and direct-area.
    ///
    /// contribution: in proportion to an estimate of what each light would contribute at the surface if nothing occluded
    /// it, from a tree of lights if there are more than 16. power: in proportion to power, everywhere alike.
    #[arg(long, value_parser = named(LightChoice::ALL, LightChoice::name))]
    pub light_choice: Option<LightChoice>,
    /// Reconstruction filter, with its radius in pixels if not the default: box (0.5), tent (1), gaussian (1.5), mitchell (2),
    /// blackman-harris (1.5). Default: the scene's, or gaussian.
    #[arg(long, value_name = "NAME[:RADIUS]", value_parser = parse_filter)]
    pub filter: Option<FilterDescription>,
    /// Estimator of the filter. Affects noise and time, not the mean.
    ///
    /// splatting: a sample contributes to every pixel that its filter covers; the noise of neighbouring pixels is correlated.
    /// importance: a sample belongs to one pixel, and its position is sampled from the filter. Box filters, radii above 4.5
    /// pixels, adaptive renders and mlt have importance sampling alone. Default: splatting; with --layers and --denoise
    /// importance, since what reads layers takes the noise of pixels as independent.
    #[arg(long, value_parser = named(FilterSampling::ALL, FilterSampling::name))]
    pub filter_sampling: Option<FilterSampling>,
    /// Maximum distance of occluders for ambient-occlusion, in scene units. Default: the scene's, or no limit.
    #[arg(long, value_name = "DISTANCE", value_parser = parse_distance)]
    pub occlusion_distance: Option<f64>,
    /// Maximum relative error of the indirect light of irradiance-cache, such as 5% or 0.05; 0 caches nothing. Default:
    /// the scene's, or 5%.
    #[arg(long, value_name = "SHARE", value_parser = parse_small)]
    pub cache_error: Option<f64>,
    /// Image size in pixels. Default: the scene's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
}

impl SettingsArguments {
    /// Replaces the settings that a scene itself has.
    pub fn apply_to(&self, scene: &mut SceneDescription) {
        if let Some(size) = self.size {
            scene.film.size = size;
        }
        if let Some(filter) = self.filter {
            scene.film.filter = filter;
        }
    }

    /// The other settings, as render options.
    pub fn options(&self) -> RenderOptions {
        let mut options = RenderOptions::default();
        options.integrator = self.integrator;
        options.sampler = self.sampler;
        options.max_bounces = self.max_bounces;
        options.roulette = self.roulette;
        options.light_paths = self.light_paths;
        options.reuse = self.reuse;
        options.light_choice = self.light_choice;
        options.filter_sampling = self.filter_sampling;
        options.occlusion_distance = self.occlusion_distance;
        options.cache_error = self.cache_error;
        options
    }
}
