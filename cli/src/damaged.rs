//! Damaged state files that are set aside, for jobs that nobody watches.
//!
//! Measure: none.
//! Range: any file; only one whose checksum is not that of its contents is renamed.
//! Source: none needed. Tested in `cli/tests/command/checkpoints.rs`, `cli/tests/command/shards.rs` and
//! `cli/tests/command/slurm_scripts.rs`.

use etendue::internals::state::is_damaged;
use etendue::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Renames a state file to FILE.damaged if it is damaged, and returns a sentence that says so.
///
/// # Errors
/// A file that cannot be read or renamed.
pub fn set_aside(file: &Path) -> Result<Option<String>> {
    if !is_damaged(file)? {
        return Ok(None);
    }
    let aside = free_name(file);
    fs::rename(file, &aside).map_err(|error| Error::io("cannot rename", file, error))?;
    Ok(Some(format!(
        "{}: is a damaged state file: its checksum is not that of its contents; it is now {}",
        file.display(),
        aside.display()
    )))
}

/// The first free name of FILE.damaged, FILE.damaged-2 and so on.
fn free_name(file: &Path) -> PathBuf {
    let name = |count: u32| {
        let mut name = file.as_os_str().to_owned();
        name.push(match count {
            1 => ".damaged".to_owned(),
            _ => format!(".damaged-{count}"),
        });
        PathBuf::from(name)
    };
    let mut names = (1..).map(name);
    let free = names.find(|name| name.symlink_metadata().is_err());
    free.expect("a folder has fewer files than there are numbers")
}
