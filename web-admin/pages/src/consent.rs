//! An expert's consent: what stands, what was recorded, and the form that records it.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::PersonId;
use serde::Deserialize;
use time::OffsetDateTime;

use super::form::FilledForm;
use super::{Shell, StatusWord, format};

/// The consent of somebody who teaches.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/consent.html")]
pub struct ConsentOfExpertPage {
    /// Frame.
    pub shell: Shell,
    /// Who.
    pub person: PersonId,
    /// Their name.
    pub name: String,
    /// What was recorded, the latest first.
    pub recorded: Vec<Recorded>,
    /// What is typed.
    pub form: FilledForm<DeclarationForm>,
}

/// The fields of a consent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct DeclarationForm {
    /// The words that were agreed to.
    pub wording: String,
    /// How it was given.
    pub how: String,
    /// The day.
    pub given: String,
}

/// A consent that was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// What was agreed to.
    pub wording: String,
    /// How it was given.
    pub how: String,
    /// When.
    pub given_at: OffsetDateTime,
    /// Who recorded it.
    pub recorded_by: String,
    /// When it was taken back, and who recorded that.
    pub withdrawn: Option<(OffsetDateTime, String)>,
}

impl ConsentOfExpertPage {
    fn stands(&self) -> Option<&Recorded> {
        self.recorded.iter().find(|recorded| recorded.withdrawn.is_none())
    }
}

#[cfg(test)]
mod tests {
    //! Fails when it cannot be seen what was agreed to, or a consent that stands cannot be taken back.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn words_and_history_are_shown_and_only_what_stands_is_taken_back() {
        let recorded = |withdrawn| Recorded {
            wording: "My attempts may be <shown>.".to_owned(),
            how: "on paper".to_owned(),
            given_at: samples::NOW,
            recorded_by: "Head".to_owned(),
            withdrawn,
        };
        let page = ConsentOfExpertPage {
            shell: samples::shell(Role::Administrator),
            person: PersonId::nil(),
            name: "Dr Osei".to_owned(),
            recorded: vec![recorded(None), recorded(Some((samples::NOW, "Head".to_owned())))],
            form: FilledForm::default(),
        };
        let html = samples::keep_page("expert-consent", &page);
        assert!(html.contains("&#60;shown&#62;") && html.contains("/consent/withdraw"), "{html}");
        let typed = DeclarationForm { wording: "a \"b\"".to_owned(), ..DeclarationForm::default() };
        let page = ConsentOfExpertPage {
            recorded: vec![],
            form: FilledForm::refused(typed, "wording: 0 characters".to_owned()),
            ..page
        };
        let html = samples::keep_page("expert-consent-refused", &page);
        assert!(
            html.contains("a &#34;b&#34;") && html.contains("role=\"alert\"") && !html.contains("/withdraw"),
            "{html}"
        );
    }
}
