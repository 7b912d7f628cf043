//! The learning record store of a school, and a trainee's consent to it.

use askama::Template;
use askama_web::WebTemplate;
use model::training::learning_records::{RecordStoreSettings, VERSIONS};
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::{Shell, format};

/// The page of a school's learning record store.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/record_store.html")]
pub struct RecordStorePage {
    /// Page frame.
    pub shell: Shell,
    /// State of the store; `None` if the school uses none.
    pub state: Option<RecordStoreState>,
    /// The form.
    pub form: FilledForm<RecordStoreForm>,
    /// Number of sent statements about people who were erased here since.
    pub erased: usize,
}

/// State of a learning record store.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordStoreState {
    /// Why it refuses this service.
    pub refusal: Option<String>,
    /// Number of statements that wait.
    pub waiting: i64,
    /// Number of sent statements.
    pub sent: i64,
    /// Number of statements that the store refuses.
    pub stopped: i64,
    /// The newest refused statements.
    pub rows: Vec<StoppedStatementRow>,
}

/// A statement that the store refuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoppedStatementRow {
    /// Id.
    pub id: String,
    /// Time at which it was made.
    pub made: OffsetDateTime,
    /// Answer of the store.
    pub answer: String,
}

/// Input of the form of a learning record store, without the password.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct RecordStoreForm {
    /// Address to which `/statements` is appended.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub endpoint: String,
    /// User name of this service.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub user_name: String,
    /// Version of xAPI.
    #[serde(default)]
    pub version: String,
    /// Legal ground; empty if each person is asked.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub ground: String,
    /// Statements contain names.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub names: bool,
}

impl From<&RecordStoreSettings> for RecordStoreForm {
    fn from(settings: &RecordStoreSettings) -> Self {
        let RecordStoreSettings { endpoint, user_name, version, ground, names } = settings.clone();
        Self { endpoint, user_name, version, ground: ground.unwrap_or_default(), names }
    }
}

impl From<&RecordStoreForm> for RecordStoreSettings {
    fn from(form: &RecordStoreForm) -> Self {
        let RecordStoreForm { endpoint, user_name, version, ground, names } = form.clone();
        Self { endpoint, user_name, version, ground: Some(ground).filter(|ground| !ground.is_empty()), names }
    }
}

/// The page on which a trainee consents to the learning record store of the school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/record_consent.html")]
pub struct RecordConsentPage {
    /// Page frame.
    pub shell: Shell,
    /// What the school sends.
    pub asked: SentRecords,
    /// Number of statements about the visitor that were sent.
    pub sent: u32,
}

/// What a school sends about its trainees.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SentRecords {
    /// Nothing.
    Nothing,
    /// Statements about everybody, on a legal ground.
    ByGround {
        /// Address of the store.
        endpoint: String,
        /// The ground.
        ground: String,
        /// Statements contain names.
        names: bool,
    },
    /// Statements about those who consent.
    ByConsent {
        /// What is agreed to.
        wording: String,
        /// The visitor has consented.
        given: bool,
    },
}

/// Returns what a trainee agrees to.
#[must_use]
pub fn describe_consent(settings: &RecordStoreSettings) -> String {
    let endpoint = &settings.endpoint;
    match settings.names {
        true => tr!(
            "When my attempts begin and end, their scores, depths, forces and the courses that I master may be sent to {endpoint}, with my name.",
            endpoint = endpoint
        ),
        false => tr!(
            "When my attempts begin and end, their scores, depths, forces and the courses that I master may be sent to {endpoint}, with my pseudonym instead of my name.",
            endpoint = endpoint
        ),
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn typed() -> RecordStoreForm {
        RecordStoreForm {
            endpoint: "https://lrs.example.edu/xapi".to_owned(),
            user_name: "<b>stylet".to_owned(),
            version: "2.0.0".to_owned(),
            ..RecordStoreForm::default()
        }
    }

    #[test]
    fn a_form_keeps_what_was_typed() {
        for ground in ["", "Art. 6 (1) e GDPR"] {
            let typed = RecordStoreForm { ground: ground.to_owned(), ..typed() };
            assert_eq!(RecordStoreForm::from(&RecordStoreSettings::from(&typed)), typed);
        }
        let row = StoppedStatementRow { id: "1".to_owned(), made: samples::NOW, answer: "400 <i>".to_owned() };
        let state = RecordStoreState { stopped: 1, rows: vec![row], ..RecordStoreState::default() };
        let shell = || samples::shell(Role::Administrator);
        let page = |state| RecordStorePage { shell: shell(), state, form: FilledForm::new(typed()), erased: 2 };
        let html = samples::keep_page("record-store", &page(Some(state.clone())));
        assert!(html.contains("&#60;b&#62;stylet") && html.contains("400 &#60;i&#62;"), "{html}");
        assert!(html.contains("/admin/learning-records/retry") && html.contains("erased.txt"), "{html}");
        let refused = RecordStoreState { refusal: Some("401".to_owned()), ..state };
        assert!(samples::keep_page("record-store-refused", &page(Some(refused))).contains("role=\"alert\""));
        assert!(!samples::keep_page("record-store-none", &page(None)).contains("/disable"));
    }

    #[test]
    fn a_trainee_sees_what_is_sent() {
        let settings = RecordStoreSettings::from(&typed());
        let wording = describe_consent(&settings);
        assert!(wording.contains("https://lrs.example.edu/xapi") && wording.contains("pseudonym"), "{wording}");
        let page = |asked| RecordConsentPage { shell: samples::shell(Role::Trainee), asked, sent: 3 };
        let asked = |given| SentRecords::ByConsent { wording: wording.clone(), given };
        assert!(samples::keep_page("record-consent", &page(asked(false))).contains("value=\"given\""));
        assert!(samples::keep_page("record-consent-given", &page(asked(true))).contains("value=\"withdrawn\""));
        let ground = SentRecords::ByGround { endpoint: settings.endpoint, ground: "<p>law".to_owned(), names: true };
        let html = samples::keep_page("record-ground", &page(ground));
        assert!(html.contains("&#60;p&#62;law") && !html.contains("name=\"consent\""), "{html}");
        assert!(!samples::keep_page("record-nothing", &page(SentRecords::Nothing)).contains("name=\"consent\""));
    }
}
