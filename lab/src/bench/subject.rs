//! The render that is measured: as a whole, or by observing its paths on tiles that are spread over the image.
//!
//! Measure: samples.
//! Range: settings that pass `RenderSettings::validate`.
//! Source: a multiplicative sequence with the golden ratio is evenly distributed. Tested below and in
//! `lab/tests/bench/report.rs`.

use etendue::Result;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::integrator::observer::PathObserver;
use etendue::internals::render::cache_prepass::cache_prepass;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{RenderObserver, Rendered, observe_tile, render};
use etendue::internals::scene::Scene;

/// Number of samples observed in each pixel of a tile before the next tile: as many as are traced together.
pub const SAMPLES_AT_ONCE: u64 = 16;

/// A render: a scene with its filter, size and settings.
#[derive(Debug, Clone, Copy)]
pub struct BenchedRender<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The reconstruction filter.
    pub filter: &'a Filter,
    /// Size of the whole image in pixels.
    pub size: (u32, u32),
    /// The render settings.
    pub settings: &'a RenderSettings,
}

impl BenchedRender<'_> {
    /// Renders on `threads` threads with `spp` samples per pixel.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(
        &self,
        threads: usize,
        spp: u64,
        observer: &dyn RenderObserver,
    ) -> Result<Rendered> {
        let mut settings = self.settings.clone();
        settings.threads = threads;
        settings.budget.spp = Some(spp);
        settings.budget.time = None;
        render(self.scene, self.filter, self.size, &settings, observer)
    }

    /// Traces whole tiles with `observer` until `enough` is true or every sample from `first` on was traced. Returns
    /// the film with these samples.
    pub fn observe<O: PathObserver>(
        &self,
        first: u64,
        observer: &mut O,
        enough: impl Fn(&O) -> bool,
    ) -> Film {
        let mut film = Film::new(self.settings.window, self.settings.tile_size);
        let (cache, _) = cache_prepass(self.scene, self.filter, self.settings, &|_, _| true);
        let spp = self.settings.budget.spp.unwrap_or(u64::MAX);
        let count = film.tiles().len();
        let stride = even_stride(count);
        let mut first = first;
        while first < spp {
            let next = spp.min(first + SAMPLES_AT_ONCE);
            for visit in 0..count {
                let tile = &mut film.tiles_mut()[visit * stride % count];
                let samples = first..next;
                observe_tile(
                    self.scene,
                    self.filter,
                    self.settings,
                    cache.as_ref(),
                    tile,
                    samples,
                    observer,
                );
                if enough(observer) {
                    return film;
                }
            }
            first = next;
        }
        film
    }
}

/// A stride that visits each of `count` places once before it repeats, and spreads even the first visits evenly.
fn even_stride(count: usize) -> usize {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
    let near = (count as f64 * GOLDEN_RATIO) as usize;
    let mut strides = near.max(1)..;
    strides
        .find(|&stride| greatest_common_divisor(stride, count) == 1)
        .expect("there is always a prime further on")
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stride_visits_every_index_once_and_spreads_early_visits() {
        for count in [1, 2, 3, 12, 384, 1000] {
            let stride = even_stride(count);
            let mut visits: Vec<usize> = (0..count).map(|i| i * stride % count).collect();
            let mut early = visits[..count.div_ceil(8)].to_vec();
            visits.sort_unstable();
            assert_eq!(visits, (0..count).collect::<Vec<_>>());
            // An eighth of the visits leaves no gap of three eighths.
            early.sort_unstable();
            let widest = early.windows(2).map(|pair| pair[1] - pair[0]).max();
            let gap = widest.unwrap_or(0);
            assert!(count < 16 || gap * 8 < count * 3, "{count}: {gap}");
        }
    }
}
