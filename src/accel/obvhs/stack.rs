//! The traversal stack.
//!
//! Measure: none.
//! Range: any depth. The depth of a tree of degenerate shapes has no fixed bound, and obvhs's own stacks drop nodes
//! when they are full; beyond the depth of balanced trees this stack uses the heap.
//! Source: none needed. Tested below.

/// A stack whose first `N` entries need no heap allocation.
pub struct Stack<T, const N: usize> {
    fixed: [T; N],
    count: usize,
    beyond: Vec<T>,
}

impl<T: Copy + Default, const N: usize> Stack<T, N> {
    /// Creates an empty stack.
    #[inline]
    pub fn new() -> Self {
        Self {
            fixed: [T::default(); N],
            count: 0,
            beyond: Vec::new(),
        }
    }

    /// Pushes an entry.
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

    /// Pops the top entry.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        if self.count == N
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
    fn stack_pops_in_reverse_order_beyond_its_fixed_capacity() {
        let mut stack = Stack::<usize, 8>::new();
        for count in [0, 1, 7, 8, 9, 40] {
            (0..count).for_each(|entry| stack.push(entry));
            for entry in (0..count).rev() {
                assert_eq!(stack.pop(), Some(entry), "of {count}");
            }
            assert_eq!(stack.pop(), None);
        }
    }
}
