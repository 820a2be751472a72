//! The Embree that a build has, for those that report what they ran on.
//!
//! Measure: none.
//! Range: any build; one without Embree has none.
//! Source: `embree/info.rs`, which asks the library. Tested in `cli/tests/command/render.rs`.

use std::path::PathBuf;

/// Facts about the linked Embree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmbreeInfo {
    /// Version of the headers that the program was built with.
    pub header_version: String,
    /// Version of the library that runs.
    pub library_version: String,
    /// The file that the library was loaded from; known on Linux alone.
    pub library: Option<PathBuf>,
    /// Packet widths that the library traces natively on this machine.
    pub native_widths: Vec<usize>,
}

impl EmbreeInfo {
    /// Whether library and headers go together: the same major version, and a library that is not older in what the
    /// headers promise. Embree keeps its interface within a major version.
    pub fn fits(&self) -> bool {
        let major = |version: &str| version.split('.').next().map(str::to_owned);
        major(&self.header_version) == major(&self.library_version)
    }

    /// Where the library comes from, without naming a folder: reports are passed on.
    pub fn origin(&self) -> &'static str {
        let system = ["/usr", "/lib", "/lib64", "/opt"];
        match &self.library {
            None => "unknown origin",
            Some(file) if system.iter().any(|folder| file.starts_with(folder)) => "system",
            Some(_) => "private copy",
        }
    }
}
