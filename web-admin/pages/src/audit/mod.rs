//! Who did what: the audit log, in words.

mod deeds;

use askama::Template;
use askama_web::WebTemplate;
pub use deeds::describe_act;
use serde::Deserialize;
use time::OffsetDateTime;

use super::form::read_trimmed_text;
use super::{Shell, format};

/// A theme by which acts are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditTheme {
    /// Stands for it in an address.
    pub key: &'static str,
    /// Beginnings of its actions.
    pub actions: &'static [&'static str],
}

/// Every theme.
pub const AUDIT_THEMES: [AuditTheme; 6] = [
    AuditTheme {
        key: "accounts",
        actions: &[
            "person",
            "sign_in",
            "sign_in_code",
            "second_factor",
            "passkey",
            "recovery_code",
            "recovery_codes",
            "token",
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
        actions: &["assignment", "exercise", "curriculum", "draft", "certificate", "segments"],
    },
    AuditTheme { key: "surveys", actions: &["survey", "instrument", "study", "ratings", "rating", "expert"] },
    AuditTheme { key: "school", actions: &["school", "station", "pairing_code", "retention"] },
];

impl AuditTheme {
    /// The theme of a key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        AUDIT_THEMES.into_iter().find(|theme| theme.key == key)
    }

    /// In words.
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

/// What is looked for, as it is typed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct AuditForm {
    /// A name, or the whole id of what was acted on.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub words: String,
    /// Key of a theme; empty: any.
    pub theme: String,
    /// First day, 2026-11-24; empty: from the first.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub since: String,
    /// Last day; empty: until now.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub until: String,
}

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "audit.html")]
pub struct AuditPage {
    /// Frame.
    pub shell: Shell,
    /// What is looked for.
    pub form: AuditForm,
    /// Acts, the latest first.
    pub acts: Vec<ActRow>,
    /// Where the search goes on, if the log does.
    pub older: Option<String>,
    /// The same search as a file.
    pub file: String,
    /// Since when the log has been read, where it goes on and this page is not full.
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

/// An act.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActRow {
    /// Its place in the audit log.
    pub seq: i64,
    /// When.
    pub at: OffsetDateTime,
    /// By whom.
    pub actor: String,
    /// What, as the log says it.
    pub action: String,
    /// To what.
    pub object: ActObject,
    /// What else is known: what it is, and its value.
    pub details: Vec<(String, String)>,
}

impl ActRow {
    /// What, in words.
    fn describe(&self) -> Option<&'static str> {
        describe_act(&self.action)
    }
}

/// What was acted on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActObject {
    /// Its name, or else its id.
    pub name: String,
    /// Its page, where it has one.
    pub href: Option<String>,
    /// Its id.
    pub id: String,
}

/// By whom, in words, where it was no person: the log names programs and strangers by words of its own.
#[must_use]
pub fn say_actor(actor: &str) -> String {
    match actor {
        "command line" => tr!("the command line").to_owned(),
        "worker" => tr!("the service itself").to_owned(),
        "respondent" => tr!("somebody who answers").to_owned(),
        "stranger" => tr!("a stranger").to_owned(),
        other => match other.split_once(' ') {
            Some(("station", name)) => tr!("station {name}", name = name),
            _ => other.to_owned(),
        },
    }
}

/// What else is known of an act, from its JSON: each thing by its name, in the order of the log.
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
        assert!(samples::keep_page("audit-none", &page).contains("Nothing was found"));
    }
}
