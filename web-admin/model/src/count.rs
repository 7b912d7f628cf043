//! Counts as the database and the pages keep them.

use std::fmt::Debug;

/// A count as a column keeps it.
#[must_use]
#[expect(clippy::expect_used, reason = "nothing that a memory or a disk holds is as many")]
pub fn count_i64<N: TryInto<i64, Error: Debug>>(count: N) -> i64 {
    count.try_into().expect("nothing is counted beyond 2⁶³")
}

/// A count as a column keeps it that may be absent: it is read as a signed number, which every database has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type), sqlx(transparent))]
pub struct StoredCount(Option<i64>);

impl TryFrom<StoredCount> for Option<u32> {
    type Error = std::num::TryFromIntError;

    fn try_from(StoredCount(count): StoredCount) -> Result<Self, Self::Error> {
        count.map(u32::try_from).transpose()
    }
}

/// A count of what a list or a query finds, whose length has a limit.
#[must_use]
#[expect(clippy::expect_used, reason = "lists have limits far below it, and nobody has as many rows")]
pub fn count_u32<N: TryInto<u32, Error: Debug>>(count: N) -> u32 {
    count.try_into().expect("no list has 2³² entries")
}
