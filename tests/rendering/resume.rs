//! A resumed render has the same image as one without interruption.

use crate::common::scene::ready;
use crate::common::scene_folder::{SMALL, load_text};
use crate::common::session::CancelAfter;
use etendue::ErrorKind;
use etendue::internals::accel::Backend;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::image::Image;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::render::settings::{Budget, ErrorTarget, RenderSettings, SamplerKind};
use etendue::internals::render::{
    NullRenderObserver, RenderInput, RenderObserver, Rendered, Threads, render, resume,
};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use std::sync::Mutex;

struct Stage {
    description: SceneDescription,
    scene: Scene,
    filter: Filter,
    threads: Threads,
}

impl Stage {
    fn new() -> Self {
        let description = load_text(SMALL);
        Self {
            scene: ready(&description, Backend::ALL[0]),
            filter: Filter::new(&description.film.filter),
            threads: Threads::new(2).expect("two threads"),
            description,
        }
    }

    fn settings(&self, spp: u64) -> RenderSettings {
        RenderSettings {
            tile_size: 5,
            ..RenderSettings::new(self.description.film.size, spp)
        }
    }

    fn at_once(&self, settings: &RenderSettings) -> Rendered {
        let size = self.description.film.size;
        render(
            &self.scene,
            &self.filter,
            size,
            settings,
            &NullRenderObserver,
        )
        .expect("valid settings")
    }

    fn continue_until(
        &self,
        settings: &RenderSettings,
        until: Budget,
        rendered: &mut Rendered,
        observer: &dyn RenderObserver,
    ) -> etendue::Result<()> {
        let input = RenderInput {
            scene: &self.scene,
            filter: &self.filter,
            size: self.description.film.size,
        };
        resume(&input, &self.threads, settings, until, rendered, observer)
    }
}

#[test]
fn render_in_parts_is_bit_identical_to_a_single_render() {
    let stage = Stage::new();
    for (sampler, integrator) in [
        (SamplerKind::Independent, IntegratorKind::Path),
        (SamplerKind::Sobol, IntegratorKind::Path),
        (SamplerKind::Sobol, IntegratorKind::Bidirectional),
    ] {
        for layers in [false, true] {
            let settings = |spp| RenderSettings {
                sampler,
                integrator,
                layers,
                ..stage.settings(spp)
            };
            let whole = stage.at_once(&settings(48));
            let mut parts = Rendered::empty(&settings(16), &stage.filter);
            for spp in [16, 32, 48] {
                let until = Budget::samples(spp);
                stage
                    .continue_until(&settings(16), until, &mut parts, &NullRenderObserver)
                    .expect("valid settings");
                assert_eq!(parts.spp, spp);
            }
            assert_eq!(parts.film.develop(), whole.film.develop(), "{sampler:?}");
            assert_eq!(
                parts.film.error_bars(),
                whole.film.error_bars(),
                "{sampler:?}"
            );
            assert_eq!(parts.error(0.95), whole.error(0.95), "{sampler:?}");
            assert_eq!(parts.rays, whole.rays);
        }
    }
}

#[test]
fn interrupted_render_resumes_to_the_same_image() {
    let stage = Stage {
        threads: Threads::new(1).expect("a thread"),
        ..Stage::new()
    };
    let settings = stage.settings(8);
    let mut parts = Rendered::empty(&settings, &stage.filter);
    let observer = CancelAfter::tiles(27);
    stage
        .continue_until(&settings, settings.budget, &mut parts, &observer)
        .expect("valid settings");
    assert!(parts.cancelled);
    let samples = parts.film.tiles().iter().map(|tile| tile.samples);
    let (least, most) = (samples.clone().min(), samples.max());
    assert!(
        least < most,
        "it was not cancelled within a pass: {least:?} {most:?}"
    );
    stage
        .continue_until(&settings, settings.budget, &mut parts, &NullRenderObserver)
        .expect("valid settings");
    assert!(!parts.cancelled);
    let whole = stage.at_once(&settings);
    assert_eq!(parts.film.develop(), whole.film.develop());
    assert_eq!(parts.film.sample_count(), whole.film.sample_count());
    assert_eq!(parts.rays, whole.rays);
}

struct Album(Mutex<Vec<Image>>);

impl RenderObserver for Album {
    fn pass(&self, film: &Film) {
        let mut album = self.0.lock().expect("no thread panicked");
        album.push(film.develop());
    }
}

