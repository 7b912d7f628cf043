//! What a round has found, or, to somebody who has yet to rate, how far it is.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::{IntraclassCorrelation, NotComputable};
use model::rating::{ScoreTable, mean};
use time::OffsetDateTime;

use crate::rating::OwnRating;
use crate::{Shell, StatusWord, format};

/// A round of ratings.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "rating/round.html")]
pub struct RoundPage {
    /// Frame.
    pub shell: Shell,
    /// Its address.
    pub href: String,
    /// Title.
    pub title: String,
    /// Title of the instrument.
    pub instrument: String,
    /// Who asked for it.
    pub by: String,
    /// When.
    pub made_at: OffsetDateTime,
    /// The ratings were made by a program.
    pub generated: bool,
    /// The visitor may take it back.
    pub owner: bool,
    /// The visitor's own ratings.
    pub own: Vec<OwnRating>,
    /// Who has done how many; empty for a rater who is not through.
    pub raters: Vec<RaterRow>,
    /// What was found; absent for a rater who is not through.
    pub found: Option<(Vec<RatedAttemptRow>, Vec<ScoreView>)>,
}

/// A rater and how far they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RaterRow {
    /// Name.
    pub name: String,
    /// Finished.
    pub finished: usize,
    /// How many are of attempts that they may see otherwise.
    pub may_know: usize,
    /// Asked for.
    pub of: usize,
}

/// An attempt that was rated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RatedAttemptRow {
    /// Who tried, and the attempt's page, where the visitor may see it.
    pub trainee: Option<(String, String)>,
    /// Title of the exercise.
    pub exercise: String,
    /// When it began.
    pub started_at: Option<OffsetDateTime>,
}

/// A score over all attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreView {
    /// Title.
    pub title: String,
    /// Of each attempt: what each rater gave, and the mean.
    pub rows: Vec<(Vec<Option<f64>>, Option<f64>)>,
    /// Name of the figure, the figure in words, and its interval.
    pub agreement: Vec<(&'static str, String, String)>,
    /// Attempts that every rater has scored, and those that lack a score.
    pub complete: (usize, usize),
}

impl ScoreView {
    /// A table as it is shown.
    #[must_use]
    pub fn new(table: ScoreTable) -> Self {
        let complete = table.complete_and_missing();
        let icc = &table.agreement;
        let agreement = vec![
            say_rating_figure(tr!("ICC(2,1): one rater"), icc, |icc| (Some(icc.single_random), icc.single_random_95)),
            say_rating_figure(tr!("ICC(2,k): the mean of all raters"), icc, |icc| {
                (icc.average_random, icc.average_random_95)
            }),
        ];
        let with_mean = |row: Vec<Option<f64>>| {
            let mean = mean(&row).map(|(mean, _)| mean);
            (row, mean)
        };
        Self { title: table.title, rows: table.rows.into_iter().map(with_mean).collect(), agreement, complete }
    }
}

type Ends = Option<(f64, f64)>;

/// A figure of agreement in words, with its interval.
fn say_rating_figure(
    name: &'static str,
    agreement: &Result<IntraclassCorrelation, NotComputable>,
    pick: fn(&IntraclassCorrelation) -> (Option<f64>, Ends),
) -> (&'static str, String, String) {
    match agreement {
        Ok(found) => {
            let (value, ends) = pick(found);
            let why = || {
                let agreed = found.single_random >= 1.0;
                let too_little = tr!("not computable: the raters agree too little");
                if agreed { tr!("not computable: the raters agree to the last point") } else { too_little }.to_owned()
            };
            let ends = ends.map_or_else(why, |(low, high)| {
                tr!("{low} to {high}", low = format::format_fixed(low, 2), high = format::format_fixed(high, 2))
            });
            (name, value.map_or_else(|| "–".to_owned(), |value| format::format_fixed(value, 2)), ends)
        }
        Err(why) => (name, tr!("not computable: {why}", why = words::phrase(&why.in_words())), "–".to_owned()),
    }
}

impl RoundPage {
    /// Finished ratings of all raters, and all.
    fn done(&self) -> (usize, usize) {
        self.raters.iter().fold((0, 0), |(done, of), rater| (done + rater.finished, of + rater.of))
    }

    fn own_open(&self) -> usize {
        self.own.iter().filter(|own| !own.finished).count()
    }

    /// The first of the visitor's ratings that is not finished.
    fn next(&self) -> Option<&OwnRating> {
        self.own.iter().find(|own| !own.finished)
    }
}

#[cfg(test)]
mod tests {
    //! Fails when agreement is shown without what it rests on, or a rater is told what others gave.

    use crate::rating::samples::{round_page, show};

    #[test]
    fn what_was_found_stands_beside_what_it_rests_on() {
        let html = show("round", &round_page());
        for wanted in ["ICC(2,1)", "0.29", "0.02 to 0.76", "6 attempts", "ICC(2,k)", "Ada", "5 of 6", "6.0"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn whoever_has_yet_to_rate_sees_no_rating() {
        let page = super::RoundPage { found: None, raters: vec![], ..round_page() };
        let html = show("round-blind", &page);
        assert!(!html.contains("ICC") && !html.contains("Ada") && html.contains("Rate the next"), "{html}");
    }
}
