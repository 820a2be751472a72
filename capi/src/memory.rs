//! Access to the caller's memory.
//!
//! Measure: bytes.
//! Range: any address but null, aligned or not; the caller guarantees that the stated amount of memory is there. Lengths
//! are checked before anything is read, and the available memory is checked before copies are allocated.
//! Source: none needed.

use crate::status::{EtdStatus, Failure};
use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;

/// Plain numbers: every bit pattern is a valid value.
///
/// # Safety
/// Every bit pattern must be a valid value.
pub unsafe trait Plain: Copy {}

// SAFETY: every bit pattern is a number.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for f64 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {}

/// A structure that begins with its own size, so that later versions can be longer. Zeros stand for missing fields.
///
/// # Safety
/// It is `repr(C)`, begins with a `usize`, and every bit pattern that a C compiler can produce for its fields is a valid
/// value, including zeros.
pub unsafe trait Versioned: Copy {
    /// Its name, for messages.
    const NAME: &'static str;
    /// The size of its first version.
    const FIRST_SIZE: usize = size_of::<Self>();
}

/// Reads a structure of the caller.
///
/// # Safety
/// The pointer is null, or as many bytes may be read as its first field says.
pub unsafe fn read_struct<T: Versioned>(pointer: *const T) -> Result<T, Failure> {
    let size = struct_size(pointer)?;
    let mut copy = MaybeUninit::<T>::zeroed();
    // SAFETY: the bytes are there by the caller's promise, and no more than the copy has; by the trait's promise zeros
    // are valid for the rest, and all bytes that are read are valid.
    unsafe {
        let bytes = copy.as_mut_ptr().cast::<u8>();
        bytes.copy_from_nonoverlapping(pointer.cast::<u8>(), size);
        Ok(copy.assume_init())
    }
}

/// Reads a structure of the caller; null stands for zeros.
///
/// # Safety
/// As [`read_struct`].
pub unsafe fn read_struct_or_zeros<T: Versioned>(pointer: *const T) -> Result<T, Failure> {
    if pointer.is_null() {
        // SAFETY: zeros are a valid value by the trait's promise.
        return Ok(unsafe { MaybeUninit::<T>::zeroed().assume_init() });
    }
    // SAFETY: the caller's promise.
    unsafe { read_struct(pointer) }
}

/// Writes a structure of the caller, except its size, up to the size of the caller's version of it.
///
/// # Safety
/// The pointer is null, or as many bytes may be read and written as its first field says.
pub unsafe fn write_struct<T: Versioned>(pointer: *mut T, value: T) -> Result<(), Failure> {
    let size = struct_size(pointer)?;
    let head = size_of::<usize>();
    // SAFETY: the bytes are there by the caller's promise, and no more than the value has.
    unsafe {
        let from = (&raw const value).cast::<u8>().add(head);
        let to = pointer.cast::<u8>().add(head);
        to.copy_from_nonoverlapping(from, size - head);
    }
    Ok(())
}

fn struct_size<T: Versioned>(pointer: *const T) -> Result<usize, Failure> {
    not_null(pointer, T::NAME)?;
    // SAFETY: the readers' callers promise that the structure's first field, its size, is there.
    let size = unsafe { pointer.cast::<usize>().read_unaligned() };
    if (T::FIRST_SIZE..=size_of::<T>()).contains(&size) {
        return Ok(size);
    }
    Err(Failure::argument(format!(
        "{}: struct_size is {size}, but this library knows sizes from {} to {}: set it to sizeof({})",
        T::NAME,
        T::FIRST_SIZE,
        size_of::<T>(),
        T::NAME
    )))
}

/// Checks that a pointer is not null.
pub fn not_null<T>(pointer: *const T, what: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::argument(format!("{what} is null")));
    }
    Ok(())
}

/// Writes a result through a pointer of the caller.
///
/// # Safety
/// The pointer is null, or may be written through.
pub unsafe fn write<T>(pointer: *mut T, value: T, what: &str) -> Result<(), Failure> {
    not_null(pointer, what)?;
    // SAFETY: the caller's promise.
    unsafe { pointer.write_unaligned(value) };
    Ok(())
}

