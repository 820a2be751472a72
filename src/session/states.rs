//! State files of renderings: shards, checkpoints, and how a render continues from them.
//!
//! Measure: sample indices.
//! Range: a render of a known number of samples is divided into shards. Adaptive renders have no state files.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `cli/tests/command/shards.rs`.

use super::{Rendering, Session, layers};
use crate::error::{Error, Result};
use crate::image::Layer;
use crate::integrator::kind::IntegratorKind;
use crate::render::options::RenderOptions;
use crate::render::settings::{Adaptive, Budget};
use crate::render::{RenderObserver, Rendered};
use crate::state::{Fingerprint, Header, Shard, State, fingerprint};
use std::path::Path;

impl Session {
    /// Continues a render from its state, on the session's threads. The options may ask for more samples, a time or an
    /// error.
    ///
    /// # Errors
    /// The errors of [`Session::start`]; a state of another scene, of other settings or of another version; an error to reach
    /// by a shard.
    pub fn resume(
        &self,
        options: &RenderOptions,
        state: State,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        let mut rendering = self.start_watched(options, observer)?;
        let identity = rendering.identity(self)?;
        let differences = identity.differences(&state.header.identity, "this render", "the state");
        if !differences.is_empty() {
            return Err(Error::usage(format!(
                "cannot continue from the state of another render: {}",
                differences.join("; ")
            )));
        }
        if state.header.window != rendering.settings.window {
            return Err(Error::usage("the state is of another part of the image"));
        }
        rendering.shard = state.header.shard.map(|[first, end]| first..end);
        if rendering.shard.is_some() && rendering.settings.budget.error.is_some() {
            return Err(Error::usage(
                "the state is of a shard, which has a known number of samples: leave --error out, and give it to `etendue merge`",
            ));
        }
        let nothing = Rendered::nothing(&rendering.settings, &self.filter);
        rendering.rendered = state.into_rendered(nothing)?;
        Ok(rendering)
    }
}

impl Rendering {
    /// Restricts a render that has not begun to a shard of its samples.
    ///
    /// # Errors
    /// A render that cannot be divided, or not so; one that has begun.
    pub fn restrict(&mut self, shard: Shard) -> Result<()> {
        if self.rendered.film.sample_count() > 0 {
            return Err(Error::usage(
                "a render that has begun cannot become a shard",
            ));
        }
        let settings = &self.settings;
        self.check_can_be_kept()?;
        let (None, Some(spp)) = (settings.budget.error, self.whole_spp()) else {
            return Err(Error::usage(
                "a shard is a part of a known number of samples: give --spp, and no --error; `etendue plan SCENE --shards --error` tells how many samples an error takes",
            ));
        };
        let samples = shard.samples(spp)?;
        self.rendered.first = samples.start;
        self.shard = Some(samples);
        Ok(())
    }

    /// Checks that the render can have state files.
    ///
    /// # Errors
    /// An adaptive render.
    pub fn check_can_be_kept(&self) -> Result<()> {
        match self.settings.adaptive {
            Adaptive::Off => Ok(()),
            Adaptive::TwoPhase | Adaptive::Greedy => Err(Error::usage(
                "the samples of an adaptive render depend on its pilot and its passes, so that it has no shards and no checkpoints: use --adaptive=off",
            )),
        }
    }

    /// The samples per pixel of the whole render, if they are known.
    pub fn whole_spp(&self) -> Option<u64> {
        let spp = self.settings.budget.spp?;
        Some(spp.next_multiple_of(self.settings.least_samples()))
    }

    /// The budget of this render, or of the shard that it is restricted to.
    pub fn budget(&self) -> Budget {
        let budget = self.settings.budget;
        match &self.shard {
            Some(samples) => Budget {
                spp: Some(samples.end - samples.start),
                ..budget
            },
            None => budget,
        }
    }

    /// The samples of the shard, if this is one.
    pub fn shard(&self) -> Option<std::ops::Range<u64>> {
        self.shard.clone()
    }

    /// Writes the state of the render to a file, whole or not at all.
    ///
    /// # Errors
    /// A session that has changed since the rendering began, or is another one; a file that cannot be written; Markov
    /// chains that were interrupted, whose sums are not those of whole passes.
    pub fn save(&self, session: &Session, path: &Path) -> Result<()> {
        self.check_session(session)?;
        self.check_can_be_kept()?;
        let header = self.header(session)?;
        let layers = match self.includes_layers() {
            true => session.threads.run(|| self.layers_of_scene(session)),
            false => vec![],
        };
        save(header, &self.rendered, layers, path)
    }

    /// The header that state files of this render have in common.
    ///
    /// # Errors
    /// An error of Embree.
    pub fn header(&self, session: &Session) -> Result<Header> {
        let shard = self.shard.as_ref().map(|it| [it.start, it.end]);
        let description = session.description();
        Ok(Header {
            spp: self.whole_spp(),
            shard,
            wants_layers: self.settings.layers,
            bias: self.settings.bias(session.scene.effects),
            ..Header::new(
                self.identity(session)?,
                description.file.display().to_string(),
                self.settings.window,
            )
        })
    }

    /// The identity of scene and settings.
    fn identity(&self, session: &Session) -> Result<Fingerprint> {
        if let Some(identity) = self.identity.get() {
            return Ok(identity.clone());
        }
        let identity = fingerprint(&session.description, &self.settings, session.options)?;
        Ok(self.identity.get_or_init(|| identity).clone())
    }

    /// Whether the layers of the first hits belong into the state: into that of one shard, which has all its samples. A render
    /// that was interrupted may have little time left, and its first hits cannot be interrupted.
    fn includes_layers(&self) -> bool {
        let spp = self.budget().spp;
        let has_all = spp.is_none_or(|spp| self.rendered.spp >= spp);
        let is_complete = has_all && !self.rendered.cancelled;
        self.settings.layers && self.rendered.first == 0 && is_complete
    }

    /// The layers of the whole render's first hits.
    fn layers_of_scene(&self, session: &Session) -> Vec<Layer> {
        let spp = self.whole_spp().unwrap_or(self.rendered.spp);
        layers::of_scene(&session.view(), &self.settings, &self.rendered, spp)
    }
}

/// Writes the state of a render to a file, given the header of its state files.
///
/// # Errors
/// A file that cannot be written; Markov chains that were interrupted.
pub fn save(header: Header, rendered: &Rendered, layers: Vec<Layer>, path: &Path) -> Result<()> {
    if header.identity.name("integrator") == IntegratorKind::Metropolis.name() && is_cut(rendered) {
        return Err(Error::usage(
            "the Markov chains were interrupted within a pass, which has to be done again: the last checkpoint is kept",
        )
        .in_file(path));
    }
    State::write_parts(&header.of(rendered, &layers), &rendered.film, &layers, path)
}

/// Whether Markov chains have splats of a pass that is not complete.
fn is_cut(rendered: &Rendered) -> bool {
    let whole = rendered.spp * rendered.film.window().pixel_count();
    let splats = rendered.film.splats();
    splats.is_some_and(|splats| splats.path_count() != whole)
}
