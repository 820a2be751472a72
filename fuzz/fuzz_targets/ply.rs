#![no_main]

use etendue_fuzz::PLY;
use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fuzz_target!(|bytes: &[u8]| PLY.feed(bytes, &MEMORY));
