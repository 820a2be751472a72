//! Checks of the available memory before large allocations.
//!
//! Rust aborts the process if an allocation fails, and systems overcommit memory. Hence allocations whose size depends
//! on the input are checked before they are made, and a lack of memory is reported as an error.
//!
//! Measure: bytes.
//! Range: small allocations are never refused. Linux reports the memory left on the machine, not in a container;
//! elsewhere only what the allocator refuses is refused. Memory that other processes take between the check and the
//! allocation is not accounted for.
//! Source: proc(5). Tested below, in `tests/scene_memory.rs` and `tests/film_memory.rs`, and by `tests/clients/limits.c`.

use crate::error::{Error, ErrorKind, Result};

/// The largest allocation, in bytes, that is not checked, because the check takes longer than a small render.
const SMALL: u64 = 1 << 26;

/// Checks that there is memory for `what`, which takes this many bytes.
///
/// # Errors
/// [`ErrorKind::Memory`] if there is not.
pub fn check(bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
    if bytes <= SMALL {
        return Ok(());
    }
    let left = available();
    // The allocator applies the limits of this process.
    let may_have = |bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok();
    if left.is_none_or(|left| bytes <= left) && usize::try_from(bytes).is_ok_and(may_have) {
        return Ok(());
    }
    let of_left = match left {
        Some(left) => format!(", and the machine has {} left", gigabytes(left)),
        None => String::new(),
    };
    let message = format!(
        "there is no memory for {}: it takes {}{of_left}",
        what(),
        gigabytes(bytes)
    );
    Err(Error::new(ErrorKind::Memory, message))
}

fn gigabytes(bytes: u64) -> String {
    format!("{:.1} GB", 1e-9 * bytes as f64)
}

/// The number of bytes that the machine has left, including reclaimable caches and free swap; `None` if the system does
/// not report it.
pub fn available() -> Option<u64> {
    let facts = std::fs::read_to_string("/proc/meminfo").ok()?;
    let memory = entry(&facts, "MemAvailable:")?;
    Some(memory + entry(&facts, "SwapFree:").unwrap_or(0))
}

/// An entry of `/proc/meminfo`, in bytes.
fn entry(facts: &str, name: &str) -> Option<u64> {
    let line = facts.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_allocation_is_a_memory_error_naming_its_purpose() {
        assert!(check(SMALL, || unreachable!("it is not asked for")).is_ok());
        for bytes in [1 << 60, u64::MAX] {
            let error = check(bytes, || "a tower".to_owned()).expect_err("an exabyte");
            assert_eq!(error.kind(), ErrorKind::Memory);
            let words = error.to_string();
            assert!(words.contains("no memory for a tower"), "{words}");
        }
    }

    #[test]
    fn meminfo_entries_are_converted_to_bytes() {
        let facts = "MemTotal: 9 kB\nMemAvailable:    1000 kB\nSwapFree:  24 kB\n";
        assert_eq!(entry(facts, "MemAvailable:"), Some(1_024_000));
        assert_eq!(entry(facts, "SwapFree:"), Some(24 * 1024));
        assert_eq!(entry(facts, "Nothing:"), None);
        #[cfg(target_os = "linux")]
        assert!(available().is_some_and(|left| left > SMALL));
    }
}
