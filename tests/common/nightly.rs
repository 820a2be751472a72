//! Whether `make nightly` runs, which has time for more samples.
//!
//! Measure: none.
//! Range: `ETENDUE_NIGHTLY` set to anything, or not.
//! Source: none needed. `scripts/not-tested.sh` says what the other runs leave out.

/// Whether tests may take long.
pub fn is_nightly() -> bool {
    std::env::var_os("ETENDUE_NIGHTLY").is_some()
}
