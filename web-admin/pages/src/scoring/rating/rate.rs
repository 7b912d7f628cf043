//! The rater's page of an attempt: replay and instrument, without the trainee's name or the score.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RatingId;

use crate::charts::Drawing;
use crate::scoring::replay_events::{NamedHappenings, OtherAttempt};
use crate::surveys::form::{FormQuestion, QuestionField};
use crate::{Shell, StatusWord, anatomy, assets, format};

/// The page that rates an attempt.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/rating/rate.html")]
pub struct RatePage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the rating.
    pub rating: RatingId,
    /// Title and address of the round.
    pub round: (String, String),
    /// Title of the exercise.
    pub exercise: String,
    /// The curves, for browsers without scripts.
    pub drawing: Option<Drawing>,
    /// Events of the attempt.
    pub happened: NamedHappenings,
    /// Questions of the instrument.
    pub questions: Vec<FormQuestion>,
    /// All ratings of the visitor in this round.
    pub own: Vec<OwnRating>,
    /// Whether this rating is finished.
    pub finished: bool,
}

/// A rating of the visitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnRating {
    /// Address of its page.
    pub href: String,
    /// Whether it is the one shown.
    pub current: bool,
    /// Whether it is finished.
    pub finished: bool,
}

impl RatePage {
    /// Returns the position of this attempt among the visitor's, from 1.
    #[must_use]
    pub fn number(&self) -> usize {
        self.own.iter().position(|own| own.current).map_or(1, |at| at + 1)
    }

    /// Returns the address from which the script fetches the replay.
    #[must_use]
    pub fn address(&self) -> String {
        format!("/api/v1/ratings/{}", self.rating)
    }

    /// Returns `None`: raters see no second attempt in the replay.
    #[must_use]
    pub const fn other(&self) -> Option<&OtherAttempt> {
        None
    }

    /// Returns the number of answers that were refused.
    #[must_use]
    pub fn refused(&self) -> usize {
        self.questions.iter().filter(|question| question.refusal.is_some()).count()
    }

    /// Returns the English text and ignores the German one.
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
    use crate::scoring::rating::samples::{rate_page, show};

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
