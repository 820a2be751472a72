//! Handles: numbers in the clothes of pointers, each in a table with how often it is held.
//!
//! A number is never given twice, so that what was released stays known as such. The table is all that the library keeps for
//! the process; two scenes know nothing of each other.
//!
//! Measure: none.
//! Range: any pointer may be asked for; only living handles of the right kind are found.
//! Source: none needed.

use crate::border::{self, LastError};
use crate::status::{EtdStatus, Outcome};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What handles of one kind stand for.
pub struct Table<T> {
    entries: Mutex<Entries<T>>,
    /// What tells kinds apart: the lowest bits of their handles.
    kind: usize,
}

struct Entries<T> {
    /// The number given last.
    last: usize,
    living: BTreeMap<usize, Entry<T>>,
}

struct Entry<T> {
    object: Arc<Object<T>>,
    holders: usize,
}

/// What a handle stands for, with the text of its last failure.
pub struct Object<T> {
    pub value: T,
    pub errors: LastError,
}

/// Handles are multiples of this, and their kind.
const STEP: usize = 16;

impl<T> Table<T> {
    /// An empty table, for handles of a kind below 16.
    pub const fn new(kind: usize) -> Self {
        Self {
            entries: Mutex::new(Entries {
                last: 0,
                living: BTreeMap::new(),
            }),
            kind,
        }
    }

    /// Takes something in; it is held once.
    pub fn add<H>(&self, value: T) -> *mut H {
        let object = Arc::new(Object {
            value,
            errors: LastError::default(),
        });
        let mut entries = self.lock();
        entries.last += 1;
        let number = entries.last * STEP + self.kind;
        entries.living.insert(number, Entry { object, holders: 1 });
        std::ptr::without_provenance_mut(number)
    }

    /// What a handle stands for.
    pub fn get<H>(&self, handle: *const H) -> Option<Arc<Object<T>>> {
        let entries = self.lock();
        let entry = entries.living.get(&handle.addr())?;
        Some(Arc::clone(&entry.object))
    }

    /// A call with a handle.
    pub fn call<H>(&self, handle: *const H, work: impl FnOnce(&T) -> Outcome) -> EtdStatus {
        match self.get(handle) {
            Some(object) => border::call(&object.errors, || work(&object.value)),
            None => EtdStatus::InvalidHandle,
        }
    }

    /// Holds it once more.
    pub fn retain<H>(&self, handle: *const H) -> EtdStatus {
        match self.lock().living.get_mut(&handle.addr()) {
            Some(entry) => {
                entry.holders += 1;
                EtdStatus::Ok
            }
            None => EtdStatus::InvalidHandle,
        }
    }

    /// Holds it once less; what nobody holds is dropped when the calls that use it have ended.
    pub fn release<H>(&self, handle: *const H) -> EtdStatus {
        let mut entries = self.lock();
        let Some(entry) = entries.living.get_mut(&handle.addr()) else {
            return EtdStatus::InvalidHandle;
        };
        entry.holders -= 1;
        if entry.holders == 0 {
            let dropped = entries.living.remove(&handle.addr());
            // Not while others wait for the table: it may take long.
            drop(entries);
            drop(dropped);
        }
        EtdStatus::Ok
    }

    fn lock(&self) -> MutexGuard<'_, Entries<T>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
