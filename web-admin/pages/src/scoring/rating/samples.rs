//! Sample pages of ratings.

use model::Role;
use model::ids::RatingId;
use model::scoring::rating::ScoreTable;

use super::{OwnRating, RatePage, RatedAttemptRow, RaterRow, RoundPage, ScoreView};
use crate::charts::Drawing;
use crate::samples;
use crate::scoring::replay_events::NamedHappenings;
use crate::surveys::form::{FormQuestion, GivenField};

pub(super) fn show(name: &str, page: &(impl askama::Template + std::fmt::Debug)) -> String {
    samples::keep_page(name, page)
}

fn own() -> Vec<OwnRating> {
    let own = |n: u32, current, finished| OwnRating { href: format!("/rate/{n}"), current, finished };
    vec![own(1, false, true), own(2, true, false), own(3, false, false)]
}

pub(super) fn rate_page(finished: bool) -> RatePage {
    let document = include_bytes!("../../../../../curricula/instruments/global-rating-puncture.toml");
    let instrument = documents::Instrument::from_bytes("sample", document).expect("a shipped instrument");
    let question = |item| FormQuestion::new(&instrument, item, "en", &GivenField::default());
    RatePage {
        shell: samples::shell(Role::Instructor),
        rating: RatingId::nil(),
        round: ("Spring round".to_owned(), "/ratings/1".to_owned()),
        exercise: "Stop in the fat".to_owned(),
        drawing: Some(Drawing::new(&samples::curve()).leading_to("")),
        happened: NamedHappenings::new(Some(&samples::curve()), "", 26.0),
        questions: instrument.items.iter().map(question).collect(),
        own: own(),
        finished,
    }
}

/// Returns a page with the data of Shrout and Fleiss.
pub(super) fn round_page() -> RoundPage {
    let points: [[f64; 4]; 6] = [
        [9.0, 2.0, 5.0, 8.0],
        [6.0, 1.0, 3.0, 2.0],
        [8.0, 4.0, 6.0, 8.0],
        [7.0, 1.0, 2.0, 6.0],
        [10.0, 5.0, 6.0, 9.0],
        [6.0, 2.0, 4.0, 7.0],
    ];
    let rows: Vec<Vec<Option<f64>>> = points.iter().map(|row| row.iter().copied().map(Some).collect()).collect();
    let agreement = assessment::statistics::intraclass_correlation(&rows);
    let table = ScoreTable { title: "Global rating (7–35)".to_owned(), range: (7.0, 35.0), rows, agreement };
    let attempt = |n: usize| RatedAttemptRow {
        trainee: (n > 0).then(|| ("Ada".to_owned(), "/sessions/1".to_owned())),
        exercise: "Stop in the fat".to_owned(),
        started_at: Some(samples::NOW),
    };
    let rater = |name: &str, finished| RaterRow { name: name.to_owned(), finished, may_know: 6 - finished, of: 6 };
    RoundPage {
        shell: samples::shell(Role::Instructor),
        href: "/ratings/1".to_owned(),
        title: "Spring round".to_owned(),
        instrument: "Global rating of a puncture".to_owned(),
        by: "Dr Osei".to_owned(),
        made_at: samples::NOW,
        generated: true,
        owner: true,
        own: own(),
        raters: vec![rater("A", 6), rater("B", 5), rater("C", 6), rater("D", 6)],
        found: Some(((0..6).map(attempt).collect(), vec![ScoreView::new(table)])),
    }
}
