//! Atomic file writing: a temporary file in the same folder, which is then renamed. Also creation of folders.
//!
//! Measure: none.
//! Range: any path in an existing folder that can be written to. On failure an existing file is unchanged, and no new
//! file remains. A link stays, and the file that it leads to is replaced; what is no file, such as a device, is written to.
//! Source: rename(2) replaces its target in one step. Tested below.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// The treatment of a file that is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExistingFile {
    /// It is replaced.
    Replace,
    /// It is kept, and writing fails, also if it appears only meanwhile.
    Keep,
}

/// Replaces the file at `path` atomically by the output of `write`.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<()> {
    write_beside(path, ExistingFile::Replace, write)
}

/// Writes a temporary file and renames it.
fn write_beside(
    path: &Path,
    existing: ExistingFile,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<()> {
    let cannot_write = |cause| Error::io("cannot write", path, cause);
    let fill = |file: &mut File| {
        let mut writer = BufWriter::new(file);
        write(&mut writer).and_then(|()| writer.flush())
    };
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if is_device(&target) {
        let device = File::options().write(true).open(&target);
        return device
            .and_then(|mut device| fill(&mut device))
            .map_err(cannot_write);
    }
    let mut temporary = create_beside(&target).map_err(cannot_write)?;
    fill(temporary.as_file_mut()).map_err(cannot_write)?;
    // Some file systems report only now that there is no room.
    temporary.as_file().sync_all().map_err(cannot_write)?;
    let persisted = match existing {
        ExistingFile::Replace => temporary.persist(&target),
        ExistingFile::Keep => temporary.persist_noclobber(&target),
    };
    persisted.map_err(|failure| cannot_write(failure.error))?;
    Ok(())
}

/// Writes the output of `write` to a file at `path`, atomically also if the power fails: the file is on the disk before
/// it is renamed.
pub fn write_durably(
    path: &Path,
    existing: ExistingFile,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<()> {
    write_beside(path, existing, write)?;
    // Where a folder cannot be opened, the new name is on the disk somewhat later.
    if let Ok(folder) = File::open(folder_of(path)) {
        folder
            .sync_all()
            .map_err(|cause| Error::io("cannot write", path, cause))?;
    }
    Ok(())
}

/// Whether there is something at `path` that is neither a file nor a folder.
fn is_device(path: &Path) -> bool {
    path.metadata()
        .is_ok_and(|it| !it.is_file() && !it.is_dir())
}

/// Replaces the file at `path` atomically by `text`.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |writer| writer.write_all(text.as_bytes()))
}

/// Creates a folder and its missing parents.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::io("cannot make the folder", folder, error))
}

/// Checks that [`write_atomically`] could write to `path` now.
pub fn check_creatable(path: &Path) -> Result<()> {
    let cannot_write = |cause| Error::io("cannot write", path, cause);
    if path.is_dir() {
        return Err(cannot_write(io::ErrorKind::IsADirectory.into()));
    }
    if is_device(path) {
        return File::options()
            .write(true)
            .open(path)
            .map(drop)
            .map_err(cannot_write);
    }
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    // Dropping the temporary file removes it.
    create_beside(&target).map(drop).map_err(cannot_write)
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Creates an empty temporary file in the folder of `path`, with the permissions of an ordinary new file.
fn create_beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(path);
    let mut builder = Builder::new();
    builder.prefix(".etendue-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The process's umask applies; with the default mode only the owner could read the file.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    // The file's name in the error would be the temporary one, which the user does not know.
    builder
        .tempfile_in(folder)
        .map_err(|error| match error.kind() {
            kind @ io::ErrorKind::NotFound => io::Error::new(kind, "there is no such folder"),
            kind => io::Error::from(kind),
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    fn names(folder: &Path) -> Vec<String> {
        let entries = folder.read_dir().expect("a folder");
        entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect()
    }

    #[test]
    fn atomic_write_replaces_the_file_with_default_permissions() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        for content in ["old and long", "new"] {
            write_atomically(&path, |writer| writer.write_all(content.as_bytes()))
                .expect("written");
            assert_eq!(std::fs::read_to_string(&path).expect("read"), content);
        }
        assert_eq!(names(folder.path()), ["a.txt"]);

        let ordinary = folder.path().join("ordinary");
        std::fs::write(&ordinary, "").expect("written");
        let permissions = |path| std::fs::metadata(path).expect("a file").permissions();
        assert_eq!(permissions(&path), permissions(&ordinary));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_are_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, link] = ["a.txt", "link.txt"].map(|name| folder.path().join(name));
        std::fs::write(&file, "old").expect("written");
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        write_text(&link, "new").expect("written");
        assert_eq!(std::fs::read_to_string(&file).expect("read"), "new");
        assert!(link.is_symlink());
        let null = Path::new("/dev/null");
        check_creatable(null).expect("writable");
        write_text(null, "nothing").expect("written");
        assert!(is_device(null));
    }

    #[test]
    fn failed_atomic_write_keeps_the_old_file_and_no_temporary() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        std::fs::write(&path, "old").expect("written");
        let error = write_atomically(&path, |writer| {
            writer.write_all(b"half of the n")?;
            Err(io::Error::other("disk on fire"))
        })
        .expect_err("failed");
        assert_eq!(error.kind(), ErrorKind::Io);
        assert_eq!(error.file(), Some(path.as_path()));
        assert_eq!(std::fs::read_to_string(&path).expect("read"), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn existing_files_are_kept_on_request() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let write = |text: &'static str| {
            write_durably(&path, ExistingFile::Keep, |writer| {
                writer.write_all(text.as_bytes())
            })
        };
        write("first").expect("written");
        let error = write("second").expect_err("there is a file");
        assert_eq!(error.file(), Some(path.as_path()));
        assert_eq!(std::fs::read_to_string(&path).expect("read"), "first");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn check_creatable_predicts_failures_without_side_effects() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        check_creatable(&path).expect("creatable");
        assert!(names(folder.path()).is_empty());
        std::fs::write(&path, "old").expect("written");
        check_creatable(&path).expect("replaceable");
        assert_eq!(std::fs::read_to_string(&path).expect("read"), "old");

        let missing_folder = folder.path().join("missing").join("a.txt");
        for bad in [
            missing_folder,
            path.join("below a file"),
            folder.path().into(),
        ] {
            let error = check_creatable(&bad).expect_err("not creatable");
            assert_eq!(error.kind(), ErrorKind::Io);
            assert_eq!(error.file(), Some(bad.as_path()));
            assert!(write_atomically(&bad, |_| Ok(())).is_err());
        }
        assert_eq!(names(folder.path()), ["a.txt"]);
    }
}