/// Returns the distance in bytes from one item to the next: `stride`, or that of items without a gap if it is 0.
pub fn checked_stride<T>(count: usize, stride: usize, what: &str) -> Result<usize, Failure> {
    let stride = if stride == 0 { size_of::<T>() } else { stride };
    if stride < size_of::<T>() {
        return Err(Failure::argument(format!(
            "{what}: a stride of {stride} bytes, but the size of an item is {}",
            size_of::<T>()
        )));
    }
    let bytes = count.checked_mul(stride);
    match bytes.filter(|&bytes| isize::try_from(bytes).is_ok()) {
        Some(_) => Ok(stride),
        None => Err(Failure::argument(format!(
            "{what}: {count} items of {stride} bytes exceed the address space"
        ))),
    }
}

/// Copies a list of the caller, whose items begin `stride` bytes apart; 0 means without a gap. The pointer may be null
/// if `count` is 0.
///
/// # Safety
/// The pointer is null, or all items may be read.
pub unsafe fn read_list<T: Plain>(
    pointer: *const c_void,
    count: usize,
    stride: usize,
    what: &str,
) -> Result<Vec<T>, Failure> {
    if count == 0 {
        return Ok(vec![]);
    }
    not_null(pointer, what)?;
    let stride = checked_stride::<T>(count, stride, what)?;
    let mut items = room(count, what)?;
    for index in 0..count {
        // SAFETY: the item is there by the caller's promise; alignment is not required, and any bits are a valid value.
        items.push(unsafe {
            pointer
                .cast::<u8>()
                .add(index * stride)
                .cast::<T>()
                .read_unaligned()
        });
    }
    Ok(items)
}

/// Allocates memory for `count` items, or reports that there is not enough.
pub fn room<T>(count: usize, what: &str) -> Result<Vec<T>, Failure> {
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    renderer::memory::check(bytes, || format!("{count} items of {what}"))?;
    let mut items = Vec::new();
    items.try_reserve_exact(count).map_err(|_| {
        let text = format!("{what}: there is no memory for {count} items");
        Failure::new(EtdStatus::OutOfMemory, text)
    })?;
    Ok(items)
}

/// Writes items to the caller's memory, `stride` bytes apart; 0 means without a gap.
///
/// # Safety
/// The pointer is null, or all items may be written.
pub unsafe fn write_list<T: Copy>(
    pointer: *mut c_void,
    stride: usize,
    items: impl ExactSizeIterator<Item = T>,
    what: &str,
) -> Result<(), Failure> {
    if items.len() == 0 {
        return Ok(());
    }
    not_null(pointer, what)?;
    let stride = checked_stride::<T>(items.len(), stride, what)?;
    for (index, item) in items.enumerate() {
        // SAFETY: the item may be written by the caller's promise, whatever its alignment.
        unsafe {
            let place = pointer.cast::<u8>().add(index * stride);
            place.cast::<T>().write_unaligned(item);
        }
    }
    Ok(())
}

/// Returns a string of the caller; `None` for null.
///
/// # Safety
/// The pointer is null, or a NUL-terminated string is there, unchanged while it is used.
pub unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    match text.to_str() {
        Ok(text) => Ok(Some(text)),
        Err(_) => Err(Failure::argument(format!("{what} is not UTF-8"))),
    }
}

/// Copies a text to the caller's memory, truncated to its size and NUL-terminated, and returns its full length.
///
/// # Safety
/// `capacity` bytes may be written, unless the pointer is null.
pub unsafe fn write_text(text: &str, pointer: *mut c_char, capacity: usize) -> usize {
    if !pointer.is_null() && capacity > 0 {
        let mut end = text.len().min(capacity - 1);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        // SAFETY: one byte fewer than the capacity at most, and then one more.
        unsafe {
            let bytes = pointer.cast::<u8>();
            bytes.copy_from_nonoverlapping(text.as_ptr(), end);
            bytes.add(end).write(0);
        }
    }
    text.len()
}
