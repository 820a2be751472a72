//! Renderings: the state of a render of a session's scene, and its results so far.
//!
//! Measure: radiance, samples per pixel.
//! Range: a rendering can be continued until its session changes; its results can be read at any time.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

use super::{Revision, Session, layers};
use crate::error::{Error, Result};
use crate::film::error_bars::ErrorBars;
use crate::film::filter::Filter;
use crate::film::{ErrorEstimate, Film};
use crate::image::{Image, LayeredImage};
use crate::memory;
use crate::render::auto::{
    PathChoices, Recommendation, ResolvedSettings, resolve_auto, with_known_choices,
};
use crate::render::options::RenderOptions;
use crate::render::settings::{Budget, RenderSettings};
use crate::render::{RenderObserver, Rendered, check, check_is_lit, resume};
use crate::state::Fingerprint;
use std::ops::Range;
use std::sync::OnceLock;

/// A render in progress.
#[derive(Debug, Clone)]
pub struct Rendering {
    pub(super) settings: RenderSettings,
    recommendation: Option<Recommendation>,
    choices: PathChoices,
    pub(super) rendered: Rendered,
    /// The samples of a shard; `None` for a whole render.
    pub(super) shard: Option<Range<u64>>,
    /// The identity of scene and settings, once it is needed.
    pub(super) identity: OnceLock<Fingerprint>,
    revision: Revision,
}

impl Rendering {
    pub(super) fn new(
        session: &Session,
        options: &RenderOptions,
        known: Option<&Fingerprint>,
        observer: &dyn RenderObserver,
    ) -> Result<Self> {
        let mut requested = options.settings(&session.description)?;
        if let Some(known) = known {
            requested = with_known_choices(&requested, &known.settings);
        }
        requested.threads = session.threads.count();
        let input = session.input();
        let ResolvedSettings {
            settings,
            recommendation,
            choices,
        } = resolve_auto(&input, &session.threads, &requested, observer)?;
        check(&session.scene, &settings)?;
        check_room(&settings, &session.filter)?;
        Ok(Self {
            rendered: Rendered::empty(&settings, &session.filter),
            settings,
            recommendation,
            choices,
            shard: None,
            identity: OnceLock::new(),
            revision: session.revision,
        })
    }

    /// Continues until the budget `until` is reached; samples per pixel count from the first sample, time from this
    /// call.
    ///
    /// # Errors
    /// A session that has changed since the rendering began, or is another one; a greedy adaptive render that has begun and
    /// is not complete. The samples so far are kept.
    pub fn continue_until(
        &mut self,
        session: &Session,
        until: Budget,
        observer: &dyn RenderObserver,
    ) -> Result<()> {
        self.check_session(session)?;
        resume(
            &session.input(),
            &session.threads,
            &self.settings,
            until,
            &mut self.rendered,
            observer,
        )?;
        match self.shard {
            Some(_) => Ok(()),
            None => check_is_lit(&self.settings, &self.rendered),
        }
    }

    /// Takes this many additional samples per pixel.
    ///
    /// # Errors
    /// The errors of [`Self::continue_until`].
    pub fn add_samples(
        &mut self,
        session: &Session,
        spp: u64,
        observer: &dyn RenderObserver,
    ) -> Result<()> {
        let until = Budget::samples(self.spp().saturating_add(spp));
        self.continue_until(session, until, observer)
    }

    /// The settings that the options resolve to.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// The recommendation that `auto` resolved to; `None` if an integrator was named.
    pub fn recommendation(&self) -> Option<&Recommendation> {
        self.recommendation.as_ref()
    }

    /// The choices of pilots for a render by `path`.
    pub fn choices(&self) -> PathChoices {
        self.choices
    }

    /// The complete results so far.
    pub fn rendered(&self) -> &Rendered {
        &self.rendered
    }

    /// The film with the sums of all pixels.
    pub fn film(&self) -> &Film {
        &self.rendered.film
    }

    /// The number of complete samples per pixel, averaged where pixels differ.
    pub fn spp(&self) -> u64 {
        self.rendered.spp
    }

    /// The image: linear Rec. 709, row by row from the top. Pixels without a sample are black.
    pub fn image(&self) -> Image {
        self.rendered.film.develop()
    }

    /// The error bars of all pixels; `None` until every pixel has four samples.
    pub fn error_bars(&self) -> Option<ErrorBars> {
        let film = &self.rendered.film;
        film.has_all_batches().then(|| film.error_bars())
    }

    /// The estimated error of the image, with an upper bound at this confidence, in (0, 1); `None` while it cannot be
    /// estimated.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        self.rendered.error(confidence)
    }

    /// The image with all its layers.
    ///
    /// # Errors
    /// A session that has changed since the rendering began or is another one, or a render without layers requested.
    pub fn layered(&self, session: &Session) -> Result<LayeredImage> {
        self.check_session(session)?;
        let input = session.input();
        let layers = || layers::layers(&input, &self.settings, &self.rendered);
        let layers = session.threads.run(layers)?;
        Ok(LayeredImage {
            layers,
            ..LayeredImage::from(self.image())
        })
    }

    pub(super) fn check_session(&self, session: &Session) -> Result<()> {
        if self.revision == session.revision {
            return Ok(());
        }
        Err(Error::usage(
            "the scene has changed since this render began, or is another one: begin a new render",
        ))
    }
}

/// Checks that there is memory for the sums of all pixels, and for what is computed from them.
fn check_room(settings: &RenderSettings, filter: &Filter) -> Result<()> {
    let bytes = memory_of(settings, filter);
    let (width, height) = (settings.window.width, settings.window.height);
    memory::check(bytes, || format!("an image of {width} x {height} pixels"))
}

/// The memory of a render beside its scene, in bytes.
fn memory_of(settings: &RenderSettings, filter: &Filter) -> u64 {
    let pixels = settings.window.pixel_count();
    let film = settings.film_layout(filter).memory();
    film.saturating_add(pixels.saturating_mul(Film::WORKING_MEMORY))
}
