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

/// The largest count that is faster one by one.
pub const FEW: usize = 3;

/// One number per lane.
pub type Lanes<T> = [T; LANES];

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
