//! Planted bugs: wrong variants of right code, each of which a test has to find.
//!
//! `planted!("name", wrong, right)` is `right` and nothing else, unless the crate is compiled with
//! `--cfg etendue_mutants`, which no build without debug assertions can be. Such a build holds all of them, and the
//! environment variable `ETENDUE_MUTANT` says which one is live, if any. `make mutants` makes each of them live in turn.
//!
//! Measure: none.
//! Range: one live bug at most.
//! Source: DeMillo, Lipton and Sayward 1978, "Hints on Test Data Selection". The table of all of them is in
//! `tests/planted/table.rs`, which is held against the sources.

#[cfg(all(etendue_mutants, not(debug_assertions)))]
compile_error!("planted bugs are for tests: no build without debug assertions may hold them");

/// The right expression.
#[cfg(not(etendue_mutants))]
macro_rules! planted {
    ($name:literal, $wrong:expr, $right:expr) => {
        $right
    };
}

/// The right expression, or the wrong one while the bug is live.
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
