//! State files of renderings: shards, checkpoints, and how a render continues from them.
//!
//! Measure: sample indices.
//! Range: a render of a known number of samples is divided into shards. Of adaptive renders, the pilot is divided, and given
//! its state the samples after it. Greedy ones have no state files.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `cli/tests/command/shards.rs`.

use super::{Rendering, Session, layers};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::image::Layer;
use crate::image::atomic::ExistingFile;
use crate::integrator::kind::IntegratorKind;
use crate::render::adaptive::allocation::Allocation;
use crate::render::options::RenderOptions;
use crate::render::settings::{Adaptive, Budget};
use crate::render::{RenderObserver, Rendered};
use crate::state::{AdaptivePilot, Fingerprint, Shard, State, StateHeader, describe, fingerprint};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

impl Session {
    /// Continues a render from its state, on the session's threads. The options may ask for more samples, a time or an
    /// error.
    ///
    /// # Errors
    /// The errors of [`Session::start`]; a state of another scene, of other settings or of another version; an error to reach
    /// by a shard; a shard of an adaptive render whose samples were distributed by a pilot.
    pub fn resume(
        &self,
        options: &RenderOptions,
        state: State,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        let mut rendering = self.start_with_observer(options, observer)?;
        rendering.continue_from(self, state)?;
        Ok(rendering)
    }
}

impl Rendering {
    /// Continues from a state, in place of a beginning, as [`Session::resume`] does. The samples of a shard of an adaptive
    /// render are distributed by a pilot first.
    ///
    /// # Errors
    /// The errors of [`Session::resume`]; a state whose samples were distributed by another pilot than those here.
    pub fn continue_from(&mut self, session: &Session, state: State) -> Result<()> {
        self.check_is_of(session, &state)?;
        let header = &state.header;
        let pilot = self.rendered.allocation.as_deref().map(AdaptivePilot::of);
        let wrong = match (&header.pilot, &pilot) {
            _ if self.settings.adaptive == Adaptive::Greedy => {
                "a greedy adaptive render cannot be continued"
            }
            (Some(a), Some(b)) if a != b => "its samples were distributed by another pilot",
            (Some(_), None) if !header.has_allocation => {
                "its samples were distributed by a pilot: give the pilot by --pilot"
            }
            (None, Some(_)) => "it is of a pilot, not of samples that a pilot distributed",
            _ => "",
        };
        if !wrong.is_empty() {
            return Err(Error::usage(format!(
                "cannot continue from this state: {wrong}"
            )));
        }
        self.shard = header.shard.map(|[first, end]| first..end);
        if self.shard.is_some() && self.settings.budget.error.is_some() {
            return Err(Error::usage(
                "a shard has a known number of samples: leave out --error",
            ));
        }
        self.rendered.is_shard = self.shard.is_some();
        let is_adaptive = self.settings.adaptive == Adaptive::TwoPhase;
        self.rendered.is_pilot = is_adaptive && self.shard.is_some() && pilot.is_none();
        state.continue_in(&mut self.rendered)
    }

    /// Checks that a state is one of this render, and keeps the sums that it does.
    fn check_is_of(&self, session: &Session, state: &State) -> Result<()> {
        let (settings, header) = (&self.settings, &state.header);
        let identity = self.identity(session)?;
        let differences = identity.differences(&header.identity, "this render", "the state");
        if !differences.is_empty() {
            return Err(Error::usage(format!(
                "cannot continue from the state of another render: {}",
                differences.join("; ")
            )));
        }
        if header.window != settings.window {
            return Err(Error::usage("the state is of another part of the image"));
        }
        let sums = |film: &Film| {
            (
                film.border_size(),
                film.splats().is_some(),
                film.has_counts(),
            )
        };
        let own = (
            settings.border_size(&session.filter),
            settings.splats(),
            settings.adaptive != Adaptive::Off,
        );
        match sums(&state.film) == own {
            true => Ok(()),
            false => Err(Error::usage("the state has other sums than this render")),
        }
    }

