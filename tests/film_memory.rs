//! Tests that the peak memory of what is computed from a film is at most the memory predicted beforehand, and not far below
//! it. This is the only test of its process, because the allocations of others would be counted, too.

use etendue::internals::film::{Film, Window};
use etendue::internals::math::rgb::Rgb;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The edge of the film in pixels.
const EDGE: u32 = 512;

/// A film with eight samples per pixel.
fn film() -> Film {
    let mut film = Film::new(Window::whole((EDGE, EDGE)), 64);
    for tile in film.tiles_mut() {
        tile.samples = 8;
        for (place, sums) in tile.pixels.iter_mut().enumerate() {
            for index in 0..8 {
                sums.add(index, Rgb::grey((place as u64 * 7 % (3 + index)) as f32));
            }
        }
    }
    film
}

/// The peak of the memory of some work beyond what is there before, in bytes per pixel.
fn peak<T>(work: impl FnOnce() -> T) -> u64 {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let result = work();
    let taken = MEMORY.peak_usage() - before;
    drop(result);
    taken as u64 / u64::from(EDGE * EDGE)
}

#[test]
fn predicted_working_memory_bounds_the_peak_within_a_factor_of_4() {
    let film = film();
    // Of four threads, three compute the channels at once.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(4).build();
    let threads = threads.expect("four threads");
    let of_error = peak(|| threads.install(|| film.error(0.95).expect("eight samples")));
    let of_bars = peak(|| film.error_bars());
    let of_image = peak(|| film.develop());
    println!("bytes per pixel: error {of_error}, error bars {of_bars}, image {of_image}");
    for taken in [of_error, of_bars, of_image] {
        assert!(taken <= Film::WORKING_MEMORY, "{taken}");
    }
    assert!(Film::WORKING_MEMORY <= 4 * of_error, "{of_error}");
}
