//! Queue of attempts waiting for review: priorities, filters and cursors.

use std::fmt;
use std::str::FromStr;

use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};

use crate::ids::CohortId;
use crate::recordings::cursor::{AttemptPlace, NoPlace};

/// Reason for reviewing an attempt before others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReviewReason {
    /// It has an unanswered question.
    Question,
    /// The re-simulation differs.
    Flagged,
    /// It failed.
    Failed,
}

impl ReviewReason {
    /// All reasons, most urgent first.
    pub const ALL: [Self; 3] = [Self::Question, Self::Flagged, Self::Failed];

    /// Returns the name used in URLs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Question => "question",
            Self::Flagged => "flagged",
            Self::Failed => "failed",
        }
    }

    /// Returns the contribution to the rank.
    const fn weight(self) -> u32 {
        match self {
            Self::Question => 4,
            Self::Flagged => 2,
            Self::Failed => 1,
        }
    }
}

/// Filter of the queue.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReviewFilter {
    /// Only attempts with this reason.
    pub reason: Option<ReviewReason>,
    /// Only attempts of this cohort's trainees.
    pub cohort: Option<CohortId>,
    /// Only attempts at this exercise, by its id.
    pub exercise: Option<String>,
}

/// Filter as given in a URL or form; empty fields do not restrict it.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(default)]
pub struct AskedReviews {
    /// Name of the reason.
    pub what: String,
    /// Id of the cohort.
    pub cohort: String,
    /// Id of the exercise.
    pub exercise: String,
}

impl ReviewFilter {
    /// Parses a filter from a URL. Invalid values do not restrict it.
    #[must_use]
    pub fn asked(asked: &AskedReviews) -> Self {
        Self {
            reason: ReviewReason::ALL.into_iter().find(|known| known.name() == asked.what),
            cohort: asked.cohort.parse().ok(),
            exercise: Some(asked.exercise.clone()).filter(|id| !id.is_empty()),
        }
    }

    /// Returns the ranks that match the filter, most urgent first.
    pub fn ranks(&self) -> impl Iterator<Item = u32> + use<> {
        let reason = self.reason;
        (0..8).rev().filter(move |rank| reason.is_none_or(|reason| rank & reason.weight() != 0))
    }

    /// Returns the filter as a query string without the question mark; empty without restrictions.
    #[must_use]
    pub fn query(&self) -> String {
        let reason = self.reason.map(|reason| format!("what={}", reason.name()));
        let cohort = self.cohort.map(|cohort| format!("cohort={cohort}"));
        let exercise =
            self.exercise.as_ref().map(|id| format!("exercise={}", utf8_percent_encode(id, NON_ALPHANUMERIC)));
        reason.into_iter().chain(cohort).chain(exercise).collect::<Vec<_>>().join("&")
    }
}

/// Cursor in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueuePlace {
    /// Rank of the last attempt on the previous page.
    pub rank: u32,
    /// Position of that attempt within its rank.
    pub place: AttemptPlace,
}

impl fmt::Display for QueuePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.rank, self.place)
    }
}

impl FromStr for QueuePlace {
    type Err = NoPlace;

    fn from_str(text: &str) -> Result<Self, NoPlace> {
        let (rank, place) = text.split_once('.').ok_or(NoPlace)?;
        Ok(Self { rank: rank.parse().map_err(|_| NoPlace)?, place: place.parse()? })
    }
}

#[cfg(test)]
mod tests {
    //! Checks that a filter selects only ranks that include its reason, and that its query string
    //! is parsed to the same filter.

    use super::*;
    use crate::Moment;
    use crate::ids::SessionId;

    #[test]
    fn questions_come_before_flags_and_flags_before_failures() {
        assert_eq!(ReviewFilter::default().ranks().collect::<Vec<_>>(), [7, 6, 5, 4, 3, 2, 1, 0]);
        let ranks =
            |reason| ReviewFilter { reason: Some(reason), ..ReviewFilter::default() }.ranks().collect::<Vec<_>>();
        assert_eq!(ranks(ReviewReason::Question), [7, 6, 5, 4]);
        assert_eq!(ranks(ReviewReason::Flagged), [7, 6, 3, 2]);
        assert_eq!(ranks(ReviewReason::Failed), [7, 5, 3, 1]);
    }

    #[test]
    fn a_filter_and_a_place_come_back_as_they_were_said() {
        let exercise = Some("a&b".to_owned());
        let filter = ReviewFilter { reason: Some(ReviewReason::Failed), cohort: Some(CohortId::nil()), exercise };
        let query = filter.query();
        assert_eq!(query, format!("what=failed&cohort={}&exercise=a%26b", CohortId::nil()));
        let [what, cohort, exercise] = ["failed".to_owned(), CohortId::nil().to_string(), "a&b".to_owned()];
        assert_eq!(ReviewFilter::asked(&AskedReviews { what, cohort, exercise }), filter);
        let [what, cohort, exercise] = ["loud", "x", ""].map(str::to_owned);
        assert_eq!(ReviewFilter::asked(&AskedReviews { what, cohort, exercise }), ReviewFilter::default());
        let place = AttemptPlace { started_at: Moment::from_micros(5), id: SessionId::from_u128(7) };
        let place = QueuePlace { rank: 3, place };
        assert_eq!(place.to_string().parse(), Ok(place));
        assert_eq!("3".parse::<QueuePlace>(), Err(NoPlace));
    }
}
