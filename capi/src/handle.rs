//! Handles: integers in pointer types, each in a table with its reference count.
//!
//! A number is never reused, so that a released handle is recognised. The tables are the only global state of the
//! library; scenes are independent of each other.
//!
//! Measure: none.
//! Range: any pointer may be looked up; only live handles of the right kind are found.
//! Source: none needed.

use crate::border::{self, LastError};
use crate::status::{CallResult, EtdStatus};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The table of all objects of one kind.
pub struct HandleTable<T> {
    entries: Mutex<Entries<T>>,
    /// The lowest bits of the handles, which identify the kind.
    kind: usize,
}

struct Entries<T> {
    /// The number assigned last.
    last: usize,
    living: BTreeMap<usize, HandleEntry<T>>,
}

struct HandleEntry<T> {
    object: Arc<HandleObject<T>>,
    holders: usize,
}

/// The object of a handle, with the message of its last failure.
pub struct HandleObject<T> {
    pub value: T,
    pub errors: LastError,
}

/// Handles are multiples of this number plus their kind.
const STEP: usize = 16;

impl<T> HandleTable<T> {
    /// Returns an empty table, for handles of a kind below 16.
    pub const fn new(kind: usize) -> Self {
        Self {
            entries: Mutex::new(Entries {
                last: 0,
                living: BTreeMap::new(),
            }),
            kind,
        }
    }

    /// Adds an object with a reference count of 1.
    pub fn add<H>(&self, value: T) -> *mut H {
        let object = Arc::new(HandleObject {
            value,
            errors: LastError::default(),
        });
        let mut entries = self.lock();
        entries.last += 1;
        let number = entries.last * STEP + self.kind;
        entries
            .living
            .insert(number, HandleEntry { object, holders: 1 });
        std::ptr::without_provenance_mut(number)
    }

    /// Returns the object of a handle.
    pub fn get<H>(&self, handle: *const H) -> Option<Arc<HandleObject<T>>> {
        let entries = self.lock();
        let entry = entries.living.get(&handle.addr())?;
        Some(Arc::clone(&entry.object))
    }

    /// Executes a call with a handle.
    pub fn call<H>(&self, handle: *const H, work: impl FnOnce(&T) -> CallResult) -> EtdStatus {
        match self.get(handle) {
            Some(object) => border::call(&object.errors, || work(&object.value)),
            None => EtdStatus::InvalidHandle,
        }
    }

    /// Increments the reference count.
    pub fn retain<H>(&self, handle: *const H) -> EtdStatus {
        match self.lock().living.get_mut(&handle.addr()) {
            Some(entry) => {
                entry.holders += 1;
                EtdStatus::Ok
            }
            None => EtdStatus::InvalidHandle,
        }
    }

    /// Decrements the reference count; at 0 the object is dropped once the calls that use it have ended.
    pub fn release<H>(&self, handle: *const H) -> EtdStatus {
        let mut entries = self.lock();
        let Some(entry) = entries.living.get_mut(&handle.addr()) else {
            return EtdStatus::InvalidHandle;
        };
        entry.holders -= 1;
        if entry.holders == 0 {
            let dropped = entries.living.remove(&handle.addr());
            // Not while the table is locked: dropping may take long.
            drop(entries);
            drop(dropped);
        }
        EtdStatus::Ok
    }

    fn lock(&self) -> MutexGuard<'_, Entries<T>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
