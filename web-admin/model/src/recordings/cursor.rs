//! Cursor in a list of attempts.

use std::fmt;
use std::str::FromStr;

use crate::Moment;
use crate::ids::SessionId;

/// Cursor in a list of attempts, newest first. The entries after it stay the same when new attempts
/// are added at the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttemptPlace {
    /// Start time.
    pub started_at: Moment,
    /// Session.
    pub id: SessionId,
}

impl AttemptPlace {
    /// Position before all attempts.
    pub const START: Self = Self { started_at: Moment::from_micros(i64::MAX), id: SessionId::from_u128(u128::MAX) };
}

impl fmt::Display for AttemptPlace {
    /// Formats the cursor for API clients, which return it unchanged.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.started_at.micros(), self.id)
    }
}

/// The text is not a valid cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("invalid cursor: pass `next` from the previous page")]
pub struct NoPlace;

impl FromStr for AttemptPlace {
    type Err = NoPlace;

    fn from_str(text: &str) -> Result<Self, NoPlace> {
        let (started_at, id) = text.split_once('.').ok_or(NoPlace)?;
        let started_at = started_at.parse().map(Moment::from_micros).map_err(|_| NoPlace)?;
        Ok(Self { started_at, id: id.parse().map_err(|_| NoPlace)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_comes_back_as_it_was_said_and_nothing_else_is_one() {
        let place = AttemptPlace { started_at: Moment::from_micros(-5), id: SessionId::from_u128(7) };
        assert_eq!(place.to_string().parse(), Ok(place));
        for nonsense in ["", ".", "5", "x.y", "5.7", "9999999999999999999.00000000-0000-0000-0000-000000000007"] {
            assert_eq!(nonsense.parse::<AttemptPlace>(), Err(NoPlace), "{nonsense}");
        }
    }
}
