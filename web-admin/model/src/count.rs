//! Conversion of counts for the database and the pages.

use std::fmt::Debug;

/// Converts a count for a database column.
#[must_use]
#[expect(clippy::expect_used, reason = "nothing that a memory or a disk holds is as many")]
pub fn count_i64<N: TryInto<i64, Error: Debug>>(count: N) -> i64 {
    count.try_into().expect("nothing is counted beyond 2⁶³")
}

/// An optional count in a database column. It is read as a signed integer, because not every
/// database has unsigned ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type), sqlx(transparent))]
pub struct StoredCount(Option<i64>);

impl TryFrom<StoredCount> for Option<u32> {
    type Error = std::num::TryFromIntError;

    fn try_from(StoredCount(count): StoredCount) -> Result<Self, Self::Error> {
        count.map(u32::try_from).transpose()
    }
}

/// Converts the number of entries of a list or query, whose length is limited.
#[must_use]
#[expect(clippy::expect_used, reason = "lists have limits far below it, and nobody has as many rows")]
pub fn count_u32<N: TryInto<u32, Error: Debug>>(count: N) -> u32 {
    count.try_into().expect("no list has 2³² entries")
}