#[test]
fn observer_receives_the_image_after_every_pass() {
    let stage = Stage::new();
    let settings = stage.settings(4);
    let album = Album(Mutex::default());
    let mut rendered = Rendered::empty(&settings, &stage.filter);
    stage
        .continue_until(&settings, settings.budget, &mut rendered, &album)
        .expect("valid settings");
    let pictures = album.0.into_inner().expect("no thread panicked");
    // Passes of 1, 1 and 2 samples.
    assert_eq!(pictures.len(), 3);
    assert_eq!(
        pictures[0],
        stage.at_once(&stage.settings(1)).film.develop()
    );
    assert_eq!(pictures[2], rendered.film.develop());
}

#[test]
fn interrupted_adaptive_render_resumes_to_the_same_image() {
    let stage = Stage::new();
    let adaptive = RenderSettings {
        adaptive: Adaptive::TwoPhase,
        ..stage.settings(128)
    };
    let whole = stage.at_once(&adaptive);
    // Within the pilot of 32 samples, and after it.
    for tiles in [27, 90, 105] {
        let mut parts = Rendered::empty(&adaptive, &stage.filter);
        let observer = CancelAfter::tiles(tiles);
        stage
            .continue_until(&adaptive, adaptive.budget, &mut parts, &observer)
            .expect("valid settings");
        assert!(parts.cancelled && parts.is_uneven, "{tiles} tiles");
        for _ in 0..2 {
            stage
                .continue_until(&adaptive, adaptive.budget, &mut parts, &NullRenderObserver)
                .expect("valid settings");
            assert!(!parts.is_uneven);
            assert_eq!(parts.film.develop(), whole.film.develop(), "{tiles}");
            assert_eq!(parts.film.sample_counts(), whole.film.sample_counts());
            assert_eq!(
                (parts.rays, parts.equivalent_spp),
                (whole.rays, whole.equivalent_spp)
            );
        }
    }
}

#[test]
fn resuming_a_greedy_render_is_rejected_without_changes() {
    let stage = Stage::new();
    let until = |spp| Budget {
        error: Some(ErrorTarget {
            rel_rmse: 0.5,
            confidence: 0.95,
        }),
        ..Budget::samples(spp)
    };
    let greedy = RenderSettings {
        adaptive: Adaptive::Greedy,
        budget: until(16),
        ..stage.settings(16)
    };
    let mut rendered = stage.at_once(&greedy);
    let before = rendered.film.develop();
    let refused = stage.continue_until(&greedy, until(32), &mut rendered, &NullRenderObserver);
    let refused = refused.expect_err("it cannot be resumed");
    assert_eq!(refused.kind(), ErrorKind::Usage, "{refused}");
    assert_eq!(rendered.film.develop(), before);
}

#[test]
fn complete_adaptive_render_ends_at_once_and_a_greedy_one_is_not_continued() {
    let stage = Stage::new();
    let greedy = Budget {
        error: Some(ErrorTarget {
            rel_rmse: 0.9,
            confidence: 0.9,
        }),
        ..Budget::samples(256)
    };
    for (adaptive, budget) in [
        (Adaptive::TwoPhase, Budget::samples(32)),
        (Adaptive::Greedy, greedy),
    ] {
        let settings = RenderSettings {
            adaptive,
            budget,
            ..stage.settings(32)
        };
        let mut rendered = stage.at_once(&settings);
        let samples = rendered.film.sample_count();
        let again = |until, rendered: &mut Rendered| {
            stage.continue_until(&settings, until, rendered, &NullRenderObserver)
        };
        again(budget, &mut rendered).expect("it is complete");
        assert_eq!(rendered.film.sample_count(), samples, "{adaptive:?}");
        if adaptive != Adaptive::Greedy {
            continue;
        }
        let refused = again(Budget::samples(1024), &mut rendered);
        assert_eq!(refused.expect_err("it has begun").kind(), ErrorKind::Usage);

        let mut cut = Rendered::empty(&settings, &stage.filter);
        stage
            .continue_until(&settings, budget, &mut cut, &CancelAfter::tiles(3))
            .expect("it ends early");
        assert!(cut.cancelled && cut.film.sample_count() > 0);
        let refused = again(budget, &mut cut);
        assert_eq!(refused.expect_err("it has begun").kind(), ErrorKind::Usage);
    }
}
