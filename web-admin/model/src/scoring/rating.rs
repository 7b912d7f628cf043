//! Results of several raters for the same attempts: scores of the instrument, means and agreement.

use std::collections::BTreeMap;

use assessment::questionnaire::{self, Answer};
use assessment::statistics::{IntraclassCorrelation, NotComputable, intraclass_correlation};
use documents::Instrument;
use documents::instrument::ScoreKey;

use crate::ids::{PersonId, SessionId};

/// A rating: attempt, rater and, once it is finished, the answers in the order of the instrument's
/// items.
#[derive(Clone, Copy, Debug)]
pub struct RatingAnswers<'a> {
    /// Attempt.
    pub session: SessionId,
    /// Rater.
    pub rater: PersonId,
    /// Answers; `None` until it is finished.
    pub answers: Option<&'a [Option<Answer>]>,
}

/// A score of the instrument for all attempts and raters.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreTable {
    /// Title.
    pub title: String,
    /// Smallest and largest possible value.
    pub range: (f64, f64),
    /// One row per attempt with one score per rater, if there is one.
    pub rows: Vec<Vec<Option<f64>>>,
    /// Agreement over the attempts that all raters have scored.
    pub agreement: Result<IntraclassCorrelation, NotComputable>,
}

impl ScoreTable {
    /// Computes the agreement on a score of the instrument, from one row per attempt with one score
    /// per rater.
    #[must_use]
    pub fn new(instrument: &Instrument, key: &ScoreKey, rows: Vec<Vec<Option<f64>>>) -> Self {
        Self {
            title: key.title.in_language(words::current().code()).to_owned(),
            range: questionnaire::score_range(instrument, key),
            agreement: agreement_of_raters(&rows),
            rows,
        }
    }

    /// Returns the number of attempts that all raters have scored, and of those with missing
    /// scores.
    #[must_use]
    pub fn complete_and_missing(&self) -> (usize, usize) {
        let complete = self.rows.iter().filter(|row| row.iter().all(Option::is_some)).count();
        (complete, self.rows.len() - complete)
    }
}

/// Returns one table per score of the instrument. Attempts and raters are in the order of the
/// slices.
#[must_use]
pub fn tables(
    instrument: &Instrument,
    attempts: &[SessionId],
    raters: &[PersonId],
    given: &[RatingAnswers<'_>],
) -> Vec<ScoreTable> {
    let finished: BTreeMap<(SessionId, PersonId), &[Option<Answer>]> =
        given.iter().filter_map(|given| Some(((given.session, given.rater), given.answers?))).collect();
    let score = |key: &ScoreKey| {
        let cell = |attempt: SessionId, rater: &PersonId| {
            finished
                .get(&(attempt, *rater))
                .and_then(|answers| questionnaire::score_response(instrument, key, answers).ok())
        };
        let row = |attempt: &SessionId| raters.iter().map(|rater| cell(*attempt, rater)).collect();
        ScoreTable::new(instrument, key, attempts.iter().map(row).collect())
    };
    instrument.scores.iter().map(score).collect()
}

/// Minimum number of attempts for computing agreement: with two, it is almost arbitrary.
const FEWEST_ATTEMPTS: usize = 3;

/// Computes the raters' agreement, from at least [`FEWEST_ATTEMPTS`] attempts that all of them
/// scored.
fn agreement_of_raters(rows: &[Vec<Option<f64>>]) -> Result<IntraclassCorrelation, NotComputable> {
    let found = intraclass_correlation(rows)?;
    if found.n < FEWEST_ATTEMPTS {
        return Err(NotComputable::TooFew { found: found.n, needed: FEWEST_ATTEMPTS });
    }
    Ok(found)
}

/// Returns the mean of the present scores, and their number.
#[must_use]
pub fn mean(scores: &[Option<f64>]) -> Option<(f64, usize)> {
    let given: Vec<f64> = scores.iter().flatten().copied().collect();
    let n = u32::try_from(given.len()).ok().filter(|n| *n > 0)?;
    Some((given.iter().sum::<f64>() / f64::from(n), given.len()))
}

#[cfg(test)]
mod tests {
    //! Checks that unfinished ratings do not count, and that missing ones are not treated as 0.

    use super::*;

    const INSTRUMENT: &str = include_str!("../../../../curricula/instruments/global-rating-puncture.toml");

    fn answers(points: [u32; 7]) -> Vec<Option<Answer>> {
        points.into_iter().map(|p| Some(Answer::Number(f64::from(p)))).collect()
    }

    #[test]
    fn what_is_missing_is_left_out_and_counted() {
        let instrument = Instrument::from_bytes("test", INSTRUMENT.as_bytes()).expect("a shipped instrument");
        let (attempts, raters) = ([1, 2, 3].map(SessionId::from_u128), [11, 12].map(PersonId::from_u128));
        let said = [[1; 7], [2; 7], [4; 7], [5; 7], [3; 7]].map(answers);
        let given = |attempt: usize, rater: usize, answers| RatingAnswers {
            session: attempts[attempt],
            rater: raters[rater],
            answers,
        };
        let list = [
            given(0, 0, Some(&said[0][..])),
            given(0, 1, Some(&said[1])),
            given(1, 0, Some(&said[2])),
            given(1, 1, Some(&said[3])),
            given(2, 0, Some(&said[4])),
            given(2, 1, None),
        ];
        let table = &tables(&instrument, &attempts, &raters, &list)[0];
        assert_eq!(table.rows, [vec![Some(7.0), Some(14.0)], vec![Some(28.0), Some(35.0)], vec![Some(21.0), None]]);
        assert_eq!(table.complete_and_missing(), (2, 1));
        assert_eq!(table.agreement, Err(NotComputable::TooFew { found: 2, needed: 3 }), "two attempts tell nothing");
        let three = agreement_of_raters(&[[1.0, 2.0], [3.0, 4.0], [2.0, 2.0]].map(|row| row.map(Some).to_vec()));
        assert_eq!(three.map(|found| (found.n, found.raters)), Ok((3, 2)));
        assert_eq!(mean(&table.rows[2]), Some((21.0, 1)));
        assert_eq!(mean(&[None]), None);
        let lonely = &tables(&instrument, &attempts, &raters[..1], &list)[0];
        assert_eq!(lonely.agreement, Err(NotComputable::TooFewItems { found: 1, needed: 2 }));
    }
}
