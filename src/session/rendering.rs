//! A render of a session's scene as far as it has come, and what can be read off it.
//!
//! Measure: radiance, samples per pixel.
//! Range: a rendering goes on as long as its session has not changed; what is there can be read at any time.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

use super::{Session, State, layers};
use crate::error::{Error, Result};
use crate::film::bars::ErrorBars;
use crate::film::pixel::PixelSums;
use crate::film::splats::Splats;
use crate::film::{ErrorEstimate, Film};
use crate::image::{Image, LayeredImage};
use crate::memory;
use crate::render::auto::{Recommendation, settle};
use crate::render::options::RenderOptions;
use crate::render::settings::Adaptive;
use crate::render::settings::{Budget, RenderSettings};
use crate::render::{RenderObserver, Rendered, check, resume};

/// A render as far as it has come.
#[derive(Debug, Clone)]
pub struct Rendering {
    settings: RenderSettings,
    recommendation: Option<Recommendation>,
    rendered: Rendered,
    state: State,
}

impl Rendering {
    pub(super) fn new(
        session: &Session,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Self> {
        let mut wished = options.settings(&session.description)?;
        wished.threads = session.threads.count();
        let view = session.view();
        let (settings, recommendation) = settle(&view, &session.threads, &wished, observer)?;
        check(&session.scene, &settings)?;
        check_room(&settings)?;
        Ok(Self {
            rendered: Rendered::nothing(&settings),
            settings,
            recommendation,
            state: session.state,
        })
    }

    /// Goes on until `until` is met; samples per pixel count from the first, time from now.
    ///
    /// # Errors
    /// A session that has changed since this began, or is another one; an adaptive render that has begun. What was rendered
    /// stays.
    pub fn go_on(
        &mut self,
        session: &Session,
        until: Budget,
        observer: &dyn RenderObserver,
    ) -> Result<()> {
        self.check_session(session)?;
        resume(
            &session.view(),
            &session.threads,
            &self.settings,
            until,
            &mut self.rendered,
            observer,
        )
    }

    /// Takes so many more samples in each pixel.
    ///
    /// # Errors
    /// As [`Self::go_on`].
    pub fn add_samples(
        &mut self,
        session: &Session,
        spp: u64,
        observer: &dyn RenderObserver,
    ) -> Result<()> {
        let until = Budget::samples(self.spp().saturating_add(spp));
        self.go_on(session, until, observer)
    }

    /// The settings that the wishes have become.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// What `auto` has come to; `None` where an integrator was named.
    pub fn recommendation(&self) -> Option<&Recommendation> {
        self.recommendation.as_ref()
    }

    /// All that was counted.
    pub fn rendered(&self) -> &Rendered {
        &self.rendered
    }

    /// The sums that the picture is made of.
    pub fn film(&self) -> &Film {
        &self.rendered.film
    }

    /// Complete samples per pixel, in the mean where pixels differ.
    pub fn spp(&self) -> u64 {
        self.rendered.spp
    }

    /// The picture: linear Rec. 709, row by row from the top. Pixels without a sample are black.
    pub fn image(&self) -> Image {
        self.rendered.film.develop()
    }

    /// The error bars of all pixels; `None` before every pixel has four samples.
    pub fn error_bars(&self) -> Option<ErrorBars> {
        let film = &self.rendered.film;
        film.has_all_batches().then(|| film.error_bars())
    }

    /// How far the picture is likely to be from the truth, with an upper bound of this confidence, in (0, 1); `None` before
    /// that can be told.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        self.rendered.error(confidence)
    }

    /// The picture with all its layers.
    ///
    /// # Errors
    /// A session that has changed since or is another one, or a render that was not asked for layers.
    pub fn layered(&self, session: &Session) -> Result<LayeredImage> {
        self.check_session(session)?;
        let view = session.view();
        let layers = || layers::layers(&view, &self.settings, &self.rendered);
        let layers = session.threads.run(layers)?;
        Ok(LayeredImage {
            layers,
            ..LayeredImage::from(self.image())
        })
    }

    fn check_session(&self, session: &Session) -> Result<()> {
        if self.state == session.state {
            return Ok(());
        }
        Err(Error::usage(
            "the scene has changed since this render began, or is another one: begin a new render",
        ))
    }
}

/// Makes sure that there is memory for the sums of all pixels.
fn check_room(settings: &RenderSettings) -> Result<()> {
    let has_counts = settings.adaptive != Adaptive::Off;
    let of_pixel = size_of::<PixelSums>()
        + usize::from(settings.integrator.splats()) * Splats::BYTES_PER_PIXEL
        + usize::from(has_counts) * 2 * size_of::<u64>();
    let bytes = settings
        .window
        .pixel_count()
        .saturating_mul(of_pixel as u64);
    let (width, height) = (settings.window.width, settings.window.height);
    memory::check(bytes, || format!("a picture of {width} x {height} pixels"))
}
