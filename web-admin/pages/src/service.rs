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
        };
        let html = samples::keep_page("service", &page);
        assert!(html.contains("4.2\u{a0}MB") && html.contains("/admin/audit"), "{html}");
        let check = DatabaseCheck::Going { tables_read: 41, tables: 63, rows_read: 0, rows: 912_000 };
        let html = samples::keep_page("service-being-checked", &ServicePage { check, ..page.clone() });
        assert!(html.contains("41 of 63 tables"), "{html}");
        let check = DatabaseCheck::Damaged(vec!["audit log: row 2 was changed after it was written".to_owned()]);
        let html = samples::keep_page("service-damaged", &ServicePage { check, ..page });
        assert!(html.contains("row 2 was changed") && html.contains("web-admin restore"), "{html}");
    }
}
