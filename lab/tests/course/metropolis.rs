//! Tests of Metropolis chains in one dimension: the target density is stationary, the chains converge to it from any
//! start, and the acceptance rates are exact.

use crate::common::TestRng;
use crate::common::chi_square::uniformity;
use crate::common::verdict::{assert_mean, sidak};
use etendue::internals::math::stats::Moments;
use etendue_lab::course::metropolis::{MarkovChain, Proposal};

const CHAINS: u32 = 1 << 16;
const PROPOSALS: [Proposal; 4] = [
    Proposal::Uniform,
    Proposal::Step { width: 0.1 },
    Proposal::Step { width: 0.7 },
    Proposal::Step { width: 3.0 },
];

/// The density 2 x on [0, 1], times a constant that the chain does not need to know.
fn ramp(x: f64) -> f64 {
    17.0 * x
}

fn chain(proposal: Proposal, start: f64) -> MarkovChain<fn(f64) -> f64> {
    MarkovChain::new(ramp as fn(f64) -> f64, [0.0, 1.0], proposal, start).expect("a valid start")
}

/// The p-value of the final states of independent chains of `steps` steps, if they follow the density 2 x.
fn p_after(seed: u64, steps: u32, proposal: Proposal, start: impl Fn(f64) -> f64) -> f64 {
    let mut rng = TestRng::new(seed);
    let mut counts = vec![0; 128];
    for _ in 0..CHAINS {
        let mut chain = chain(proposal, start(rng.uniform_f64()));
        let mut x = 0.0;
        for _ in 0..steps {
            x = chain.step(&mut || rng.uniform_f64());
        }
        // x^2 is uniform.
        counts[((128.0 * x * x) as usize).min(127)] += 1;
    }
    uniformity(&counts)
}

#[test]
fn target_density_is_stationary_under_metropolis_steps() {
    for (seed, proposal) in (1..).zip(PROPOSALS) {
        let p = p_after(seed, 5, proposal, |u| (1.0 - u).sqrt());
        assert!(p > sidak(1e-3, PROPOSALS.len()), "{proposal:?}: {p:.1e}");
    }
}

#[test]
fn metropolis_chain_converges_from_extreme_starts() {
    // With uniform proposals and a density of at most 2, the total variation distance is at most 2^-steps (Mengersen and
    // Tweedie 1996). Steps of 0.7 mix about as fast. Steps of 0.1 have not converged yet, which the test detects.
    for (seed, proposal) in (11..).zip([Proposal::Uniform, Proposal::Step { width: 0.7 }]) {
        for start in [1e-3, 1.0] {
            let p = p_after(seed, 100, proposal, |_| start);
            assert!(p > sidak(1e-3, 4), "{proposal:?} {start}: {p:.1e}");
        }
    }
    let p = p_after(13, 100, Proposal::Step { width: 0.1 }, |_| 1e-3);
    assert!(p < 1e-12, "{p:.1e}");
}

/// Runs chains of 200 steps that start from the density; returns the means of x and the acceptance rates.
fn chains(seed: u64, proposal: Proposal, count: u32) -> (Moments, Moments) {
    let mut rng = TestRng::new(seed);
    let (mut means, mut rates) = (Moments::default(), Moments::default());
    for _ in 0..count {
        let mut chain = chain(proposal, (1.0 - rng.uniform_f64()).sqrt());
        assert_eq!(chain.acceptance_rate(), None);
        let mut sum = 0.0;
        for _ in 0..200 {
            let x = chain.step(&mut || rng.uniform_f64());
            assert!((0.0..=1.0).contains(&x));
            sum += x;
        }
        means.push(sum / 200.0);
        rates.push(chain.acceptance_rate().expect("200 steps"));
    }
    (means, rates)
}

/// The acceptance rate for the density 2 x: the mean of min(p(x), p(y)) over all proposals. With the half width h <= 1
/// it is (2 / h) (h (1 - h)^2 / 2 + integral of x (1 - x) over [1 - h, 1]), which is 1 - h + h^2 / 3; with h >= 1 it is
/// 1 / (3 h).
fn exact_rate(proposal: Proposal) -> f64 {
    match proposal {
        Proposal::Uniform => 2.0 / 3.0,
        Proposal::Step { width } => {
            let h = 0.5 * width;
            if h < 1.0 {
                1.0 - h + h * h / 3.0
            } else {
                1.0 / (3.0 * h)
            }
        }
    }
}

#[test]
fn chain_means_and_acceptance_rates_match_exact_values() {
    for (seed, proposal) in (21..).zip(PROPOSALS) {
        let (means, rates) = chains(seed, proposal, 40_000);
        assert_mean(&format!("mean of x, {proposal:?}"), &means, 2.0 / 3.0, 2e-3);
        assert_mean(
            &format!("rate, {proposal:?}"),
            &rates,
            exact_rate(proposal),
            2e-3,
        );
    }
}

#[test]
fn chain_stays_in_domain_and_invalid_starts_are_rejected() {
    for proposal in PROPOSALS {
        for u in [0.0, 1.0 - 1.0 / 16_777_216.0] {
            for v in [0.0, 1.0 - 1.0 / 16_777_216.0] {
                let mut chain = chain(proposal, 0.3);
                let mut numbers = [u, v].into_iter().cycle();
                for _ in 0..10 {
                    let x = chain.step(&mut || numbers.next().expect("an endless iterator"));
                    assert!(x > 0.0 && x <= 1.0, "{proposal:?} {u} {v}: {x}");
                }
            }
        }
    }
    let start = |proposal, range, at| MarkovChain::new(ramp, range, proposal, at).is_some();
    let step = |width| Proposal::Step { width };
    assert!(start(step(0.1), [0.0, 1.0], 1.0));
    for refused in [
        start(Proposal::Uniform, [0.0, 1.0], 0.0),
        start(Proposal::Uniform, [0.0, 1.0], 1.5),
        start(Proposal::Uniform, [0.0, 1.0], f64::NAN),
        start(Proposal::Uniform, [0.0, f64::INFINITY], 1.0),
        start(Proposal::Uniform, [1.0, 0.0], 0.5),
        start(step(0.0), [0.0, 1.0], 0.5),
        start(step(f64::INFINITY), [0.0, 1.0], 0.5),
        MarkovChain::new(|_| f64::INFINITY, [0.0, 1.0], Proposal::Uniform, 0.5).is_some(),
    ] {
        assert!(!refused);
    }
    // The chain never moves to where the density is NaN, infinite or negative.
    for hole in [f64::NAN, f64::INFINITY, -1.0] {
        let density = |x: f64| if x < 0.5 { 1.0 } else { hole };
        let chain = MarkovChain::new(density, [0.0, 1.0], Proposal::Uniform, 0.2);
        let mut chain = chain.expect("a valid start");
        let mut rng = TestRng::new(31);
        assert!((0..1000).all(|_| chain.step(&mut || rng.uniform_f64()) < 0.5));
    }
}
