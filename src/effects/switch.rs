//! Effects as types: compile-time switches for the code of each effect, and state that exists only if it is on.
//!
//! Measure: none.
//! Range: [`Slot`]s of an absent effect have size zero.
//! Source: none needed. Tested below and in `tests/rendering/effects.rs`.

use super::{Effect, EffectSet};
use std::fmt::Debug;

/// A switch that is on or off at compile time.
pub trait Switch: Debug + Clone + Copy + Send + Sync + 'static {
    /// Whether the switch is on.
    const ON: bool;
    /// Storage for a value, if the switch is on.
    type Of<T: Copy + Debug>: Slot<T>;
}

/// The switch of an effect that is compiled in.
#[derive(Debug, Clone, Copy)]
pub struct On;

/// The switch of an effect that is left out.
#[derive(Debug, Clone, Copy)]
pub struct Off;

impl Switch for On {
    const ON: bool = true;
    type Of<T: Copy + Debug> = Present<T>;
}

impl Switch for Off {
    const ON: bool = false;
    type Of<T: Copy + Debug> = Absent;
}

/// Storage for a value that only some kernels need.
pub trait Slot<T: Copy>: Copy + Debug {
    /// Creates the storage, and the value if it is stored.
    fn new(make: impl FnOnce() -> T) -> Self;
    /// Returns the value, or `absent` if none is stored.
    fn or(self, absent: T) -> T;
    /// The value by reference, if one is stored.
    fn get(&self) -> Option<&T>;
    /// The value by mutable reference, if one is stored.
    fn get_mut(&mut self) -> Option<&mut T>;
    /// Changes the value, if one is stored.
    fn update(&mut self, change: impl FnOnce(T) -> T);
}

/// The storage for a value of type `T` under the switch `S`.
pub type EffectState<S, T> = <S as Switch>::Of<T>;

/// A stored value.
#[derive(Debug, Clone, Copy)]
pub struct Present<T>(T);

/// A value that is not stored.
#[derive(Debug, Clone, Copy)]
pub struct Absent;

impl<T: Copy + Debug> Slot<T> for Present<T> {
    #[inline(always)]
    fn new(make: impl FnOnce() -> T) -> Self {
        Self(make())
    }
    #[inline(always)]
    fn or(self, _absent: T) -> T {
        self.0
    }
    #[inline(always)]
    fn get(&self) -> Option<&T> {
        Some(&self.0)
    }
    #[inline(always)]
    fn get_mut(&mut self) -> Option<&mut T> {
        Some(&mut self.0)
    }
    #[inline(always)]
    fn update(&mut self, change: impl FnOnce(T) -> T) {
        self.0 = change(self.0);
    }
}

impl<T: Copy> Slot<T> for Absent {
    #[inline(always)]
    fn new(_make: impl FnOnce() -> T) -> Self {
        Self
    }
    #[inline(always)]
    fn or(self, absent: T) -> T {
        absent
    }
    #[inline(always)]
    fn get(&self) -> Option<&T> {
        None
    }
    #[inline(always)]
    fn get_mut(&mut self) -> Option<&mut T> {
        None
    }
    #[inline(always)]
    fn update(&mut self, _change: impl FnOnce(T) -> T) {}
}

/// Declares [`Effects`], with one type for each effect.
macro_rules! effects {
    ($($effect:ident)*) => {
        /// The effects that a kernel is compiled for.
        pub trait Effects: Debug + Clone + Copy + Send + Sync + 'static {
            $(#[doc = concat!("Whether it has [`Effect::", stringify!($effect), "`].")]
            type $effect: Switch;)*

            /// All effects of the kernel as a set.
            const SET: EffectSet = EffectSet::NONE
                $(.with_if(Effect::$effect, <Self::$effect as Switch>::ON))*;
        }
    };
}

effects! {
    ShadingNormals Textures NormalMaps Alpha OneSided Glossy Specular Transmission Lens Motion
    Environment EnvironmentMap DeltaLights AreaLights ManyLights Instances LightPaths Reuse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disabled_slot_is_zero_sized_and_ignores_updates() {
        let mut off = EffectState::<Off, u64>::new(|| unreachable!("nothing is made"));
        off.update(|_| unreachable!("nothing is changed"));
        assert_eq!((size_of_val(&off), off.or(3)), (0, 3));
        let mut on = EffectState::<On, u64>::new(|| 5);
        on.update(|x| x + 1);
        assert_eq!((size_of_val(&on), on.or(3)), (8, 6));
    }
}
