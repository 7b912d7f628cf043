//! The two precisions of the kernel: single for explicit steps, of which four fit a vector register of every machine, and
//! double for everything that is solved for.

use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

/// A number of either precision.
pub(super) trait Real:
    Copy
    + Default
    + PartialOrd
    + AddAssign
    + SubAssign
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The nearest.
    fn of(value: f64) -> Self;
    /// The nearest.
    fn of_single(value: f32) -> Self;
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn of_single(value: f32) -> Self {
        Self::from(value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}

impl Real for f32 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn of_single(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}
