//! Raw bindings to Intel Embree 4, made from the headers of the Embree that is linked.
//!
//! Names, types and meanings are Embree's own; its manual documents them. What bindgen leaves
//! out are the inline functions: start ray arguments from `Default`, set `tfar`, `mask` and
//! `hit.geomID`, and pass null for the arguments of a query unless they are needed.
//!
//! Tested in `tests/known_hit.rs`.

#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals
)]
#[allow(clippy::all, rustdoc::all)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

pub use bindings::*;

/// Fields of a hit: nine, but before Embree 4.3 brought instance arrays, eight.
const HIT: usize = if RTC_VERSION >= 40300 { 9 } else { 8 };
/// Bytes of an `RTCHit`, which fills up to its alignment as packets need not.
const HIT_BYTES: usize = (4 * HIT).next_multiple_of(16);

/// The layouts that Etendue relies on. bindgen has checked every field against the headers;
/// this fixes the headers themselves, as an Embree built with more instance levels than one
/// writes longer hits. The library cannot be asked for that: its user has to try a known hit.
const _: () = {
    assert!(RTC_VERSION_MAJOR >= 4);
    assert!(RTC_MAX_INSTANCE_LEVEL_COUNT == 1);
    layout::<RTCRay>(48, 16);
    layout::<RTCHit>(HIT_BYTES, 16);
    layout::<RTCRayHit>(48 + HIT_BYTES, 16);
    layout::<RTCRay4>(4 * 48, 16);
    layout::<RTCRay8>(8 * 48, 32);
    layout::<RTCRay16>(16 * 48, 64);
    layout::<RTCHit4>(4 * 4 * HIT, 16);
    layout::<RTCHit8>(8 * 4 * HIT, 32);
    layout::<RTCHit16>(16 * 4 * HIT, 64);
    layout::<RTCRayHit4>(4 * (48 + 4 * HIT), 16);
    layout::<RTCRayHit8>(8 * (48 + 4 * HIT), 32);
    layout::<RTCRayHit16>(16 * (48 + 4 * HIT), 64);
    layout::<RTCRayQueryContext>(4 * (HIT - 7), 4);
    layout::<RTCIntersectArguments>(32, 8);
    layout::<RTCOccludedArguments>(32, 8);
};

/// Fails to compile unless `T` has this size and alignment in bytes.
const fn layout<T>(size: usize, align: usize) {
    assert!(size_of::<T>() == size && align_of::<T>() == align);
}
