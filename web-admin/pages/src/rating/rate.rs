//! What a rater is shown of an attempt: the replay and the instrument, and nothing of whose it is or how it was scored.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RatingId;

use crate::replay::{NamedHappenings, OtherAttempt};
use crate::session::Drawing;
use crate::survey::form::{FormQuestion, QuestionField};
use crate::{Shell, StatusWord, anatomy, assets, format};

/// An attempt to be rated.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "rating/rate.html")]
pub struct RatePage {
    /// Frame.
    pub shell: Shell,
    /// The rating.
    pub rating: RatingId,
    /// Title and page of the round.
    pub round: (String, String),
    /// Title of the exercise.
    pub exercise: String,
    /// The curves, for browsers without scripts.
    pub drawing: Option<Drawing>,
    /// What happened when.
    pub happened: NamedHappenings,
    /// What is asked.
    pub questions: Vec<FormQuestion>,
    /// All ratings of the visitor in this round.
    pub own: Vec<OwnRating>,
    /// This one is finished.
    pub finished: bool,
}

/// A rating of the visitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnRating {
    /// Its page.
    pub href: String,
    /// It is the one that is shown.
    pub current: bool,
    /// It is finished.
    pub finished: bool,
}

impl RatePage {
    /// Where this attempt stands among the visitor's, from 1.
    #[must_use]
    pub fn number(&self) -> usize {
        self.own.iter().position(|own| own.current).map_or(1, |at| at + 1)
    }

    /// Where a replay is fetched.
    #[must_use]
    pub fn address(&self) -> String {
        format!("/api/v1/ratings/{}", self.rating)
    }

    /// Nothing is laid over it.
    #[must_use]
    pub const fn other(&self) -> Option<&OtherAttempt> {
        None
    }

    /// How many questions were refused.
    #[must_use]
    pub fn refused(&self) -> usize {
        self.questions.iter().filter(|question| question.refusal.is_some()).count()
    }

    /// A text of the form; instructors' pages are in English.
    #[must_use]
    pub fn t<'a>(&self, english: &'a str, _german: &str) -> &'a str {
        english
    }

    fn replay_script(&self) -> String {
        assets::asset_address("replay.js")
    }

    fn saving_script(&self) -> String {
        assets::asset_address("survey.js")
    }
}

#[cfg(test)]
mod tests {
    use crate::rating::samples::{rate_page, show};

    #[test]
    fn a_rater_is_asked_and_told_how_many_are_left() {
        let html = show("rate", &rate_page(false));
        for wanted in ["Attempt 2 of 3", "name=\"q.overall\"", "data-address=\"/api/v1/ratings/", "Finish"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        let done = show("rate-finished", &rate_page(true));
        assert!(done.contains("finished") && !done.contains("name=\"do\""), "{done}");
    }
}
