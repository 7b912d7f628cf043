//! Counts as the database and the pages keep them.

use std::fmt::Debug;

/// A count as a column keeps it.
#[must_use]
#[expect(clippy::expect_used, reason = "nothing that a memory or a disk holds is as many")]
pub fn count_i64<N: TryInto<i64, Error: Debug>>(count: N) -> i64 {
    count.try_into().expect("nothing is counted beyond 2⁶³")
}

/// A count of what a list in memory holds, whose length has a limit.
#[must_use]
#[expect(clippy::expect_used, reason = "lists have limits far below it")]
pub fn count_u32(count: usize) -> u32 {
    count.try_into().expect("no list has 2³² entries")
}
