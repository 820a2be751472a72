//! What a traversal has yet to visit.
//!
//! Measure: none.
//! Range: any depth. A tree of degenerate shapes may be deeper than any fixed number, and obvhs's own stacks then forget
//! nodes; beyond what balanced trees need this one goes to the heap.
//! Source: none needed. Tested below.

/// Entries that need no heap: the depth of a balanced binary tree over 2^32 leaves, and half as much again.
const FIXED: usize = 48;

/// A stack.
pub struct Stack<T> {
    fixed: [T; FIXED],
    count: usize,
    beyond: Vec<T>,
}

impl<T: Copy + Default> Stack<T> {
    /// An empty stack.
    #[inline]
    pub fn new() -> Self {
        Self {
            fixed: [T::default(); FIXED],
            count: 0,
            beyond: Vec::new(),
        }
    }

    /// Puts an entry on top.
    #[inline]
    pub fn push(&mut self, entry: T) {
        match self.fixed.get_mut(self.count) {
            Some(place) => {
                *place = entry;
                self.count += 1;
            }
            None => self.beyond.push(entry),
        }
    }

    /// Takes the entry on top.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        if self.count == FIXED
            && let Some(entry) = self.beyond.pop()
        {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.fixed[self.count])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_back_in_reverse_however_many() {
        let mut stack = Stack::new();
        for count in [0, 1, FIXED - 1, FIXED, FIXED + 1, 5 * FIXED] {
            (0..count).for_each(|entry| stack.push(entry));
            for entry in (0..count).rev() {
                assert_eq!(stack.pop(), Some(entry), "of {count}");
            }
            assert_eq!(stack.pop(), None);
        }
    }
}
