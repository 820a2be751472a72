//! Metropolis sampling of a density in one dimension: a chain of numbers that need no inverse and no norm.
//!
//! Measure: the density is relative; only ratios of it count.
//! Range: a finite range, and a start of positive density. Proposals outside the range, or where the density is no
//! positive finite number, are rejected. The chain's numbers are correlated, and follow the density only after a while.
//! Source: Metropolis et al. 1953, "Equation of State Calculations by Fast Computing Machines". Both proposals are
//! symmetric, T(x -> y) = T(y -> x), which therefore cancels in the probability of acceptance, min(1, f(y) / f(x)).
//! Tested in `lab/tests/course/metropolis.rs`.

/// How the chain's next number is proposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Proposal {
    /// Anywhere in the range, whatever the state.
    Uniform,
    /// Uniform in an interval around the state.
    Step {
        /// The interval's whole width.
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

/// A chain, and what it counts.
#[derive(Debug, Clone)]
pub struct Chain<F> {
    density: F,
    range: [f64; 2],
    proposal: Proposal,
    x: f64,
    /// The density at x.
    at_x: f64,
    proposed: u64,
    accepted: u64,
}

impl<F: Fn(f64) -> f64> Chain<F> {
    /// A chain that starts at `start`; `None` if it cannot, as it would lie outside the range or at no positive finite
    /// density, or if the proposal has no width.
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

    /// The next number: the proposed one, or where it is rejected, the last one again. Takes two uniform numbers.
    pub fn step(&mut self, uniform: &mut impl FnMut() -> f64) -> f64 {
        let y = self.proposal.propose(self.x, self.range, uniform());
        let choice = uniform();
        self.proposed += 1;
        if (self.range[0]..=self.range[1]).contains(&y) {
            let at_y = (self.density)(y);
            // Accepted with the probability f(y) / f(x), or 1.
            if is_positive(at_y) && choice * self.at_x < at_y {
                (self.x, self.at_x) = (y, at_y);
                self.accepted += 1;
            }
        }
        self.x
    }

    /// The share of proposals that were accepted; `None` before the first.
    pub fn acceptance_rate(&self) -> Option<f64> {
        (self.proposed > 0).then(|| self.accepted as f64 / self.proposed as f64)
    }
}

fn is_positive(density: f64) -> bool {
    density > 0.0 && density.is_finite()
}
