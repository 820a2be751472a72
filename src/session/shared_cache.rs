//! The irradiance cache of a rendering in a file, so that the shards of a render, and a render that is interrupted, fill it once.
//!
//! Measure: as in `integrator/irradiance_cache/`.
//! Range: renders by `irradiance-cache`.
//! Source: none needed. Tested in `cli/tests/command/shared_cache.rs`.

use super::{Rendering, Session};
use crate::error::{Error, Result};
use crate::integrator::kind::IntegratorKind;
use crate::render::{RenderObserver, fill_cache};
use crate::state::cache_file;
use std::path::Path;

impl Rendering {
    /// Takes the irradiance cache from a file, if it is there; else fills the cache and writes it, unless the observer
    /// cancels that.
    ///
    /// # Errors
    /// Another integrator, a file that cannot be read or written, or the cache of another render.
    pub fn share_cache(
        &mut self,
        session: &Session,
        path: &Path,
        observer: &dyn RenderObserver,
    ) -> Result<()> {
        self.check_session(session)?;
        if self.settings.integrator != IntegratorKind::IrradianceCache {
            return Err(Error::usage(format!(
                "a cache is shared by renders by irradiance-cache, and this one is by {}",
                self.settings.integrator.name()
            )));
        }
        let identity = self.identity(session)?;
        if path.exists() {
            let cache = cache_file::read(path, &identity, self.settings.cache_error)?;
            self.rendered.cache = Some(cache);
            return Ok(());
        }
        fill_cache(
            &session.input(),
            &session.threads,
            &self.settings,
            &mut self.rendered,
            observer,
        )?;
        match &self.rendered.cache {
            Some(cache) => cache_file::write(cache, &identity, path),
            // It was cancelled.
            None => Ok(()),
        }
    }
}
