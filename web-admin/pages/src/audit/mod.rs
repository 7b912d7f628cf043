//! The audit log page.

mod action_texts;

pub use action_texts::describe_act;
use askama::Template;
use askama_web::WebTemplate;
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::read_trimmed_text;
use crate::{Shell, format};

/// A theme by which the audit log can be filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditTheme {
    /// Key in the page's query string.
    pub key: &'static str,
    /// Prefixes of the theme's actions, up to the dot.
    pub actions: &'static [&'static str],
}

/// All themes.
pub const AUDIT_THEMES: [AuditTheme; 6] = [
    AuditTheme {
        key: "accounts",
        actions: &[
            "person",
            "sign_in",
            "identity",
            "provider",
            "platform",
            "provisioning_token",
            "sign_in_code",
            "second_factor",
            "passkey",
            "recovery_code",
            "recovery_codes",
            "token",
            "calendar_feed",
            "trainee",
            "instructor",
            "administrator",
            "guest",
        ],
    },
    AuditTheme { key: "cohorts", actions: &["cohort", "roster"] },
    AuditTheme { key: "attempts", actions: &["session", "recording", "grade", "comment"] },
    AuditTheme {
        key: "teaching",
        actions: &[
            "assignment",
            "exam",
            "exercise",
            "curriculum",
            "draft",
            "certificate",
            "badge",
            "segments",
            "outcome",
            "support",
        ],
    },
    AuditTheme { key: "surveys", actions: &["survey", "instrument", "study", "ratings", "rating", "expert"] },
    AuditTheme {
        key: "school",
        actions: &["school", "station", "pairing_code", "retention", "record_store", "records"],
    },
];

impl AuditTheme {
    /// Returns the theme with a key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        AUDIT_THEMES.into_iter().find(|theme| theme.key == key)
    }

    /// Names the theme.
    #[must_use]
    pub fn say(self) -> &'static str {
        match self.key {
            "accounts" => tr!("accounts and signing in"),
            "cohorts" => tr!("cohorts and rosters"),
            "attempts" => tr!("attempts and grades"),
            "teaching" => tr!("exercises, courses and assignments"),
            "surveys" => tr!("surveys, ratings and studies"),
            _ => tr!("the school and its stations"),
        }
    }
}

/// Filter of the audit log, as entered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct AuditForm {
    /// A name, or the complete id of the object.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub words: String,
    /// Key of a theme; empty for all.
    pub theme: String,
    /// First day, like 2026-11-24; empty for no lower limit.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub since: String,
    /// Last day; empty for no upper limit.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub until: String,
}

/// The audit log page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "audit/audit.html")]
pub struct AuditPage {
    /// Page frame.
    pub shell: Shell,
    /// The filter.
    pub form: AuditForm,
    /// Log entries, latest first.
    pub acts: Vec<ActRow>,
    /// Address of the next older page, if there are more entries.
    pub older: Option<String>,
    /// Address of the same search as a CSV file.
    pub file: String,
    /// Time back to which the log was searched, when the search stopped before the page was full.
    pub read_since: Option<OffsetDateTime>,
}

impl AuditPage {
    fn is_narrowed(&self) -> bool {
        self.form != AuditForm::default()
    }

    fn picked(&self, theme: &AuditTheme) -> bool {
        self.form.theme == theme.key
    }
}

/// An entry of the audit log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActRow {
    /// Sequence number in the log.
    pub seq: i64,
    /// Time of the action.
    pub at: OffsetDateTime,
    /// Name of the actor.
    pub actor: String,
    /// Action, as written in the log.
    pub action: String,
    /// Object of the action.
    pub object: ActObject,
    /// Further details: label and value.
    pub details: Vec<(String, String)>,
}

impl ActRow {
    /// Describes the action.
    fn describe(&self) -> Option<&'static str> {
        describe_act(&self.action)
    }
}

/// The object of an audit action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActObject {
    /// Name, or the id if it has no name.
    pub name: String,
    /// Address of its page, if it has one.
    pub href: Option<String>,
    /// Id.
    pub id: String,
}

/// Names an actor that is not a person: the log has fixed words for programs and anonymous actors.
#[must_use]
pub fn say_actor(actor: &str) -> String {
    match actor {
        "command line" => tr!("the command line").to_owned(),
        "directory" => tr!("the school’s directory").to_owned(),
        "worker" => tr!("the service itself").to_owned(),
        "respondent" => tr!("a respondent").to_owned(),
        "stranger" => tr!("an unknown visitor").to_owned(),
        other => match other.split_once(' ') {
            Some(("station", name)) => tr!("station {name}", name = name),
            _ => other.to_owned(),
        },
    }
}

/// Returns the JSON details of an entry as pairs of label and value, in the order of the log.
#[must_use]
pub fn list_act_details(details: &str) -> Vec<(String, String)> {
    let said = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    match serde_json::from_str(details) {
        Ok(serde_json::Value::Object(map)) => {
            map.iter().map(|(name, value)| (name.replace('_', " "), said(value))).collect()
        }
        _ => vec![(String::new(), details.to_owned())],
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn acts_are_told_in_words_and_details_cannot_become_markup() {
        let act = |seq, action: &str, details: &str| ActRow {
            seq,
            at: samples::NOW,
            actor: say_actor("station Skills lab 2"),
            action: action.to_owned(),
            object: ActObject {
                name: "Maria Keller".to_owned(),
                href: Some("/sessions/1".to_owned()),
                id: "0190-aa".to_owned(),
            },
            details: list_act_details(details),
        };
        let mut page = AuditPage {
            shell: samples::shell(Role::Administrator),
            form: AuditForm { theme: "attempts".to_owned(), words: "Maria".to_owned(), ..AuditForm::default() },
            acts: vec![
                act(7, "grade.overridden", r#"{"reason":"<b>","counts_as":72.5}"#),
                act(6, "something.of_before", "no JSON"),
            ],
            older: Some("/admin/audit?before=6".to_owned()),
            file: "/admin/audit.csv?theme=attempts".to_owned(),
            read_since: Some(samples::NOW),
        };
        let html = samples::keep_page("audit", &page);
        assert!(html.contains("&#60;b&#62;") && html.contains("counts as") && html.contains("72.5"), "{html}");
        assert!(html.contains("something.of_before"), "what no program writes any more is shown as it was written");
        assert!(html.contains("station Skills lab 2") && html.contains("before=6"), "{html}");
        (page.acts, page.older, page.read_since) = (vec![], None, None);
        assert!(samples::keep_page("audit-none", &page).contains("No entries"));
    }
}
