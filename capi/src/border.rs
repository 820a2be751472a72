//! The boundary to C: every call passes through it, and panics are caught.
//!
//! Measure: none.
//! Range: any call.
//! Source: none needed.

use crate::status::{CallResult, EtdStatus, Failure};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

/// The message of the last failure of a handle.
#[derive(Debug, Default)]
pub struct LastError(Mutex<String>);

impl LastError {
    fn set(&self, text: String) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = text;
    }

    /// Returns the message.
    pub fn get(&self) -> String {
        let text = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        text.clone()
    }
}

/// Executes a call, and stores the message if it fails.
pub fn call(errors: &LastError, work: impl FnOnce() -> CallResult) -> EtdStatus {
    // State that a panic leaves inconsistent is behind locks that it poisons, or was never shared.
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let words = words.or_else(|| panic.downcast_ref::<String>().cloned());
        let words = words.unwrap_or_else(|| "a panic without a message".to_owned());
        Err(Failure::new(EtdStatus::Internal, words))
    });
    match outcome {
        Ok(status) => status,
        Err(Failure { status, text }) => {
            errors.set(text);
            status
        }
    }
}
