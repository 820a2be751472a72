//! SIMD lanes, and functions over them that are compiled for several vector widths.
//!
//! Such a function is a branch-free loop over arrays, which the compiler vectorises for several instruction sets; the
//! version is selected at run time. All versions give the same bits: they differ only in the number of lanes per
//! instruction, while each operation is the one that IEEE 754 prescribes, and none are fused.
//!
//! Measure: as each function says.
//! Range: any processor; one without wider vectors runs the baseline version.
//! Source: none needed. Tested in `tests/sampling/sampler.rs` and `tests/lights/lanes.rs`, lane by lane against
//! single numbers.

/// The number of lanes: a vector of AVX-512.
pub const LANES: usize = 16;

/// The largest number of active lanes that is faster to compute one lane at a time.
pub const MAX_SCALAR_LANES: usize = 3;

/// One number per lane.
pub type Lanes<T> = [T; LANES];

/// A mask of lanes, as Embree reads it: -1 for active lanes, 0 for the others.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveLanes<const N: usize>(pub [i32; N]);

impl<const N: usize> ActiveLanes<N> {
    /// The mask with no active lane.
    pub const NONE: Self = Self([0; N]);

    /// The mask whose first `count` lanes are active.
    #[inline]
    pub fn first(count: usize) -> Self {
        Self(std::array::from_fn(|lane| -i32::from(lane < count)))
    }

    /// Whether a lane is active.
    #[inline(always)]
    pub fn has(&self, lane: usize) -> bool {
        self.0[lane] != 0
    }

    /// Activates or deactivates a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, is_active: bool) {
        self.0[lane] = if is_active { -1 } else { 0 };
    }

    /// Whether any lane is active.
    #[inline]
    pub fn any(&self) -> bool {
        self.0.iter().fold(0, |any, lane| any | lane) != 0
    }

    /// Whether all lanes are active.
    #[inline]
    pub fn all(&self) -> bool {
        self.0.iter().fold(-1, |all, lane| all & lane) != 0
    }

    /// The active lanes, in order.
    #[inline(always)]
    pub fn each(&self) -> impl Iterator<Item = usize> + use<N> {
        let mut bits = (0..N).fold(0_u32, |bits, lane| bits | (self.0[lane] as u32 & 1) << lane);
        std::iter::from_fn(move || {
            let lane = bits.trailing_zeros();
            bits &= bits.wrapping_sub(1);
            (lane < u32::BITS).then_some(lane as usize)
        })
    }
}

impl<const N: usize> ActiveLanes<N> {
    /// The active lanes for which a condition holds. Free of branches if the condition is.
    #[inline(always)]
    pub fn and(&self, condition: impl Fn(usize) -> bool) -> Self {
        let mut lanes = *self;
        for lane in 0..N {
            lanes.0[lane] &= -i32::from(condition(lane));
        }
        lanes
    }

    /// The active lanes that are not active in `other`.
    #[inline]
    pub fn without(&self, other: &Self) -> Self {
        let mut rest = *self;
        for lane in 0..N {
            rest.0[lane] &= !other.0[lane];
        }
        rest
    }

    /// The lanes that are active here or in `other`.
    #[inline]
    pub fn with(&self, other: &Self) -> Self {
        let mut either = *self;
        for lane in 0..N {
            either.0[lane] |= other.0[lane];
        }
        either
    }

    /// The lanes that are not active.
    #[inline]
    pub fn inverse(&self) -> Self {
        let mut inverse = *self;
        for lane in 0..N {
            inverse.0[lane] = !inverse.0[lane];
        }
        inverse
    }

    /// The mask of `M` lanes from `start` on.
    #[inline]
    pub fn part<const M: usize>(&self, start: usize) -> ActiveLanes<M> {
        ActiveLanes(std::array::from_fn(|lane| self.0[start + lane]))
    }

    /// The number of active lanes.
    #[inline]
    pub fn count(&self) -> usize {
        self.0.iter().filter(|&&lane| lane != 0).count()
    }

    /// Two masks: the active lanes of the first half, and those of the second half.
    #[inline]
    pub fn halves(&self) -> [Self; 2] {
        let mut halves = [*self; 2];
        halves[0].0[N / 2..].fill(0);
        halves[1].0[..N / 2].fill(0);
        halves
    }
}

/// One vector, or one colour, per lane: its components one after the other.
pub type Lanes3 = [Lanes<f32>; 3];

/// The vector or colour of a lane.
#[inline(always)]
pub fn load<T: From<[f32; 3]>>(from: &Lanes3, lane: usize) -> T {
    T::from([from[0][lane], from[1][lane], from[2][lane]])
}

/// Sets the vector or colour of a lane.
#[inline(always)]
pub fn store(to: &mut Lanes3, lane: usize, value: impl Into<[f32; 3]>) {
    let [x, y, z] = value.into();
    to[0][lane] = x;
    to[1][lane] = y;
    to[2][lane] = z;
}

/// Applies a function of `M` numbers to each lane. The loop is vectorised if `function` has no branches and the
/// caller is compiled for vectors.
#[inline(always)]
pub fn each_lane<const M: usize, const N: usize>(
    from: &[Lanes<f32>; M],
    to: &mut [Lanes<f32>; N],
    function: impl Fn([f32; M]) -> [f32; N],
) {
    for lane in 0..LANES {
        let results = function(std::array::from_fn(|i| from[i][lane]));
        for (to, result) in to.iter_mut().zip(results) {
            to[lane] = result;
        }
    }
}

/// Compiles a function, which is a loop over lanes, for every vector width.
macro_rules! vectorised {
    ($function:item) => {
        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512bw+avx512dq+avx512vl",
            "x86_64+avx2"
        ))]
        $function
    };
}
pub(crate) use vectorised;
