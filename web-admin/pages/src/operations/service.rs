//! The state of the service, for administrators.

use askama::Template;
use askama_web::WebTemplate;

use crate::{Shell, StatusWord, format};

/// The page of the service's state.
#[derive(Clone, Debug, Template, WebTemplate)]
#[template(path = "operations/service.html")]
pub struct ServicePage {
    /// Page frame.
    pub shell: Shell,
    /// Version of the program.
    pub version: &'static str,
    /// Size of the database, in bytes.
    pub database_bytes: i64,
    /// State of the database check that began when the service started.
    pub check: DatabaseCheck,
    /// Counts for the overview: number and label.
    pub counts: Vec<(i64, &'static str)>,
    /// Number of recordings for which scoring failed at least once.
    pub failing: i64,
    /// Emails that could not be sent, latest first.
    pub letters: Vec<FailedLetterRow>,
}

/// An email that could not be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedLetterRow {
    /// Address of the recipient's page, if the recipient belongs to the school.
    pub href: Option<String>,
    /// Name of the recipient, or the email address.
    pub name: String,
    /// Error message.
    pub why: String,
}

/// State of the database check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DatabaseCheck {
    /// The check is running.
    Going {
        /// Number of tables checked.
        tables_read: usize,
        /// Number of tables.
        tables: usize,
        /// Number of rows of the audit log checked.
        rows_read: usize,
        /// Number of rows of the audit log.
        rows: i64,
    },
    /// No damage was found.
    Whole,
    /// Damage found, in the words of SQLite or of the audit log's check.
    Damaged(Vec<String>),
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn health_is_shown() {
        let page = ServicePage {
            shell: samples::shell(Role::Administrator),
            version: "0.1.0",
            database_bytes: 4_200_000,
            check: DatabaseCheck::Whole,
            counts: vec![(28, "trainees"), (2, "stations")],
            failing: 1,
            letters: vec![FailedLetterRow {
                href: Some("/people/1".to_owned()),
                name: "Ana <Ek>".to_owned(),
                why: "550 no such mailbox".to_owned(),
            }],
        };
        let html = samples::keep_page("service", &page);
        assert!(html.contains("1 email could not be sent") && html.contains("Ana &#60;Ek&#62;"), "{html}");
        let well = ServicePage { failing: 0, letters: Vec::new(), ..page.clone() };
        assert!(samples::keep_page("service-well", &well).contains("No failures"));
        let unsent = samples::keep_page("service-unsent", &ServicePage { failing: 0, ..page.clone() });
        assert!(!unsent.contains("No failures"), "a letter that failed is a failure");
        assert!(html.contains("4.2\u{a0}MB") && html.contains("/admin/audit"), "{html}");
        let check = DatabaseCheck::Going { tables_read: 41, tables: 63, rows_read: 0, rows: 912_000 };
        let html = samples::keep_page("service-being-checked", &ServicePage { check, ..page.clone() });
        assert!(html.contains("41 of 63 tables"), "{html}");
        let check = DatabaseCheck::Damaged(vec!["audit log: row 2 was changed after it was written".to_owned()]);
        let html = samples::keep_page("service-damaged", &ServicePage { check, ..page });
        assert!(html.contains("row 2 was changed") && html.contains("web-admin restore"), "{html}");
    }
}
