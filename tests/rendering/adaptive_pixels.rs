//! Adaptive sampling of pixels that are random numbers of known distribution: the sample counts, that two-phase sampling is
//! unbiased, and that greedy sampling is biased.

use crate::common::TestRng;
use crate::common::verdict::assert_mean;
use etendue::internals::film::{Film, Window};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::adaptive::allocation::Allocation;
use etendue::internals::render::adaptive::{SampleAllocation, SampleAllocator};

/// A square film of `edge` pixels along each edge, with sample counts per pixel.
fn film_of(edge: u32) -> Film {
    Film::new(Window::whole((edge, edge)), edge).with_counts()
}

/// Adds samples to every pixel up to its count; each is `value` of the pixel's index and a uniform number.
fn fill(film: &mut Film, counts: &[u64], rng: &mut TestRng, value: impl Fn(usize, f32) -> f32) {
    let tile = &mut film.tiles_mut()[0];
    let now = tile.counts.as_mut().expect("it has counts");
    for (i, sums) in tile.pixels.iter_mut().enumerate() {
        for index in now[i]..counts[i] {
            let sample = Rgb::grey(value(i, rng.uniform()));
            sums.add(index, sample);
        }
        now[i] = now[i].max(counts[i]);
    }
    tile.samples = now.iter().copied().min().expect("there are pixels");
}

/// A sample of `height` with probability 1 / `height`, else 0: the mean is 1.
fn rare(height: f32) -> impl Fn(usize, f32) -> f32 + Copy {
    move |_, u| if u * height < 1.0 { height } else { 0.0 }
}

/// The means of films of 16 x 16 pixels, whose sample counts are determined by a pilot.
fn two_phase(seeds: u64, level: u64, value: impl Fn(usize, f32) -> f32 + Copy) -> Moments {
    Moments::of((0..seeds).map(|seed| {
        let (mut film, mut rng) = (film_of(16), TestRng::new(seed));
        fill(&mut film, &[16; 256], &mut rng, value);
        let counts = Allocation::by_pilot(&film, 16).counts(level);
        fill(&mut film, &counts, &mut rng, value);
        film.mean()[0]
    }))
}

#[test]
fn two_phase_sampling_is_unbiased_for_rare_events() {
    // The standard errors are small enough to detect a bias of 1 % reliably.
    for (height, seeds) in [(20.0, 3000), (200.0, 12_000)] {
        let means = two_phase(seeds, 64, rare(height));
        println!(
            "{height} with probability 1/{height}: {:.5} +- {:.5}",
            means.mean(),
            means.standard_error().expect("many")
        );
        assert_mean("two phases", &means, 1.0, 1.9e-3);
    }
    // A quarter of the image with rare events, the rest with frequent ones.
    let patch = |i: usize, u: f32| {
        let is_rare = i % 16 < 8 && i < 128;
        rare(if is_rare { 50.0 } else { 2.0 })(i, u)
    };
    assert_mean("a patch", &two_phase(3000, 64, patch), 1.0, 1.9e-3);
}

#[test]
fn allocation_by_own_pilot_variance_is_biased() {
    // The bias that the test above would detect: pixels with variance in their own pilot continue, the others stop, at about
    // the same total sample count.
    let means = Moments::of((0..200).map(|seed| {
        let (mut film, mut rng) = (film_of(16), TestRng::new(seed));
        fill(&mut film, &[16; 256], &mut rng, rare(20.0));
        let pilot = film.estimates();
        let counts: Vec<u64> = pilot
            .iter()
            .map(|pixel| if pixel.variance[0] > 0.0 { 96 } else { 16 })
            .collect();
        fill(&mut film, &counts, &mut rng, rare(20.0));
        film.mean()[0]
    }));
    let error = means.standard_error().expect("many");
    println!("by their own pilot: {:.4} +- {error:.4}", means.mean());
    assert!(means.mean() + 10.0 * error < 1.0, "{}", means.mean());
}

#[test]
fn greedy_sampling_is_biased_for_rare_events() {
    for (height, seeds, expected) in [(20.0, 20, 0.615), (200.0, 20, 0.079)] {
        let means = Moments::of((0..seeds).map(|seed| {
            let (mut film, mut rng) = (film_of(16), TestRng::new(seed));
            let allocator = SampleAllocator::Greedy(0.1);
            let mut level = 0;
            while let SampleAllocation::UpTo(counts) =
                allocator.allocate(&film, &[], level..level + 16)
            {
                fill(&mut film, &counts, &mut rng, rare(height));
                level += 16;
            }
            film.mean()[0]
        }));
        println!("{height}: {:.4}", means.mean());
        // The mean of 5120 pixels, each of which ends near 0 or near 1; the exact error at which a pixel stops matters little.
        assert!((means.mean() - expected).abs() < 0.03, "{}", means.mean());
    }
}

