//! The page of an exam: its candidates, both ratings, and their agreement.

use askama::Template;
use askama_web::WebTemplate;
use model::scoring::exam::SittingStage;
use time::OffsetDateTime;

use super::{SittingClock, say_score};
use crate::scoring::rating::ScoreView;
use crate::{Shell, StatusWord, format};

/// The page of an exam.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/exams/exam.html")]
pub struct ExamPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the page.
    pub href: String,
    /// Title.
    pub title: String,
    /// Name and address of the cohort.
    pub cohort: (String, String),
    /// Title of the exercise.
    pub exercise: String,
    /// Title of the instrument.
    pub instrument: String,
    /// Title of the score that the page compares.
    pub score: String,
    /// Time limit, in min.
    pub limit_min: u32,
    /// When it was closed.
    pub closed_at: Option<OffsetDateTime>,
    /// Candidates by family name.
    pub rows: Vec<CandidateRow>,
    /// The second ratings, if the exam has a second rater.
    pub second: Option<SecondRatings>,
    /// Whether the visitor is the second rater, who only rates.
    pub is_second_rater: bool,
    /// Time at which the page was made.
    pub now: OffsetDateTime,
}

/// The second ratings of an exam.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondRatings {
    /// Name of the second rater.
    pub rater: String,
    /// Address of the round.
    pub round: Option<String>,
    /// Number of attempts for which no second rating was requested yet.
    pub waiting: usize,
    /// Agreement of both ratings; `None` if it is not for the visitor to see yet.
    pub agreement: Option<ScoreView>,
}

/// A candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateRow {
    /// Name.
    pub name: String,
    /// Address of the station.
    pub href: String,
    /// Times of the sitting; `None` if it has not begun.
    pub clock: Option<SittingClock>,
    /// Name of the examiner.
    pub examiner: String,
    /// Address of the attempt.
    pub attempt: Option<String>,
    /// Whether the attempt is not scored yet.
    pub is_pending: bool,
    /// Whether no station signed the attempt, so that its start is the sender's claim.
    pub is_unsigned: bool,
    /// First rating.
    pub first: Option<f64>,
    /// Whether a second rating was requested.
    pub is_sent: bool,
    /// Second rating.
    pub second: Option<f64>,
    /// Whether ratings are hidden from the visitor, who has yet to rate.
    pub is_hidden: bool,
}

impl CandidateRow {
    /// Returns the second rating minus the first.
    #[must_use]
    pub fn difference(&self) -> Option<f64> {
        Some(self.second? - self.first?)
    }

    fn say_difference(&self) -> String {
        self.difference().map_or_else(|| "–".to_owned(), |by| format!("{}{}", sign(by), say_score(by.abs())))
    }

    fn is_finished(&self) -> bool {
        self.clock.is_some_and(|clock| clock.finished_at.is_some())
    }
}

fn sign(by: f64) -> &'static str {
    if by > 0.0 {
        "+"
    } else if by < 0.0 {
        "−"
    } else {
        ""
    }
}

/// Numbers of candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExamCounts {
    /// Not begun.
    pub not_begun: usize,
    /// Begun and not finished.
    pub running: usize,
    /// Finished.
    pub finished: usize,
    /// Finished after the time limit.
    pub late: usize,
    /// Finished without an attempt.
    pub without_attempt: usize,
}

impl ExamPage {
    fn say_points(points: &f64) -> String {
        say_score(points)
    }

