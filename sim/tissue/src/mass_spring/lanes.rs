//! SIMD vectors: single precision for explicit steps, double precision for everything else.

use std::ops::{Add, Div, Mul, Sub};

use wide::{f32x4, f64x4};

/// Springs that are computed at once: as many `f32` as fit a vector register of every machine.
pub(super) const LANES: usize = 4;

/// A vector of numbers at neighbouring places along x.
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Type of an element.
    type Number: Copy + Default;
    /// The same number in all lanes.
    fn splat(value: f64) -> Self;
    /// Loads the numbers from a place on; 0 where they are out of range.
    fn load(values: &[Self::Number], place: usize) -> Self;
    /// Loads from single-precision numbers.
    fn load_single(values: &[f32], place: usize) -> Self;
    /// Stores the numbers from a place on; does nothing if they do not fit.
    fn store(self, values: &mut [Self::Number], place: usize);
    fn sqrt(self) -> Self;
    fn at_least(self, least: Self) -> Self;
}

/// The numbers from a place on; 0 if they are out of range.
#[inline(always)]
fn chunk<T: Copy + Default>(values: &[T], place: usize) -> [T; LANES] {
    values.get(place..).and_then(|values| values.first_chunk()).copied().unwrap_or_default()
}

macro_rules! lanes {
    ($lanes:ty, $number:ty) => {
        impl Lanes for $lanes {
            type Number = $number;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                Self::splat(value as $number)
            }

            #[inline(always)]
            fn load(values: &[$number], place: usize) -> Self {
                Self::new(chunk(values, place))
            }

            #[inline(always)]
            fn load_single(values: &[f32], place: usize) -> Self {
                Self::new(chunk(values, place).map(<$number>::from))
            }

            #[inline(always)]
            fn store(self, values: &mut [$number], place: usize) {
                if let Some(chunk) = values.get_mut(place..).and_then(|values| values.first_chunk_mut()) {
                    *chunk = self.to_array();
                }
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn at_least(self, least: Self) -> Self {
                self.fast_max(least)
            }
        }
    };
}
lanes!(f32x4, f32);
lanes!(f64x4, f64);
