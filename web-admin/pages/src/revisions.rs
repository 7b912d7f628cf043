//! How the revisions of a document differ.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RevisionId;
use time::OffsetDateTime;

use super::diff::DiffLine;
use super::{Shell, format};

/// The revisions of a document, two of them compared.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "revisions.html")]
pub struct RevisionsPage {
    /// Frame.
    pub shell: Shell,
    /// Title of the document.
    pub title: String,
    /// Page of the document.
    pub href: String,
    /// Revisions, newest first.
    pub revisions: Vec<RevisionRow>,
    /// The older of the two that are compared.
    pub from: RevisionId,
    /// The newer of the two.
    pub to: RevisionId,
    /// What differs, by document; empty where there is but one revision.
    pub parts: Vec<(&'static str, Vec<Vec<DiffLine>>)>,
}

/// A revision in the list.
#[derive(Clone, Debug)]
pub struct RevisionRow {
    /// Its id.
    pub id: RevisionId,
    /// Its title.
    pub title: String,
    /// The beginning of its hash.
    pub hash: String,
    /// When it was published.
    pub published_at: OffsetDateTime,
    /// Trainees are given this one.
    pub current: bool,
}

#[cfg(test)]
mod tests {
    //! Two revisions must be told apart, and equal ones not.

    use model::Role;

    use super::*;
    use crate::diff::compare_lines;
    use crate::samples;

    #[test]
    fn revisions_are_compared() {
        let [older, newer] = [1, 2].map(RevisionId::from_u128);
        let revision = |id, current| RevisionRow {
            id,
            title: "Stop in the fat".to_owned(),
            hash: "0123abcd".to_owned(),
            published_at: samples::NOW,
            current,
        };
        let page = RevisionsPage {
            shell: samples::shell(Role::Instructor),
            title: "Stop in the fat".to_owned(),
            href: "/exercises/stop-in-the-fat".to_owned(),
            revisions: vec![revision(newer, true), revision(older, false)],
            from: older,
            to: newer,
            parts: vec![("Exercise", compare_lines("pass_mark = 70\n", "pass_mark = 75\n")), ("Scene", vec![])],
        };
        let html = samples::keep_page("revisions", &page);
        assert!(html.contains("pass_mark = 75") && html.contains("No difference"), "{html}");
    }
}