    /// Counts the candidates.
    #[must_use]
    pub fn counts(&self) -> ExamCounts {
        let count = |is: fn(&CandidateRow) -> bool| self.rows.iter().filter(|row| is(row)).count();
        ExamCounts {
            not_begun: count(|row| row.clock.is_none()),
            running: count(|row| row.clock.is_some() && !row.is_finished()),
            finished: count(CandidateRow::is_finished),
            late: count(|row| row.clock.is_some_and(|clock| clock.stage == SittingStage::FinishedLate)),
            without_attempt: count(|row| row.is_finished() && row.attempt.is_none()),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    //! The second rater must not see a first rating before rating.

    use model::Role;
    use model::scoring::rating::ScoreTable;

    use super::super::samples::{checklist, clock};
    use super::*;
    use crate::samples;

    fn row(name: &str, clock: Option<SittingClock>, ratings: [Option<f64>; 2]) -> CandidateRow {
        CandidateRow {
            name: name.to_owned(),
            href: "/exams/1/candidates/1".to_owned(),
            examiner: clock.map_or_else(String::new, |_| "Dr Osei".to_owned()),
            attempt: ratings[0].map(|_| "/sessions/1".to_owned()),
            is_pending: false,
            is_unsigned: name == "Ben",
            first: ratings[0],
            is_sent: ratings[1].is_some(),
            second: ratings[1],
            is_hidden: false,
            clock,
        }
    }

    fn exam_page() -> ExamPage {
        let rated = [[9.0, 8.0], [7.0, 7.0], [4.0, 5.0]].map(|pair| pair.map(Some));
        let mut rows = vec![
            row("Ada <Okafor>", Some(clock(3000, Some(480))), rated[0]),
            row("Ben", Some(clock(2000, Some(690))), rated[1]),
            row("Cleo", Some(clock(1500, Some(500))), rated[2]),
            row("Dan", Some(clock(200, None)), [None, None]),
            row("Eve", Some(clock(700, None)), [None, None]),
            row("Finn", None, [None, None]),
        ];
        rows.push(row("Gil", Some(clock(900, Some(100))), [Some(6.0), None]));
        let instrument = checklist();
        let table = ScoreTable::new(&instrument, &instrument.scores[0], rated.map(|pair| pair.to_vec()).to_vec());
        ExamPage {
            shell: samples::shell(Role::Instructor),
            href: "/exams/1".to_owned(),
            title: "Epidural station".to_owned(),
            cohort: ("Year 4".to_owned(), "/cohorts/1".to_owned()),
            exercise: "Stop in the fat".to_owned(),
            instrument: "Checklist of a puncture".to_owned(),
            score: table.title.clone(),
            limit_min: 10,
            closed_at: None,
            rows,
            second: Some(SecondRatings {
                rater: "Dr Lind".to_owned(),
                round: Some("/ratings/1".to_owned()),
                waiting: 1,
                agreement: Some(ScoreView::new(table)),
            }),
            is_second_rater: false,
            now: samples::NOW,
        }
    }

    #[test]
    fn candidates_are_shown_with_state_ratings_and_difference() {
        let page = exam_page();
        let counts = ExamCounts { not_begun: 1, running: 2, finished: 4, late: 1, without_attempt: 0 };
        assert_eq!(page.counts(), counts);
        let html = samples::keep_page("exam", &page);
        for wanted in ["Ada &#60;Okafor&#62;", "−1", "+1", "6 min 40", "Time is over", "ICC(2,1)", "1 attempt waits"]
        {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        let closed = ExamPage { closed_at: Some(samples::NOW), second: None, ..exam_page() };
        let html = samples::keep_page("exam-closed", &closed);
        assert!(html.contains("Closed") && !html.contains("/close\"") && !html.contains("Second rating"), "{html}");
    }

    #[test]
    fn second_rater_sees_no_rating_and_no_attempt_before_rating() {
        let mut page = exam_page();
        page.is_second_rater = true;
        page.rows.iter_mut().for_each(|row| row.is_hidden = true);
        page.second = page.second.map(|second| SecondRatings { agreement: None, ..second });
        let html = samples::keep_page("exam-blind", &page);
        for hidden in ["/sessions/", "ICC", "−1", "/close\"", "/second-ratings\"", "exam.csv", "Second ratings"] {
            assert!(!html.contains(hidden), "{hidden} is in {html}");
        }
        assert!(html.contains("You are the second rater"), "{html}");
    }
}
