//! The machine on which a bench runs.
//!
//! Measure: none.
//! Range: the processor's name is known on Linux; elsewhere it is empty.
//! Source: proc(5). Tested in `lab/tests/bench/report.rs`.

use super::report::Machine;
use etendue::internals::accel::embree_info;
use etendue::internals::render::settings::available_threads;
use std::env::consts;

/// Collects the description of the machine.
pub fn machine() -> Machine {
    Machine {
        processor: processor().unwrap_or_default(),
        processors: available_threads(),
        system: format!("{} {}", consts::OS, consts::ARCH),
        embree: embree(),
    }
}

fn processor() -> Option<String> {
    let facts = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = facts.lines().find(|line| line.starts_with("model name"))?;
    let (_, name) = line.split_once(':')?;
    Some(name.trim().to_owned())
}

fn embree() -> String {
    match embree_info() {
        Ok(Some(info)) => format!("{} ({})", info.library_version, info.origin()),
        _ => String::new(),
    }
}
