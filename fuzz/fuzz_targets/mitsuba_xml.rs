#![no_main]

use etendue_fuzz::MITSUBA_XML;
use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fuzz_target!(|bytes: &[u8]| MITSUBA_XML.feed(bytes, &MEMORY));
