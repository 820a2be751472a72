//! Whether `make nightly` runs, which has time for more samples and for every backend.
//!
//! Measure: none.
//! Range: `ETENDUE_NIGHTLY` set to anything, or not.
//! Source: none needed. `scripts/not-tested.sh` says what the other runs leave out.

use etendue::internals::accel::Backend;

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

/// Whether tests may take long.
pub fn is_nightly() -> bool {
    std::env::var_os("ETENDUE_NIGHTLY").is_some()
}
