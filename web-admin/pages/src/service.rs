//! The service as its administrator sees it: its health.

use askama::Template;
use askama_web::WebTemplate;

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
            counts: vec![(28, "trainees"), (2, "stations")],
            failing: 1,
        };
        let html = samples::keep_page("service", &page);
        assert!(html.contains("4.2\u{a0}MB") && html.contains("/admin/audit"), "{html}");
    }
}
