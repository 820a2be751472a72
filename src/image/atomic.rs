//! Files that appear whole or not at all: written under a temporary name in the same folder, then renamed.
//!
//! Measure: none.
//! Range: any path; an existing file stays as it was until the new one is complete.
//! Source: rename(2) replaces a file in one step. Tested below.

use crate::error::{Error, Result};
use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Lets `fill` write the file, and puts it in its place if that went well.
///
/// # Errors
/// What `fill` or the file system says; then nothing has changed.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut NamedTempFile>) -> io::Result<()>,
) -> Result<()> {
    let failed = |error| Error::io("cannot write", path, error);
    let mut file = create_beside(path).map_err(failed)?;
    let mut writer = BufWriter::new(&mut file);
    fill(&mut writer)
        .and_then(|()| writer.flush())
        .map_err(failed)?;
    drop(writer);
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Whether a file could be put there.
///
/// # Errors
/// If not; nothing is left behind either way.
pub fn check_place(path: &Path) -> Result<()> {
    let failed = |error| Error::io("cannot write", path, error);
    if path.is_dir() {
        return Err(failed(io::Error::from(io::ErrorKind::IsADirectory)));
    }
    create_beside(path).map_err(failed)?.close().map_err(failed)
}

/// A temporary file in the folder of `path`, which vanishes unless it is persisted.
fn create_beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let mut builder = tempfile::Builder::new();
    // As any other new file: what the process's umask leaves of it.
    #[cfg(unix)]
    builder.permissions(<Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    builder
        .prefix(".etendue-")
        .suffix(".part")
        .tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.txt");
        write_atomically(&path, |file| file.write_all(b"old")).expect("the folder is writable");
        let failure = write_atomically(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(
            failure
                .expect_err("it failed")
                .to_string()
                .contains("the disk is full")
        );
        assert_eq!(std::fs::read(&path).expect("it is still there"), b"old");
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("it exists").count(),
            1
        );
    }

    #[test]
    fn a_place_where_nothing_can_be_written_is_found_out_early() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(check_place(&folder.path().join("a.png")).is_ok());
        assert!(check_place(&folder.path().join("none/a.png")).is_err());
        assert!(check_place(folder.path()).is_err());
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("it exists").count(),
            0
        );
    }
}
