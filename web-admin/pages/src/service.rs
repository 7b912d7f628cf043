//! The service as its administrator sees it: its health.

use askama::Template;
use askama_web::WebTemplate;

use super::{Shell, StatusWord, format};

/// The page.
#[derive(Clone, Debug, Template, WebTemplate)]
#[template(path = "service.html")]
pub struct ServicePage {
    /// Frame.
    pub shell: Shell,
    /// Version of the program.
    pub version: &'static str,
    /// The database, in bytes.
    pub database_bytes: i64,
    /// What the look through the database came to, that began with the service.
    pub check: DatabaseCheck,
    /// Figures: how many, and of what.
    pub counts: Vec<(i64, &'static str)>,
    /// Recordings that failed to be scored at least once.
    pub failing: i64,
    /// Letters that could not be sent, the latest first.
    pub letters: Vec<FailedLetterRow>,
}

/// A letter that could not be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedLetterRow {
    /// The page of whom it was for, where they are a person of the school.
    pub href: Option<String>,
    /// Their name, or the address.
    pub name: String,
    /// Why.
    pub why: String,
}

/// What a look through the database came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DatabaseCheck {
    /// It goes on.
    Going {
        /// Tables whose pages were read.
        tables_read: usize,
        /// Tables there are.
        tables: usize,
        /// Rows of the audit log that were walked.
        rows_read: usize,
        /// Rows of it that there are.
        rows: i64,
    },
    /// Nothing is wrong.
    Whole,
    /// What is wrong, each as SQLite or the audit log's check words it.
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
        assert!(html.contains("1 letter could not be sent") && html.contains("Ana &#60;Ek&#62;"), "{html}");
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