#[test]
fn sample_counts_ignore_pilots_of_the_same_checker_colour() {
    let pilot = |strange: Option<usize>| {
        let (mut film, mut rng) = (film_of(16), TestRng::new(7));
        fill(&mut film, &[16; 256], &mut rng, |i, u| {
            if Some(i) == strange {
                1000.0 * u * u
            } else {
                u
            }
        });
        Allocation::by_pilot(&film, 16).counts(64)
    };
    let usual = pilot(None);
    for strange in [0, 37, 136, 255] {
        let colour = |i: usize| (i % 16 + i / 16) % 2;
        let unusual = pilot(Some(strange));
        let mut changed = 0;
        for i in 0..256 {
            if colour(i) == colour(strange) {
                assert_eq!(
                    unusual[i], usual[i],
                    "pixel {strange} changes the count of pixel {i}"
                );
            } else {
                changed += u32::from(unusual[i] != usual[i]);
            }
        }
        assert!(changed > 10, "pixel {strange} changes too few counts");
    }
}

#[test]
fn allocation_favours_noisy_pixels_and_uses_the_whole_budget() {
    let (mut film, mut rng) = (film_of(16), TestRng::new(1));
    // The left half has 16 times the standard deviation, at the same mean.
    let noise = |i: usize, u: f32| 1.0 + if i % 16 < 8 { 0.8 } else { 0.05 } * (u - 0.5);
    fill(&mut film, &[64; 256], &mut rng, noise);
    let allocation = Allocation::by_pilot(&film, 64);
    for level in [64, 80, 128, 1024, 1 << 20] {
        let counts = allocation.counts(level);
        let sum: u64 = counts.iter().sum();
        // Each pixel's fraction of a round is rounded by itself: five standard deviations of their sum.
        assert!(sum.abs_diff(256 * level) <= 128, "{level}: {sum}");
        assert!(counts.iter().all(|n| n % 4 == 0 && *n >= 64));
        assert!(
            counts.iter().all(|&n| 10 * n >= level),
            "{level}: a pixel below the minimum count"
        );
        let equivalent_spp = allocation.equivalent_spp(level);
        let back = allocation.level_of(equivalent_spp);
        assert!((back / level as f64 - 1.0).abs() < 0.01, "{level}: {back}");
    }
    let counts = allocation.counts(1 << 20);
    let far = |columns: std::ops::Range<usize>| {
        let of = (0..256)
            .filter(|i| columns.contains(&(i % 16)))
            .map(|i| counts[i]);
        of.sum::<u64>() as f64
    };
    // Away from the border the half with little noise has the minimum share, an eighth of the mean before scaling.
    let ratio = far(0..4) / far(12..16);
    assert!((8.0..16.0).contains(&ratio), "{ratio}");
}

#[test]
fn sample_counts_never_fall_as_the_level_rises() {
    for seed in 0..20 {
        let (mut film, mut rng) = (film_of(16), TestRng::new(seed));
        fill(&mut film, &[16; 256], &mut rng, rare(20.0));
        let allocation = Allocation::by_pilot(&film, 16);
        let mut before = vec![16; 256];
        for level in 16..400 {
            let counts = allocation.counts(level);
            let mut pairs = before.iter().zip(&counts);
            assert!(pairs.all(|(a, b)| a <= b), "seed {seed}, level {level}");
            before = counts;
        }
        // Nearly all of them rise in the end.
        assert!(before.iter().all(|&count| count > 16), "{before:?}");
    }
}

#[test]
fn allocations_of_different_pilots_have_different_identities() {
    let of = |seed, pilot| {
        let (mut film, mut rng) = (film_of(16), TestRng::new(seed));
        fill(&mut film, &[16; 256], &mut rng, rare(20.0));
        Allocation::by_pilot(&film, pilot).identity()
    };
    assert_eq!(of(1, 16), of(1, 16));
    assert_ne!(of(1, 16), of(2, 16));
    assert_ne!(of(1, 16), of(1, 12));
}

#[test]
fn allocation_follows_the_inverse_square_root_of_cost() {
    let (mut film, mut rng) = (film_of(16), TestRng::new(2));
    fill(&mut film, &[256; 256], &mut rng, |_, u| 1.0 + u);
    let rays = film.tiles_mut()[0].rays.as_mut().expect("it has counts");
    for (i, rays) in rays.iter_mut().enumerate() {
        *rays = 256 * if i % 16 < 8 { 9 } else { 1 };
    }
    let counts = Allocation::by_pilot(&film, 256).counts(1 << 16);
    let of = |columns: std::ops::Range<usize>| {
        let far = (0..256).filter(|i| columns.contains(&(i % 16)));
        far.map(|i| counts[i]).sum::<u64>() as f64
    };
    // The square root of the ratio of costs, up to the noise of the pilot in the means over four columns.
    let ratio = of(12..16) / of(0..4);
    assert!((ratio - 3.0).abs() < 0.3, "{ratio}");
}

#[test]
fn single_pixel_and_black_images_are_sampled_uniformly() {
    for edge in [1, 2, 5] {
        let mut film = film_of(edge);
        let pixels = (edge * edge) as usize;
        let pilot = vec![16; pixels];
        fill(&mut film, &pilot, &mut TestRng::new(0), |_, _| 0.0);
        let allocation = Allocation::by_pilot(&film, 16);
        assert_eq!(allocation.counts(64), vec![64; pixels]);
        assert_eq!(allocation.equivalent_spp(64), 64.0);
    }
    let mut film = film_of(1);
    fill(&mut film, &[16], &mut TestRng::new(0), |_, u| u);
    assert_eq!(Allocation::by_pilot(&film, 16).counts(48), [48]);
}
