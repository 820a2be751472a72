//! Facts about the Embree library of a build, for reports of the platform.
//!
//! Measure: none.
//! Range: any build; there are none in a build without Embree.
//! Source: `embree/info.rs`, which queries the library. Tested in `cli/tests/command/render.rs`.

use std::path::PathBuf;

/// Facts about the linked Embree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmbreeInfo {
    /// The version of the headers that the program was built with.
    pub header_version: String,
    /// The version of the loaded library.
    pub library_version: String,
    /// The file that the library was loaded from; known on Linux only.
    pub library: Option<PathBuf>,
    /// The packet widths that the library traces natively on this machine.
    pub native_widths: Vec<usize>,
}

impl EmbreeInfo {
    /// Whether library and headers are compatible, that is, have the same major version. Embree keeps its interface
    /// within a major version.
    pub fn fits(&self) -> bool {
        let major = |version: &str| version.split('.').next().map(str::to_owned);
        major(&self.header_version) == major(&self.library_version)
    }

    /// The origin of the library, without naming a directory, since reports are passed on.
    pub fn origin(&self) -> &'static str {
        let system = ["/usr", "/lib", "/lib64", "/opt"];
        match &self.library {
            None => "unknown origin",
            Some(file) if system.iter().any(|folder| file.starts_with(folder)) => "system",
            Some(_) => "private copy",
        }
    }
}
