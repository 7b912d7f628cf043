//! Ratings: rounds, the form that makes one, what a rater is shown, and what was found.

mod rate;
mod round;
#[cfg(test)]
mod samples;

use askama::Template;
use askama_web::WebTemplate;
use model::ids::SessionId;
pub use rate::{OwnRating, RatePage};
pub use round::{RatedAttemptRow, RaterRow, RoundPage, ScoreView};
use serde::Deserialize;
use time::OffsetDateTime;

use super::form::{FilledForm, read_trimmed_text};
use super::people::SelectOption;
use super::{Shell, StatusWord, format};

/// Rounds of ratings.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "rating/list.html")]
pub struct RatingsPage {
    /// Frame.
    pub shell: Shell,
    /// The latest first.
    pub rounds: Vec<RoundRow>,
}

/// A round in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoundRow {
    /// Its page.
    pub href: String,
    /// Title.
    pub title: String,
    /// Title of the instrument.
    pub instrument: String,
    /// Who asked for it.
    pub by: String,
    /// When.
    pub made_at: OffsetDateTime,
    /// Finished ratings, and all.
    pub finished: (u32, u32),
    /// The visitor's own finished ratings, and all of theirs.
    pub own: (u32, u32),
    /// The ratings were made by a program.
    pub generated: bool,
}

/// The form that asks for ratings.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "rating/new.html")]
pub struct NewRoundPage {
    /// Frame.
    pub shell: Shell,
    /// Instruments that have a score.
    pub instruments: Vec<SelectOption>,
    /// Those who can be asked.
    pub raters: Vec<SelectOption>,
    /// Attempts that can be rated.
    pub attempts: Vec<AttemptChoice>,
    /// What is typed.
    pub form: FilledForm<NewRoundForm>,
}

/// The fields of a new round.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewRoundForm {
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// The instrument's id.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub instrument: String,
    /// The assignment that the attempts are of; empty: the review queue.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub assignment: String,
    /// Ids of raters.
    #[serde(rename = "rater")]
    pub raters: Vec<String>,
    /// Ids of attempts.
    #[serde(rename = "attempt")]
    pub attempts: Vec<String>,
}

/// An attempt that can be rated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttemptChoice {
    /// The attempt.
    pub session: SessionId,
    /// Who tried.
    pub trainee: String,
    /// Title of the exercise.
    pub exercise: String,
    /// When it began.
    pub started_at: OffsetDateTime,
    /// It is chosen.
    pub chosen: bool,
}

#[cfg(test)]
mod tests {
    //! Fails when somebody is not led to what they are to rate, or what was typed is lost with a refusal.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn open_ratings_come_with_a_button() {
        let row = |own| RoundRow {
            href: "/ratings/1".to_owned(),
            title: "Spring <round>".to_owned(),
            instrument: "Global rating".to_owned(),
            by: "Dr Osei".to_owned(),
            made_at: samples::NOW,
            finished: (7, 12),
            own,
            generated: true,
        };
        let shell = samples::shell(Role::Instructor);
        let page = RatingsPage { shell: shell.clone(), rounds: vec![row((1, 4)), row((0, 0))] };
        let html = samples::keep_page("ratings", &page);
        assert!(html.contains("&#60;round&#62;") && html.contains("7 of 12") && html.contains("Rate 3"), "{html}");
        let empty = RatingsPage { shell, rounds: vec![] };
        assert!(samples::keep_page("ratings-none", &empty).contains("Nobody has asked for ratings yet"));
    }

    #[test]
    fn a_refused_form_keeps_what_was_chosen() {
        let choice = |value: &str, chosen| SelectOption { value: value.to_owned(), label: value.to_owned(), chosen };
        let attempt = AttemptChoice {
            session: SessionId::nil(),
            trainee: "Ada".to_owned(),
            exercise: "Stop in the fat".to_owned(),
            started_at: samples::NOW,
            chosen: true,
        };
        let typed = NewRoundForm { title: "Spring \"round\"".to_owned(), ..NewRoundForm::default() };
        let page = NewRoundPage {
            shell: samples::shell(Role::Instructor),
            instruments: vec![choice("global", true)],
            raters: vec![choice("r1", true), choice("r2", false)],
            attempts: vec![attempt],
            form: FilledForm::refused(typed, "raters: 1; at least 2 are needed".to_owned()),
        };
        let html = samples::keep_page("ratings-new", &page);
        assert!(html.contains("Spring &#34;round&#34;") && html.contains("at least 2 are needed"), "{html}");
        assert_eq!(html.matches(" checked").count(), 2, "{html}");
    }
}
