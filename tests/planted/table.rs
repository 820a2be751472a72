//! The table of planted bugs: what is wrong with each, and the test that has to find it.
//!
//! Measure: none.
//! Range: every `planted!` in the sources, each once; `main.rs` makes sure of it.
//! Source: DeMillo, Lipton and Sayward 1978, "Hints on Test Data Selection".

/// A planted bug.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planted {
    /// Its name, there and in `ETENDUE_MUTANT`.
    pub name: &'static str,
    /// A description of the bug.
    pub wrong: &'static str,
    /// The test that finds it: the target, `lib` for the renderer's own tests, and the name in it.
    pub killer: &'static str,
}

const fn bug(name: &'static str, wrong: &'static str, killer: &'static str) -> Planted {
    Planted {
        name,
        wrong,
        killer,
    }
}

/// All of them, from floor to floor.
pub const PLANTED: &[Planted] = &[
    bug(
        "area-pdf-without-cosine",
        "a density per area becomes one per steradian without the light's cosine",
        "lights::light::mean_inverse_pdf_equals_the_solid_angle",
    ),
    bug(
        "origin-not-offset",
        "rays start on the surface, not beyond the bound of its error",
        "lib::math::robust::tests::offset_point_clears_its_error_bound_on_the_given_side",
    ),
    bug(
        "offset-rounds-back",
        "a ray's start may be rounded back towards the surface",
        "lib::math::robust::tests::offset_point_clears_its_error_bound_on_the_given_side",
    ),
    bug(
        "edges-open",
        "a line exactly through an edge or a vertex misses both of its triangles",
        "lib::math::triangle::tests::intersection_is_watertight_in_a_triangle_fan",
    ),
    bug(
        "begin-before",
        "a ray begins after a hit although it began later before, so that it meets the hit again and again",
        "lib::math::ray::tests::ray_begins_later_after_every_hit",
    ),
    bug(
        "shadow-ray-cut-short",
        "shadow rays end a thousandth before the light",
        "tracing::rays::shadow_rays_hit_near_occluders_but_not_the_light_itself",
    ),
    bug(
        "points-exact",
        "shadow rays to a point light end where it is, as if a surface through it were not rounded",
        "tracing::rays::surface_through_a_point_light_does_not_occlude_it",
    ),
    bug(
        "balance-heuristic",
        "weights are of the first power of the densities instead of the second",
        "lib::sampling::mis::tests::power_heuristic_has_exponent_two",
    ),
    bug(
        "cone-pdf-off-by-two",
        "the density in a cone is half of what it is",
        "sampling::warps::cone_disk_and_triangle_sampling_is_uniform",
    ),
    bug(
        "alias-off-by-one",
        "an alias is the item before the one that gave its share",
        "lib::sampling::distribution::tests::alias_table_probabilities_are_proportional_to_weights",
    ),
    bug(
        "shuffle-in-one-cycle",
        "the shuffle of Latin hypercubes leaves nothing in its place",
        "course::integration::latin_hypercube_pairings_are_equally_likely",
    ),
    bug(
        "light-and-bsdf-share-numbers",
        "the point on a light and the scattered direction take the same numbers",
        "lib::sampler::tests::decisions_use_disjoint_random_number_slots",
    ),
    bug(
        "one-is-drawn",
        "a uniform number may be rounded to 1",
        "lib::sampler::tests::largest_uniform_number_is_one_minus_epsilon",
    ),
    bug(
        "sobol-order-shared",
        "all decisions of a sample take the same place in Sobol's sequence",
        "sampling::sampler::sobol_decisions_are_shuffled_independently",
    ),
    bug(
        "lanes-share-a-sampler",
        "samplers that draw side by side all draw what the first of them does",
        "sampling::sampler::sampler_draws_in_lanes_are_identical_to_scalar_draws",
    ),
    bug(
        "strata-shared-by-decisions",
        "all decisions of a sample lie in the same stratum",
        "sampling::stratified::decisions_and_neighbouring_pixels_are_uncorrelated",
    ),
    bug(
        "half-a-texel",
        "texels have their value at a corner instead of their centre",
        "lib::geometry::texture::tests::texel_centre_lookup_returns_the_texel_with_v_up",
    ),
    bug(
        "normals-by-the-matrix",
        "an instance's normals are transformed as its directions are",
        "tracing::instance_surfaces::instanced_triangle_surface_matches_the_world_space_triangle",
    ),
    bug(
        "slivers-as-others",
        "the error bound of a sliver's points leaves out what rounding does to its normal",
        "tracing::slivers::robust_shadow_rays_do_not_self_intersect_slivers",
    ),
    bug(
        "normals-of-exchanged-corners",
        "shading normals are interpolated with two corners exchanged",
        "lib::geometry::mesh::tests::interpolation_at_corners_returns_vertex_normals_and_uvs",
    ),
    bug(
        "one-percent-of-albedo",
        "matte surfaces reflect one percent less along a path",
        "scattering::furnace::white_diffuse_and_mirror_have_unit_albedo",
    ),
    bug(
        "half-vector-jacobian",
        "a mirrored direction has the density of its half vector",
        "scattering::bsdf::bsdf_samples_pass_chi_square_tests_against_the_pdf",
    ),
    bug(
        "shadowing-uncorrelated",
        "masking and shadowing are multiplied as if they were independent",
        "scattering::furnace::energy_compensated_white_metal_has_unit_albedo",
    ),
    bug(
        "refraction-jacobian",
        "the half vector of refraction has the index of the wrong side in its Jacobian",
        "scattering::bsdf::bsdf_samples_pass_chi_square_tests_against_the_pdf",
    ),
    bug(
        "eta-squared-forgotten",
        "refracted radiance is not scaled by the square of the index",
        "scattering::furnace::smooth_glass_has_unit_albedo",
    ),
    bug(
        "pane-of-one-side",
        "a thin pane reflects as one of its sides does",
        "scattering::furnace::thin_dielectric_reflectance_matches_closed_form",
    ),
    bug(
        "facets-met-but-once",
        "light between a metal's facets is coloured by one meeting too few",
        "lib::bsdf::conductor::tests::multiple_scattering_colour_matches_the_geometric_series",
    ),
    bug(
        "lobe-left-out-of-pdf",
        "the principled density leaves out the lobe of light between facets",
        "scattering::bsdf::bsdf_samples_pass_chi_square_tests_against_the_pdf",
    ),
    bug(
        "coat-of-one-direction",
        "a clear coat takes from its base what it reflects towards the viewer, whatever it takes from the incident light",
        "scattering::bsdf::bsdfs_are_reciprocal",
    ),
    bug(
        "light-bound-without-size",
        "the cosine at a receiver is that of the centre of a light's bounds, and lights half below the horizon are left out",
        "lights::choice::contributing_lights_have_positive_selection_probability",
    ),
    bug(
        "compensated-alone",
        "light sampling without a weight leaves out what is darker than the mean of an environment map",
        "lib::render::settings::rules::tests::mis_compensation_is_used_by_the_path_integrator_only",
    ),
    bug(
        "choice-left-out-of-pdf",
        "the density of a light met by chance leaves out the choice of the light",
        "lights::light::lights_are_chosen_by_power",
    ),
    bug(
        "cone-cancels",
        "one minus the cosine of a small sphere's cone is subtracted in single precision",
        "lights::light::sphere_cone_solid_angle_is_accurate_for_small_spheres",
    ),
    bug(
        "unmirrored-wrap",
        "mirrored images do not turn back at their edge",
        "lib::geometry::uv_map::tests::wrap_modes_mirror_and_clamp_between_texel_centres",
    ),
    bug(
        "environment-half-a-texel",
        "directions to an environment are half a texel off",
        "lights::environment::environment_map_samples_match_their_pdf",
    ),
    bug(
        "focus-on-a-sphere",
        "what is in focus has the same distance instead of the same depth",
        "lib::camera::tests::thin_lens_rays_converge_in_the_plane_of_focus",
    ),
    bug(
        "excluded-primitive-ignored",
        "a primitive just left counts even where it cannot truly be met",
        "tracing::rays::excluded_primitive_is_skipped_up_to_its_free_distance",
    ),
    bug(
        "distant-hits-accepted",
        "hits of packets far from their triangles are not recomputed",
        "lib::accel::embree::check::tests::only_hits_that_may_be_wrong_are_confirmed_one_by_one",
    ),
    bug(
        "shadow-rays-together",
        "shadow rays go through Embree's packets as they are, which take the first steps down the tree together",
        "tracing::packets::packet_hits_are_independent_of_other_lanes",
    ),
    bug(
        "box-without-slack",
        "the test of boxes does not allow for its rounding",
        "tracing::rays::robust_tracing_is_watertight_at_closed_mesh_edges",
    ),
    bug(
        "denominator-of-the-same-half",
        "the stated error divides the noise of a half by the light of the same half",
        "lib::film::error::tests::error_estimate_and_bound_hold_with_rare_bright_samples",
    ),
    bug(
        "denominator-with-its-own-noise",
        "the stated error adds a pixel's own noise to its denominator, so that a bright sample hides its error",
        "lib::film::error::tests::error_estimate_and_bound_hold_with_rare_bright_samples",
    ),
    bug(
        "noise-of-edges-counts",
        "the stated error adds the noise of a lamp's edge to the denominators of the dark pixels beside",
        "lib::film::error::tests::noise_of_emitter_edges_does_not_hide_that_of_dark_neighbours",
    ),
    bug(
        "variance-of-a-pixel-known",
        "the bound of the error takes the variance of the pixel with the largest error as known",
        "lib::film::error::tests::bound_holds_where_one_pixel_has_much_of_the_error",
    ),
    bug(
        "moderation-forgets-its-freedom",
        "error bars take a variance told by few numbers as known",
        "lib::film::error_bars::tests::interval_coverage_is_nominal_for_equal_and_unequal_variances",
    ),
    bug(
        "flags-by-the-pixel-itself",
        "whether to trust a pixel's error bar is decided by its own samples",
        "lib::film::error_bars::tests::pixel_flag_depends_on_neighbours_not_on_own_samples",
    ),
    bug(
        "film-in-single-precision",
        "a pixel's sum is rounded to single precision",
        "lib::film::pixel::tests::mean_stays_accurate_over_many_equal_samples",
    ),
    bug(
        "alpha-number-reused",
        "the number that passed one veil decides about the next one as well",
        "scattering::materials::alpha_sphere_attenuates_twice_and_emits_once",
    ),
    bug(
        "sides-unchecked",
        "a shading normal may reflect light to below the surface",
        "scattering::shading_normals::opaque_materials_leak_no_light_with_bent_shading_normals",
    ),
    bug(
        "long-rays-exact",
        "a shadow ray's end is bounded as if the ray had no length",
        "tracing::rays::long_shadow_rays_do_not_hit_their_target_light",
    ),
    bug(
        "rounded-before-centred",
        "points are rounded before the scene is moved to the origin",
        "lib::scene::normalisation::tests::scene_far_from_the_origin_keeps_its_precision",
    ),
    bug(
        "the-longer-way-round",
        "what turns between two keys turns the other way round",
        "lib::scene::keyframes::tests::rotation_is_interpolated_at_constant_angular_velocity",
    ),
    bug(
        "pbrt-world-not-mirrored",
        "the left-handed world of a pbrt file is taken as right-handed",
        "loading::pbrt::worlds::point_and_distant_lights_are_placed_in_mirrored_world",
    ),
    bug(
        "octahedron-not-folded",
        "the lower hemisphere of an octahedral map is not mirrored at the equator",
        "lib::scene::load::pbrt::environment::tests::square_to_sphere_mapping_inverts_and_has_uniform_moments",
    ),
    bug(
        "intensity-in-world-units",
        "a point light's intensity ignores the unit of length",
        "lib::scene::prepare::tests::point_light_sample_is_invariant_to_scene_scale",
    ),
    bug(
        "roulette-on-radiance",
        "what survives roulette has its radiance divided by the probability, not its throughput",
        "rendering::roulette::russian_roulette_is_unbiased_on_a_glossy_highlight",
    ),
    bug(
        "roulette-takes-a-spent-number",
        "roulette takes a number that has chosen the direction",
        "rendering::roulette::russian_roulette_is_unbiased_on_a_glossy_highlight",
    ),
    bug(
        "window-without-its-weight",
        "what survives roulette by a weight window has the weight of a window of 1",
        "lib::integrator::roulette::tests::weight_window_preserves_expected_throughput",
    ),
    bug(
        "roulette-without-division",
        "what survives roulette is not divided by its probability",
        "rendering::roulette::russian_roulette_is_unbiased_on_a_glossy_highlight",
    ),
    bug(
        "begun-path-keeps-a-throughput",
        "a path that begins in a lane keeps the throughput of the path before",
        "lights::lamps::large_area_light_render_matches_its_form_factor",
    ),
    bug(
        "begun-block-keeps-throughputs",
        "the paths that begin a block together keep the throughputs of the paths before",
        "rendering::adaptive::pixels_equal_the_mean_of_their_replayed_samples",
    ),
    bug(
        "reflectance-of-the-next-lane",
        "a path is reflected by the diffuse surface of its neighbour in the block",
        "rendering::adaptive::pixels_equal_the_mean_of_their_replayed_samples",
    ),
    bug(
        "ended-paths-sample-lights",
        "next event estimation ignores the mask of active lanes",
        "rendering::adaptive::pixels_equal_the_mean_of_their_replayed_samples",
    ),
    bug(
        "light-without-cosine",
        "light sampling leaves out the cosine at the surface",
        "lights::lamps::large_area_light_render_matches_its_form_factor",
    ),
    bug(
        "shadows-as-the-shutter-opens",
        "shadow rays are traced at the time when the shutter opens",
        "rendering::motion::moving_shadows_average_over_time",
    ),
    bug(
        "mirror-weighted-as-what-it-shows",
        "light seen in a mirror is weighted as if seen from where the mirror was",
        "lights::lamps::light_reflected_by_mirror_matches_its_virtual_image",
    ),
    bug(
        "heuristics-mixed",
        "light sampling is weighted by the balance heuristic, scattering by the power heuristic",
        "lights::lamps::large_area_light_render_matches_its_form_factor",
    ),
    bug(
        "filter-weight-dropped",
        "a filter's negative lobes count as positive",
        "rendering::pixels::pixel_values_at_an_edge_match_the_filter_integral",
    ),
    bug(
        "half-a-pixel",
        "pixels have their centre at their corner",
        "rendering::pixels::pixel_values_at_an_edge_match_the_filter_integral",
    ),
    bug(
        "passes-repeat-samples",
        "each pass takes the same samples again",
        "rendering::adaptive::pixels_equal_the_mean_of_their_replayed_samples",
    ),
    bug(
        "samples-cost-alike",
        "samples are given out as if all of them took as many rays",
        "rendering::adaptive_pixels::allocation_follows_the_inverse_square_root_of_cost",
    ),
    bug(
        "adaptive-light-paths-uncounted",
        "light paths of adaptive samples contribute, but are not counted",
        "rendering::light_paths::adaptive_light_paths_agree_with_path",
    ),
    bug(
        "pixels-ask-their-own-pilot",
        "a pixel's own pilot decides how many samples it gets",
        "rendering::adaptive_pixels::two_phase_sampling_is_unbiased_for_rare_events",
    ),
    bug(
        "neighbours-of-either-colour-tell",
        "pixels decide about neighbours that decide about them",
        "rendering::adaptive_pixels::sample_counts_ignore_pilots_of_the_same_checker_colour",
    ),
    bug(
        "denoise-ignores-variance",
        "the noise filter measures differences by the colours, not by their noise",
        "rendering::denoise::denoising_bias_vanishes_with_the_noise",
    ),
    bug(
        "denoise-own-weights",
        "a half of the image is filtered by weights of its own",
        "rendering::denoise::denoising_preserves_the_mean_of_uniform_and_firefly_noise",
    ),
    bug(
        "both-sides-at-once",
        "a lamp that shines on both sides sends out as many rays on each as one with a single side",
        "lights::emission::mean_power_of_emission_samples_equals_light_power",
    ),
    bug(
        "film-without-tilt",
        "a steradian falls on as much film at the edge of the image as in the middle",
        "lib::camera::tests::film_area_per_steradian_matches_finite_differences",
    ),
    bug(
        "sums-lose-digits",
        "samples and splats are summed up in double precision alone",
        "lib::math::exact_sum::tests::exact_sums_are_independent_of_order_and_grouping",
    ),
    bug(
        "splats-half-a-pixel-off",
        "a splat is weighed by the filter about a pixel's corner",
        "lib::film::splats::tests::box_filter_splats_to_the_containing_pixel",
    ),
    bug(
        "a-weight-is-missing",
        "a strategy's weight leaves others out that find the same path",
        "lib::integrator::bidirectional::weights::tests::mis_weights_match_the_power_heuristic_and_sum_to_one",
    ),
    bug(
        "shading-normals-both-ways-alike",
        "power is scattered about shading normals as radiance is",
        "rendering::bidirectional::bdpt_adjoint_scattering_by_shading_normals_matches_path",
    ),
    bug(
        "light-thinned-as-radiance",
        "power is thinned on its way into glass as radiance is",
        "rendering::bidirectional::bdpt_agrees_with_path_on_a_wall_inside_glass",
    ),
    bug(
        "splats-without-film",
        "light that comes to the lens is not that of a pixel's solid angle",
        "rendering::bidirectional::bdpt_agrees_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "reuse-without-visibility",
        "pixels that cannot see a surface are counted among those that find it",
        "rendering::reuse::path_reuse_agrees_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "reuse-without-cosine",
        "the densities of shared surfaces become those per area without their cosines",
        "rendering::reuse::path_reuse_agrees_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "reuse-judged-at-one-pixel",
        "all pixels of a packet share if the first one sees a matte surface",
        "rendering::reuse::path_reuse_agrees_with_path_in_partly_shareable_blocks",
    ),
    bug(
        "reuse-counts-black-pixels",
        "pixels that see a black surface, on which paths end, are counted among those that find a surface",
        "rendering::reuse::path_reuse_agrees_with_path_in_partly_shareable_blocks",
    ),
    bug(
        "reuse-rough-seen-alike",
        "a rough second surface reflects the radiance to all pixels that it reflects to one",
        "rendering::reuse::path_reuse_agrees_with_path_between_rough_surfaces",
    ),
    bug(
        "reuse-ignores-tilt",
        "pixels for which a shading normal has to be tilted share with those for which it has not",
        "rendering::reuse::path_reuse_agrees_with_path_with_shading_normals",
    ),
    bug(
        "light-paths-without-importance",
        "a light path that comes to the lens is not divided by the solid angle of a pixel",
        "rendering::light_paths::light_paths_agree_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "light-paths-thinned-as-radiance",
        "light paths are refracted by the factor of radiance, without eta squared",
        "rendering::light_paths::light_paths_agree_with_path_on_a_wall_inside_glass",
    ),
    bug(
        "light-paths-counted-per-pixel",
        "camera paths are weighed as if all light paths were their own pixel's",
        "rendering::light_paths::light_paths_agree_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "caustic-targets-left-out-of-weight",
        "camera paths are weighed as if light paths were not sampled towards caustic targets",
        "rendering::light_paths::light_paths_agree_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "first-surface-makes-a-caustic",
        "camera paths leave to light paths what these do not find: what a glossy first surface reflects",
        "rendering::light_paths::light_paths_agree_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "new-lens-left-out",
        "a camera that replaces another calls for no effects of its own",
        "rendering::session::changing_the_camera_rebuilds_nothing_and_renders_correctly",
    ),
    bug(
        "lamps-stay-behind",
        "lamps of a group that is placed anew are sampled where they were",
        "rendering::session::moving_an_instance_rebuilds_no_group_and_renders_correctly",
    ),
    bug(
        "changes-unnoticed",
        "a render goes on after its scene has changed",
        "rendering::session::rendering_continues_until_its_scene_changes",
    ),
    bug(
        "min-distance-ignored",
        "what is nearer than a ray's least distance counts",
        "rendering::session::ray_queries_return_correct_hits_and_reject_invalid_rays",
    ),
    bug(
        "rejected-steps-stay",
        "a chain that goes back keeps one of the numbers that were proposed",
        "lib::sampler::primary::tests::primary_samples_are_reproducible_and_restored_on_rejection",
    ),
    bug(
        "brightness-of-what-chains-see",
        "the brightness is the mean over those points alone that a chain may walk through",
        "rendering::metropolis::metropolis_agrees_with_path_in_every_block_of_six_scenes",
    ),
    bug(
        "missed-light-is-no-error",
        "auto goes by the spread of path's pictures alone, which lack light that it hardly meets",
        "lib::render::auto::pilot::tests::light_missed_by_path_counts_towards_its_inefficiency",
    ),
    bug(
        "strategies-have-uneven-shares",
        "a chain takes the first strategies more often than the last and does not count that",
        "lib::render::metropolis::chain::tests::strategies_are_equally_probable",
    ),
    bug(
        "cache-without-bound",
        "records count as far as the surroundings are away, whatever they are like",
        "rendering::irradiance_cache::cached_irradiance_error_is_within_its_bound",
    ),
    bug(
        "cache-counts-lights-twice",
        "what the rays of a record find of lights counts as if light sampling did not find it at every point",
        "rendering::irradiance_cache::cached_room_agrees_with_path_within_the_error_bound",
    ),
    bug(
        "splats-by-the-pixels-own-count",
        "samples of a neighbouring tile are divided by the count of the pixel's own tile",
        "lib::film::splatted::tests::tile_sums_are_normalised_by_their_own_sample_count",
    ),
    bug(
        "no-samples-beyond-the-edge",
        "pixels at the image's edge lack the samples outside that their filter covers",
        "rendering::filters::splatted_furnace_image_is_exact_up_to_the_border",
    ),
];
