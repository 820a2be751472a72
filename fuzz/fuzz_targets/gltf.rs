#![no_main]

use etendue_fuzz::GLTF;
use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fuzz_target!(|bytes: &[u8]| GLTF.feed(bytes, &MEMORY));
