//! Whether `make nightly` runs, which has time for more samples, and for every backend and sampler.
//!
//! Measure: none.
//! Range: `ETENDUE_NIGHTLY` set to anything, or not.
//! Source: none needed. `scripts/not-tested.sh` says what the other runs leave out.

use etendue::internals::accel::Backend;
use etendue::internals::render::settings::SamplerKind;
use std::f64::consts::SQRT_2;

/// The backends on which to render a case of a statistical test: all of them in `make nightly`, else one, which differs from
/// case to case by the name.
pub fn backends(case: &str) -> &'static [Backend] {
    if is_nightly() {
        return Backend::ALL;
    }
    let number: usize = case.bytes().map(usize::from).sum();
    let index = number % Backend::ALL.len();
    &Backend::ALL[index..=index]
}

/// The samplers of a statistical test: all that are given in `make nightly`, else the first.
pub fn samplers(all: &'static [SamplerKind]) -> &'static [SamplerKind] {
    if is_nightly() { all } else { &all[..1] }
}

/// The cases of a statistical test: all of them in `make nightly`, else one of `n` neighbours, beginning with the case `first`.
pub fn one_in<T>(
    n: usize,
    first: usize,
    cases: impl IntoIterator<Item = T>,
) -> impl Iterator<Item = T> {
    let (skipped, step) = if is_nightly() { (0, 1) } else { (first, n) };
    cases.into_iter().skip(skipped).step_by(step)
}

/// The sample count of a comparison of two estimates, and the limit of its relative standard error: these in `make nightly`, else
/// half as many samples, with a limit that is larger by a factor of √2.
pub fn samples_and_limit(samples: u64, limit: f64) -> (u64, f64) {
    if is_nightly() {
        (samples, limit)
    } else {
        (samples / 2, SQRT_2 * limit)
    }
}

/// Whether tests may take long.
pub fn is_nightly() -> bool {
    std::env::var_os("ETENDUE_NIGHTLY").is_some()
}
