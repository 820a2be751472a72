//! The folders in which a file of a Mitsuba scene looks for the files that it names.
//!
//! Measure: none.
//! Range: the folders of elements `path`, the last one first; the file's own; then those of the files that include it. A
//! name that none of them has is taken in the file's own folder.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba_files.rs`.

use super::super::within;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The folders of one file. A file has to be read to its end before all of them are known.
#[derive(Debug, Default)]
pub struct Folders {
    /// The folders of elements `path`, in their order.
    added: RefCell<Vec<PathBuf>>,
    /// The folder of the file.
    own: PathBuf,
    /// The folders of the file that includes it.
    outer: Option<Rc<Folders>>,
}

impl Folders {
    /// The folders of a file, which another one includes or not.
    pub fn of_file(path: &Path, outer: Option<&Rc<Self>>) -> Rc<Self> {
        Rc::new(Self {
            added: RefCell::default(),
            own: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            outer: outer.map(Rc::clone),
        })
    }

    /// Adds the folder of an element `path`.
    pub fn add(&self, folder: PathBuf) {
        self.added.borrow_mut().push(folder);
    }

    /// The first file of this name that exists.
    pub fn find(&self, name: &str) -> PathBuf {
        self.existing(name)
            .unwrap_or_else(|| within(&self.own, name))
    }

    fn existing(&self, name: &str) -> Option<PathBuf> {
        let added = self.added.borrow();
        let mut own = added.iter().rev().chain([&self.own]);
        let found = own.find_map(|folder| {
            let file = within(folder, name);
            file.exists().then_some(file)
        });
        found.or_else(|| self.outer.as_ref()?.existing(name))
    }
}
