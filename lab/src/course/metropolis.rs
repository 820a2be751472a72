//! Metropolis sampling of a density in one dimension: a Markov chain that needs neither an inverse nor a normalisation.
//!
//! Measure: the density is relative; only ratios of it matter.
//! Range: a finite range, and a start of positive density. Proposals outside the range, or where the density is not
//! positive and finite, are rejected. The chain's numbers are correlated, and follow the density only after a while.
//! Source: Metropolis et al. 1953, "Equation of State Calculations by Fast Computing Machines". Both proposals are
//! symmetric, T(x -> y) = T(y -> x), which therefore cancels in the probability of acceptance, min(1, f(y) / f(x)).
//! Tested in `lab/tests/course/metropolis.rs`.

/// The proposal distribution of the chain's next number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Proposal {
    /// Uniform in the whole range, independent of the state.
    Uniform,
    /// Uniform in an interval around the state.
    Step {
        /// The full width of the interval.
        width: f64,
    },
}

impl Proposal {
    fn propose(self, x: f64, [a, b]: [f64; 2], u: f64) -> f64 {
        match self {
            Self::Uniform => (1.0 - u) * a + u * b,
            Self::Step { width } => x + (u - 0.5) * width,
        }
    }

    fn is_valid(self) -> bool {
        match self {
            Self::Uniform => true,
            Self::Step { width } => width > 0.0 && width.is_finite(),
        }
    }
}

/// A Markov chain, with the counts of proposed and accepted numbers.
#[derive(Debug, Clone)]
pub struct MarkovChain<F> {
    density: F,
    range: [f64; 2],
    proposal: Proposal,
    x: f64,
    /// The density at x.
    at_x: f64,
    proposed: u64,
    accepted: u64,
}

impl<F: Fn(f64) -> f64> MarkovChain<F> {
    /// A chain that starts at `start`; `None` if the start lies outside the range or has no positive finite density, or
    /// if the proposal has no positive width.
    pub fn new(density: F, range: [f64; 2], proposal: Proposal, start: f64) -> Option<Self> {
        let is_inside =
            (range[0]..=range[1]).contains(&start) && range[0].is_finite() && range[1].is_finite();
        if !is_inside || !proposal.is_valid() {
            return None;
        }
        let at_start = density(start);
        is_positive(at_start).then_some(Self {
            density,
            range,
            proposal,
            x: start,
            at_x: at_start,
            proposed: 0,
            accepted: 0,
        })
    }

    /// Returns the next number: the proposed one, or if it is rejected, the current one again. Uses two uniform
    /// numbers.
    pub fn step(&mut self, uniform: &mut impl FnMut() -> f64) -> f64 {
        let y = self.proposal.propose(self.x, self.range, uniform());
        let choice = uniform();
        self.proposed += 1;
        if (self.range[0]..=self.range[1]).contains(&y) {
            let at_y = (self.density)(y);
            // Accepted with the probability min(1, f(y) / f(x)).
            if is_positive(at_y) && choice * self.at_x < at_y {
                (self.x, self.at_x) = (y, at_y);
                self.accepted += 1;
            }
        }
        self.x
    }

    /// The fraction of proposals that were accepted; `None` before the first.
    pub fn acceptance_rate(&self) -> Option<f64> {
        (self.proposed > 0).then(|| self.accepted as f64 / self.proposed as f64)
    }
}

fn is_positive(density: f64) -> bool {
    density > 0.0 && density.is_finite()
}
