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
        "lights::light::samples_cover_the_solid_angle",
    ),
    bug(
        "origin-not-offset",
        "rays start on the surface, not beyond the bound of its error",
        "lib::math::robust::tests::an_offset_point_is_beyond_its_error_bound_on_the_asked_side",
    ),
    bug(
        "offset-rounds-back",
        "a ray's start may be rounded back towards the surface",
        "lib::math::robust::tests::an_offset_point_is_beyond_its_error_bound_on_the_asked_side",
    ),
    bug(
        "edges-open",
        "a line exactly through an edge or a vertex misses both of its triangles",
        "lib::math::triangle::tests::no_line_slips_through_a_fan",
    ),
    bug(
        "shadow-ray-cut-short",
        "shadow rays end a thousandth before the light",
        "tracing::rays::a_segment_sees_an_occluder_right_before_the_light_but_not_the_light",
    ),
    bug(
        "points-exact",
        "shadow rays to a point light end where it is, as if a surface through it were not rounded",
        "tracing::rays::a_surface_through_a_point_light_hides_it_from_neither_side",
    ),
    bug(
        "balance-heuristic",
        "weights are of the first power of the densities instead of the second",
        "lib::sampling::mis::tests::twice_the_density_counts_four_times",
    ),
    bug(
        "cone-pdf-off-by-two",
        "the density in a cone is half of what it is",
        "sampling::warps::cones_disk_and_triangle_are_uniform",
    ),
    bug(
        "alias-off-by-one",
        "an alias is the item before the one that gave its share",
        "lib::sampling::distribution::tests::items_are_chosen_in_proportion_to_their_weights",
    ),
    bug(
        "shuffle-in-one-cycle",
        "the shuffle of Latin hypercubes leaves nothing in its place",
        "course::integration::intervals_are_matched_in_every_way_alike",
    ),
    bug(
        "light-and-bsdf-share-numbers",
        "the point on a light and the scattered direction take the same numbers",
        "lib::sampler::tests::decisions_never_share_a_number",
    ),
    bug(
        "one-is-drawn",
        "a uniform number may be rounded to 1",
        "lib::sampler::tests::the_largest_number_is_below_one",
    ),
    bug(
        "sobol-order-shared",
        "all decisions of a sample take the same place in Sobol's sequence",
        "sampling::sampler::sobol_decisions_take_orders_of_their_own",
    ),
    bug(
        "lanes-share-a-sampler",
        "samplers that draw side by side all draw what the first of them does",
        "sampling::sampler::samplers_draw_side_by_side_what_each_draws_alone",
    ),
    bug(
        "strata-shared-by-decisions",
        "all decisions of a sample lie in the same stratum",
        "sampling::stratified::decisions_and_pixels_know_nothing_of_one_another",
    ),
    bug(
        "half-a-texel",
        "texels have their value at a corner instead of their centre",
        "lib::geometry::texture::tests::texel_centres_give_the_texels_with_v_up",
    ),
    bug(
        "normals-by-the-matrix",
        "an instance's normals are transformed as its directions are",
        "tracing::instance_surfaces::a_triangle_has_the_points_and_normals_of_the_same_triangle_in_the_world",
    ),
    bug(
        "slivers-as-others",
        "the error bound of a sliver's points leaves out what rounding does to its normal",
        "tracing::slivers::no_shadow_ray_meets_the_sliver_that_it_leaves_or_ends_on",
    ),
    bug(
        "normals-of-exchanged-corners",
        "shading normals are interpolated with two corners exchanged",
        "lib::geometry::mesh::tests::each_corner_has_its_own_normal_and_texture_coordinate",
    ),
    bug(
        "one-percent-of-albedo",
        "matte surfaces reflect one percent less along a path",
        "scattering::furnace::white_diffuse_and_mirror_give_everything_back",
    ),
    bug(
        "half-vector-jacobian",
        "a mirrored direction has the density of its half vector",
        "scattering::bsdf::directions_follow_their_density",
    ),
    bug(
        "shadowing-uncorrelated",
        "masking and shadowing are multiplied as if they were independent",
        "scattering::furnace::compensated_white_metal_gives_everything_back",
    ),
    bug(
        "refraction-jacobian",
        "the half vector of refraction has the index of the wrong side in its Jacobian",
        "scattering::bsdf::directions_follow_their_density",
    ),
    bug(
        "eta-squared-forgotten",
        "refracted radiance is not scaled by the square of the index",
        "scattering::furnace::smooth_glass_gives_everything_back",
    ),
    bug(
        "pane-of-one-side",
        "a thin pane reflects as one of its sides does",
        "scattering::furnace::a_pane_reflects_what_its_two_sides_do",
    ),
    bug(
        "facets-met-but-once",
        "light between a metal's facets is coloured by one meeting too few",
        "lib::bsdf::conductor::tests::light_between_facets_is_the_sum_over_its_meetings",
    ),
    bug(
        "lobe-left-out-of-pdf",
        "the principled density leaves out the lobe of light between facets",
        "scattering::bsdf::directions_follow_their_density",
    ),
    bug(
        "light-bound-without-size",
        "the cosine at a receiver is that of the centre of a light's bounds, and lights half below the horizon are left out",
        "lights::choice::no_light_that_shines_on_a_receiver_is_left_out",
    ),
    bug(
        "compensated-alone",
        "light sampling without a weight leaves out what is darker than the mean of an environment map",
        "lib::render::settings::rules::tests::only_path_compensates_the_density_of_environment_maps",
    ),
    bug(
        "choice-left-out-of-pdf",
        "the density of a light met by chance leaves out the choice of the light",
        "lights::light::lights_are_chosen_by_power",
    ),
    bug(
        "cone-cancels",
        "one minus the cosine of a small sphere's cone is subtracted in single precision",
        "lights::light::sphere_cones_keep_their_digits",
    ),
    bug(
        "unmirrored-wrap",
        "mirrored images do not turn back at their edge",
        "lib::geometry::uv_map::tests::coordinates_are_repeated_mirrored_or_clamped_between_centres",
    ),
    bug(
        "environment-half-a-texel",
        "directions to an environment are half a texel off",
        "lights::environment::directions_follow_their_density",
    ),
    bug(
        "focus-on-a-sphere",
        "what is in focus has the same distance instead of the same depth",
        "lib::camera::tests::all_rays_of_a_lens_meet_in_the_plane_in_focus",
    ),
    bug(
        "departure-ignored",
        "a primitive just left counts even where it cannot truly be met",
        "tracing::rays::what_has_just_been_left_is_passed_up_to_its_free_distance",
    ),
    bug(
        "shadow-rays-together",
        "shadow rays go through Embree's packets as they are, which take the first steps down the tree together",
        "tracing::packets::what_a_ray_meets_does_not_depend_on_those_beside_it",
    ),
    bug(
        "box-without-slack",
        "the test of boxes does not allow for its rounding",
        "tracing::rays::robust_tracing_lets_nothing_out_of_a_closed_mesh",
    ),
    bug(
        "denominator-of-the-same-half",
        "the stated error divides the noise of a half by the light of the same half",
        "lib::film::error::tests::rare_bright_samples_do_not_excuse_themselves",
    ),
    bug(
        "denominator-with-its-own-noise",
        "the stated error adds a pixel's own noise to its denominator, so that a bright sample hides its error",
        "lib::film::error::tests::rare_bright_samples_do_not_excuse_themselves",
    ),
    bug(
        "moderation-forgets-its-freedom",
        "error bars take a variance told by few numbers as known",
        "lib::film::bars::tests::intervals_cover_as_often_as_they_say_whatever_neighbours_are_like",
    ),
    bug(
        "flags-by-the-pixel-itself",
        "whether to trust a pixel's error bar is decided by its own samples",
        "lib::film::bars::tests::a_pixel_is_not_asked_whether_to_trust_it",
    ),
    bug(
        "film-in-single-precision",
        "a pixel's sum is rounded to single precision",
        "lib::film::pixel::tests::many_equal_samples_keep_their_mean",
    ),
    bug(
        "alpha-number-reused",
        "the number that passed one veil decides about the next one as well",
        "scattering::materials::a_veiled_sphere_is_met_twice",
    ),
    bug(
        "sides-unchecked",
        "a shading normal may reflect light to below the surface",
        "scattering::shading_normals::no_light_comes_through_what_is_opaque",
    ),
    bug(
        "long-rays-exact",
        "a shadow ray's end is bounded as if the ray had no length",
        "tracing::rays::a_long_segment_does_not_end_on_its_light",
    ),
    bug(
        "rounded-before-centred",
        "points are rounded before the scene is moved to the origin",
        "lib::scene::normalisation::tests::a_far_scene_keeps_its_digits",
    ),
    bug(
        "the-longer-way-round",
        "what turns between two keys turns the other way round",
        "lib::scene::keyframes::tests::a_turntable_turns_evenly",
    ),
    bug(
        "pbrt-world-not-mirrored",
        "the left-handed world of a pbrt file is taken as right-handed",
        "loading::pbrt::worlds::lights_are_where_the_mirrored_world_has_them",
    ),
    bug(
        "octahedron-not-folded",
        "the lower hemisphere of an octahedral map is not mirrored at the equator",
        "lib::scene::load::pbrt::environment::tests::the_square_and_the_sphere_map_to_each_other_with_equal_areas",
    ),
    bug(
        "intensity-in-world-units",
        "a point light's intensity ignores the unit of length",
        "lib::scene::prepare::tests::points_light_scenes_of_any_size_alike",
    ),
    bug(
        "roulette-on-radiance",
        "what survives roulette has its radiance divided by the probability, not its throughput",
        "rendering::roulette::no_roulette_changes_what_a_highlight_shows",
    ),
    bug(
        "roulette-takes-a-spent-number",
        "roulette takes a number that has chosen the direction",
        "rendering::roulette::no_roulette_changes_what_a_highlight_shows",
    ),
    bug(
        "window-without-its-weight",
        "what survives roulette by a weight window has the weight of a window of 1",
        "lib::integrator::roulette::tests::a_window_keeps_the_mean_throughput",
    ),
    bug(
        "roulette-without-division",
        "what survives roulette is not divided by its probability",
        "rendering::roulette::no_roulette_changes_what_a_highlight_shows",
    ),
    bug(
        "begun-path-keeps-a-throughput",
        "a path that begins in a lane keeps the throughput of the path before",
        "lights::lamps::a_large_lamp_lights_by_its_form_factor",
    ),
    bug(
        "begun-block-keeps-throughputs",
        "the paths that begin a block together keep the throughputs of the paths before",
        "rendering::adaptive::every_pixel_is_the_mean_of_samples_that_can_be_replayed",
    ),
    bug(
        "reflectance-of-the-next-lane",
        "a path is reflected by the diffuse surface of its neighbour in the block",
        "rendering::adaptive::every_pixel_is_the_mean_of_samples_that_can_be_replayed",
    ),
    bug(
        "ended-paths-sample-lights",
        "next event estimation ignores the mask of active lanes",
        "rendering::adaptive::every_pixel_is_the_mean_of_samples_that_can_be_replayed",
    ),
    bug(
        "light-without-cosine",
        "light sampling leaves out the cosine at the surface",
        "lights::lamps::a_large_lamp_lights_by_its_form_factor",
    ),
    bug(
        "shadows-as-the-shutter-opens",
        "shadow rays are traced at the time when the shutter opens",
        "rendering::motion::moving_shadows_average_over_time",
    ),
    bug(
        "mirror-weighted-as-what-it-shows",
        "light seen in a mirror is weighted as if seen from where the mirror was",
        "lights::lamps::a_lamp_in_a_mirror_lights_as_its_image_does",
    ),
    bug(
        "heuristics-mixed",
        "light sampling is weighted by the balance heuristic, scattering by the power heuristic",
        "lights::lamps::a_large_lamp_lights_by_its_form_factor",
    ),
    bug(
        "filter-weight-dropped",
        "a filter's negative lobes count as positive",
        "rendering::pixels::beside_an_edge_a_pixel_is_the_integral_of_its_filter",
    ),
    bug(
        "half-a-pixel",
        "pixels have their centre at their corner",
        "rendering::pixels::beside_an_edge_a_pixel_is_the_integral_of_its_filter",
    ),
    bug(
        "passes-repeat-samples",
        "each pass takes the same samples again",
        "rendering::adaptive::every_pixel_is_the_mean_of_samples_that_can_be_replayed",
    ),
    bug(
        "samples-cost-alike",
        "samples are given out as if all of them took as many rays",
        "rendering::adaptive_pixels::samples_that_take_more_rays_are_fewer",
    ),
    bug(
        "pixels-ask-their-own-pilot",
        "a pixel's own pilot decides how many samples it gets",
        "rendering::adaptive_pixels::rare_events_have_their_mean_in_two_phases",
    ),
    bug(
        "neighbours-of-either-colour-tell",
        "pixels decide about neighbours that decide about them",
        "rendering::adaptive_pixels::no_pixel_is_asked_about_itself",
    ),
    bug(
        "denoise-ignores-variance",
        "the noise filter measures differences by the colours, not by their noise",
        "rendering::denoise::bias_vanishes_as_the_noise_does",
    ),
    bug(
        "denoise-own-weights",
        "a half of the picture is filtered by weights of its own",
        "rendering::denoise::noise_of_any_distribution_keeps_its_mean",
    ),
    bug(
        "both-sides-at-once",
        "a lamp that shines on both sides sends out as many rays on each as one with a single side",
        "lights::emission::the_rays_of_a_light_carry_its_power",
    ),
    bug(
        "film-without-tilt",
        "a steradian falls on as much film at the edge of the picture as in the middle",
        "lib::camera::tests::a_steradian_falls_on_as_much_film_as_is_said",
    ),
    bug(
        "sums-lose-digits",
        "samples and splats are summed up in double precision alone",
        "lib::math::exact_sum::tests::no_order_and_no_division_changes_a_bit",
    ),
    bug(
        "splats-half-a-pixel-off",
        "a splat is weighed by the filter about a pixel's corner",
        "lib::film::splats::tests::a_box_gives_each_splat_to_the_pixel_that_it_lies_in",
    ),
    bug(
        "a-weight-is-missing",
        "a strategy's weight leaves others out that find the same path",
        "lib::integrator::bidirectional::weights::tests::weights_are_those_of_the_definition_and_sum_to_one",
    ),
    bug(
        "shading-normals-both-ways-alike",
        "power is scattered about shading normals as radiance is",
        "rendering::bidirectional::a_stone_scatters_power_as_it_scatters_radiance",
    ),
    bug(
        "light-thinned-as-radiance",
        "power is thinned on its way into glass as radiance is",
        "rendering::bidirectional::a_wall_within_glass_is_lit_the_same_from_both_ends",
    ),
    bug(
        "splats-without-film",
        "light that comes to the lens is not that of a pixel's solid angle",
        "rendering::bidirectional::it_agrees_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "reuse-without-visibility",
        "pixels that cannot see a surface are counted among those that find it",
        "rendering::reuse::they_agree_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "reuse-without-cosine",
        "the densities of shared surfaces become those per area without their cosines",
        "rendering::reuse::they_agree_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "reuse-judged-at-one-pixel",
        "all pixels of a packet share if the first one sees a matte surface",
        "rendering::reuse::pixels_share_beside_others_that_do_not",
    ),
    bug(
        "reuse-counts-black-pixels",
        "pixels that see a black surface, on which paths end, are counted among those that find a surface",
        "rendering::reuse::pixels_share_beside_others_that_do_not",
    ),
    bug(
        "light-paths-without-importance",
        "a light path that comes to the lens is not divided by the solid angle of a pixel",
        "rendering::light_paths::they_agree_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "light-paths-thinned-as-radiance",
        "light paths are refracted by the factor of radiance, without eta squared",
        "rendering::light_paths::a_wall_within_glass_is_the_same_for_light_paths",
    ),
    bug(
        "light-paths-counted-per-pixel",
        "camera paths are weighed as if all light paths were their own pixel's",
        "rendering::light_paths::they_agree_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "guides-left-out-of-weight",
        "camera paths are weighed as if light paths were not sampled towards what throws light",
        "rendering::light_paths::they_agree_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "new-lens-left-out",
        "a camera that replaces another calls for no effects of its own",
        "rendering::session::another_camera_builds_nothing_and_shows_what_it_should",
    ),
    bug(
        "lamps-stay-behind",
        "lamps of a group that is placed anew are sampled where they were",
        "rendering::session::another_place_builds_no_group_and_shows_what_it_should",
    ),
    bug(
        "changes-unnoticed",
        "a render goes on after its scene has changed",
        "rendering::session::a_rendering_goes_on_until_its_scene_changes",
    ),
    bug(
        "min-distance-ignored",
        "what is nearer than a ray's least distance counts",
        "rendering::session::rays_meet_what_is_there",
    ),
    bug(
        "rejected-steps-stay",
        "a chain that goes back keeps one of the numbers that were proposed",
        "lib::sampler::primary::tests::a_point_is_the_same_whenever_it_is_asked_for_and_after_a_rejection",
    ),
    bug(
        "brightness-of-what-chains-see",
        "the brightness is the mean over those points alone that a chain may walk through",
        "rendering::metropolis::it_agrees_with_path_in_every_part_of_six_scenes",
    ),
    bug(
        "missed-light-is-no-error",
        "auto goes by the spread of path's pictures alone, which lack light that it hardly meets",
        "lib::render::auto::pilot::tests::light_that_path_never_meets_counts_as_its_error",
    ),
    bug(
        "strategies-have-uneven-shares",
        "a chain takes the first strategies more often than the last and does not count that",
        "lib::render::metropolis::chain::tests::every_strategy_has_the_same_share_of_numbers",
    ),
    bug(
        "cache-without-bound",
        "records count as far as the surroundings are away, whatever they are like",
        "rendering::irradiance_cache::what_it_tells_is_within_the_bound_of_the_truth",
    ),
    bug(
        "cache-counts-lights-twice",
        "what the rays of a record find of lights counts as if light sampling did not find it at every point",
        "rendering::irradiance_cache::a_room_is_as_path_shows_it",
    ),
    bug(
        "splats-by-the-pixels-own-count",
        "samples of a neighbouring tile are divided by the count of the pixel's own tile",
        "lib::film::splatted::tests::each_tile_is_divided_by_its_own_count",
    ),
    bug(
        "no-samples-beyond-the-edge",
        "pixels at the image's edge lack the samples outside that their filter covers",
        "rendering::filters::a_furnace_is_exact_up_to_the_edge",
    ),
];
