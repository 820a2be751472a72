//! Numbers side by side, and functions of them that are compiled for the processor's vectors.
//!
//! Such a function is a plain loop over arrays, free of branches, which the compiler turns into vectors as wide as a processor
//! has them; which of its versions runs is decided when the program does. All of them give the same bits: they differ in how
//! many lanes they take at a time, while each operation is the one that IEEE 754 prescribes, and none are fused.
//!
//! Measure: as each function says.
//! Range: any processor; one without wider vectors runs what it always has.
//! Source: none needed. Tested in `tests/sampling/sampler.rs` and `tests/lights/lanes.rs`, lane by lane against
//! single numbers.

/// How many numbers lie side by side: a vector of AVX-512.
pub const LANES: usize = 16;

/// So few are quicker one by one.
pub const FEW: usize = 3;

/// Numbers side by side.
pub type Lanes<T> = [T; LANES];

/// A function of some numbers for each lane. It becomes vectors where it has no branches and where it is called in a function that
/// is compiled for them.
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

/// Compiles a function, which is a loop over lanes, for every width of vectors.
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