    /// Lets a pilot distribute the samples of an adaptive render that has not begun.
    ///
    /// # Errors
    /// A state that is not the whole pilot of this render; a render that has begun.
    pub fn distribute_by(&mut self, session: &Session, pilot: &State) -> Result<()> {
        self.check_has_not_begun()?;
        if self.settings.adaptive != Adaptive::TwoPhase {
            return Err(Error::usage(
                "only a two-phase adaptive render has a pilot: give --adaptive, too",
            ));
        }
        self.check_is_of(session, pilot)?;
        let header = &pilot.header;
        let samples = Budget::samples(header.spp.unwrap_or(0)).pilot();
        let counts = pilot.film.tiles().iter().flat_map(|tile| &tile.counts);
        let is_even = counts.flatten().all(|&count| count == samples);
        if header.pilot.is_some() || header.done != [[0, samples]] || !is_even {
            return Err(Error::usage(format!(
                "is not a whole pilot, which has samples 0..{samples} of every pixel and no others: it has {}",
                match (&header.pilot, header.done.as_slice()) {
                    (Some(_), _) => "samples that a pilot distributed".to_owned(),
                    (None, []) => "none".to_owned(),
                    (None, done) => describe(done),
                }
            )));
        }
        let allocation = Allocation::by_pilot(&pilot.film, samples);
        self.rendered.allocation = Some(Arc::new(allocation));
        Ok(())
    }

    /// Lets a pilot distribute the samples of an adaptive render that has not begun, and continues from its samples.
    ///
    /// # Errors
    /// The errors of [`Self::distribute_by`].
    pub fn continue_after(&mut self, session: &Session, pilot: State) -> Result<()> {
        self.distribute_by(session, &pilot)?;
        pilot.continue_in(&mut self.rendered)
    }

    /// Restricts a render that has not begun to a shard of its samples. Of an adaptive render, it is a part of the pilot, or
    /// of the samples that the pilot distributes.
    ///
    /// # Errors
    /// A render that cannot be divided, or not so; one that has begun.
    pub fn restrict(&mut self, shard: Shard) -> Result<()> {
        self.check_has_not_begun()?;
        let all = self.divisible();
        let is_pilot = match self.settings.adaptive {
            Adaptive::Off => false,
            Adaptive::TwoPhase => self.rendered.allocation.is_none(),
            Adaptive::Greedy => return self.check_can_be_kept(),
        };
        let samples = match is_pilot {
            true => part_of_pilot(shard, all?.end)?,
            false => all.and_then(|all| shard.samples_after(all.start, all.end))?,
        };
        self.rendered.is_shard = true;
        self.rendered.is_pilot = is_pilot;
        self.rendered.first = samples.start;
        self.shard = Some(samples);
        Ok(())
    }

    fn check_has_not_begun(&self) -> Result<()> {
        match self.rendered.film.sample_count() {
            0 => Ok(()),
            _ => Err(Error::usage(
                "a render that has begun can neither become a shard nor follow a pilot",
            )),
        }
    }

    /// The samples per pixel of the whole render, which shards are parts of.
    fn known_spp(&self) -> Result<u64> {
        let spp = self
            .whole_spp()
            .filter(|_| self.settings.budget.error.is_none());
        spp.ok_or_else(|| {
            Error::usage(
                "a shard is a part of a known number of samples: give --spp, and no --error; `etendue plan SCENE --shards --error` tells how many samples an error takes",
            )
        })
    }

    /// Checks that the render can have state files.
    ///
    /// # Errors
    /// A greedy adaptive render.
    pub fn check_can_be_kept(&self) -> Result<()> {
        match self.settings.adaptive {
            Adaptive::Off | Adaptive::TwoPhase => Ok(()),
            Adaptive::Greedy => Err(Error::usage(
                "the samples of a greedy adaptive render depend on its passes, so that it has no shards and no checkpoints: use --adaptive, or --adaptive=off",
            )),
        }
    }

