//! The service as its administrator sees it: health, and who did what.

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use super::{Shell, StatusWord, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "service.html")]
pub struct ServicePage {
    /// Frame.
    pub shell: Shell,
    /// Version of the program.
    pub version: &'static str,
    /// The database, in bytes.
    pub database_bytes: i64,
    /// Figures: how many, and of what.
    pub counts: Vec<(i64, &'static str)>,
    /// Recordings that failed to be scored at least once.
    pub failing: i64,
    /// Acts, the latest first.
    pub acts: Vec<ActRow>,
    /// Where older acts are, if there are any.
    pub older: Option<String>,
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
    /// What.
    pub action: String,
    /// To what.
    pub object: String,
    /// What else is known.
    pub details: String,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn health_and_acts_are_shown_and_details_cannot_become_markup() {
        let page = ServicePage {
            shell: samples::shell(Role::Administrator),
            version: "0.1.0",
            database_bytes: 4_200_000,
            counts: vec![(28, "trainees"), (2, "stations")],
            failing: 1,
            acts: vec![ActRow {
                seq: 7,
                at: samples::NOW,
                actor: "Maria Keller".to_owned(),
                action: "score.overridden".to_owned(),
                object: "0190-aa".to_owned(),
                details: "{\"reason\":\"<b>\"}".to_owned(),
            }],
            older: Some("/admin/service?before=7".to_owned()),
        };
        let html = samples::keep_page("service", &page);
        assert!(html.contains("4.2\u{a0}MB") && html.contains("&#60;b&#62;") && html.contains("before=7"), "{html}");
    }
}
