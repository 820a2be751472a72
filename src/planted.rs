//! Planted bugs: wrong variants of correct code, each of which a test must detect.
//!
//! `planted!("name", wrong, right)` expands to `right` only, unless the crate is compiled with `--cfg etendue_mutants`,
//! which requires debug assertions. Such a build contains all planted bugs, and the environment variable
//! `ETENDUE_MUTANT` names the active one, if any. `make mutants` activates each of them in turn.
//!
//! Measure: none.
//! Range: at most one active bug.
//! Source: DeMillo, Lipton and Sayward 1978, "Hints on Test Data Selection". The table of all planted bugs is in
//! `tests/planted/table.rs`, which is checked against the sources.

#[cfg(all(etendue_mutants, not(debug_assertions)))]
compile_error!("planted bugs are for tests: no build without debug assertions may hold them");

/// Expands to the correct expression.
#[cfg(not(etendue_mutants))]
macro_rules! planted {
    ($name:literal, $wrong:expr, $right:expr) => {
        $right
    };
}

/// Expands to the correct expression, or to the wrong one while the bug is active.
#[cfg(etendue_mutants)]
macro_rules! planted {
    ($name:literal, $wrong:expr, $right:expr) => {{
        static IS_LIVE: std::sync::LazyLock<bool> = std::sync::LazyLock::new(|| {
            std::env::var("ETENDUE_MUTANT").is_ok_and(|it| it == $name)
        });
        if *IS_LIVE { $wrong } else { $right }
    }};
}

pub(crate) use planted;