    /// The samples per pixel of the whole render, if they are known.
    pub fn whole_spp(&self) -> Option<u64> {
        let spp = self.settings.budget.spp?;
        Some(spp.next_multiple_of(self.settings.spp_step()))
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

    /// The samples that shards of this render divide: all, or those after the pilot.
    ///
    /// # Errors
    /// A render of an unknown number of samples.
    pub fn divisible(&self) -> Result<Range<u64>> {
        let pilot = self.rendered.allocation.as_ref();
        Ok(pilot.map_or(0, |it| it.pilot())..self.known_spp()?)
    }

    /// The samples of the shard, if this is one.
    pub fn shard(&self) -> Option<Range<u64>> {
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
        let existing = ExistingFile::Replace;
        save(header, &self.rendered, layers, path, existing)
    }

    /// The header that state files of this render have in common, for the packages of this workspace.
    ///
    /// # Errors
    /// An error of Embree.
    #[doc(hidden)]
    pub fn header(&self, session: &Session) -> Result<StateHeader> {
        let shard = self.shard.as_ref().map(|it| [it.start, it.end]);
        let description = session.description();
        // An error ends a render before its limit.
        let (spp, limit) = match self.settings.budget.error {
            Some(_) => (None, self.whole_spp()),
            None => (self.whole_spp(), None),
        };
        Ok(StateHeader {
            spp,
            limit,
            shard,
            wants_layers: self.settings.layers,
            bias: self.settings.bias(session.scene.effects),
            ..StateHeader::new(
                self.identity(session)?,
                description.file.display().to_string(),
                self.settings.window,
            )
        })
    }

    /// The identity of scene and settings, for the packages of this workspace.
    ///
    /// # Errors
    /// An error of Embree.
    #[doc(hidden)]
    pub fn identity(&self, session: &Session) -> Result<Fingerprint> {
        if let Some(identity) = self.identity.get() {
            return Ok(identity.clone());
        }
        let identity = fingerprint(&session.description, &self.settings, session.options)?;
        Ok(self.identity.get_or_init(|| identity).clone())
    }

    /// Whether the layers of the first hits belong into the state: into that of one shard, also if time or error ended it. A
    /// render that was interrupted may have little time left, and its first hits cannot be interrupted.
    fn includes_layers(&self) -> bool {
        let Rendered {
            first,
            spp,
            cancelled,
            ..
        } = self.rendered;
        self.settings.layers && first == 0 && spp > 0 && !cancelled
    }

    /// The layers of the whole render's first hits.
    fn layers_of_scene(&self, session: &Session) -> Vec<Layer> {
        let spp = self.whole_spp().unwrap_or(self.rendered.spp);
        layers::of_scene(&session.input(), &self.settings, &self.rendered, spp)
    }
}

/// The samples of a shard that is a part of the pilot of an adaptive render of `spp` samples per pixel.
fn part_of_pilot(shard: Shard, spp: u64) -> Result<Range<u64>> {
    let pilot = Budget::samples(spp).pilot();
    match shard {
        Shard::Samples { end, .. } if end <= pilot => shard.samples(spp),
        Shard::Samples { .. } | Shard::Part { .. } => Err(without_pilot(pilot)),
    }
}

/// The error for samples that a pilot of this many samples has to distribute.
fn without_pilot(pilot: u64) -> Error {
    Error::usage(format!(
        "the samples of an adaptive render are distributed by its pilot, which shards need: render the pilot by --shard 0..{pilot} -o pilot.etd, and give it by --pilot pilot.etd; or use --adaptive=off"
    ))
}

/// Writes the state of a render to a file, given the header of its state files.
///
/// # Errors
/// A file that cannot be written, or is there and to be kept; Markov chains that were interrupted.
pub fn save(
    header: StateHeader,
    rendered: &Rendered,
    layers: Vec<Layer>,
    path: &Path,
    existing: ExistingFile,
) -> Result<()> {
    if header.identity.name("integrator") == IntegratorKind::Metropolis.name() && is_cut(rendered) {
        return Err(Error::usage(
            "the Markov chains were interrupted within a pass, which has to be done again: the last checkpoint is kept",
        )
        .in_file(path));
    }
    let header = header.of(rendered, &layers);
    let allocation = rendered.allocation.as_deref();
    State::write_parts(&header, &rendered.film, &layers, allocation, path, existing)
}

/// Whether Markov chains have splats of a pass that is not complete.
fn is_cut(rendered: &Rendered) -> bool {
    let pixels = rendered.film.window().pixel_count();
    let whole = rendered.spp.saturating_mul(pixels);
    let splats = rendered.film.splats();
    splats.is_some_and(|splats| splats.sample_count() != whole)
}
