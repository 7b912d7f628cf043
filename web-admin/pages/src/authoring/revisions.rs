//! Comparison of the revisions of a document.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RevisionId;
use time::OffsetDateTime;

use crate::authoring::diff::DiffLine;
use crate::{Shell, format};

/// The page of a document's revisions, with two of them compared.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "authoring/revisions.html")]
pub struct RevisionsPage {
    /// Page frame.
    pub shell: Shell,
    /// Title of the document.
    pub title: String,
    /// Address of the document's page.
    pub href: String,
    /// Revisions, newest first.
    pub revisions: Vec<RevisionRow>,
    /// The older revision of the comparison.
    pub from: RevisionId,
    /// The newer revision of the comparison.
    pub to: RevisionId,
    /// Differences by document; empty if there is only one revision.
    pub parts: Vec<(&'static str, Vec<Vec<DiffLine>>)>,
}

/// A revision in the list.
#[derive(Clone, Debug)]
pub struct RevisionRow {
    /// Its id.
    pub id: RevisionId,
    /// Its title.
    pub title: String,
    /// Start of its hash.
    pub hash: String,
    /// Time of publication.
    pub published_at: OffsetDateTime,
    /// Whether it is the revision that trainees get.
    pub current: bool,
}

#[cfg(test)]
mod tests {
    //! Differences between revisions must be shown, and equal revisions reported as such.

    use model::Role;

    use super::*;
    use crate::authoring::diff::compare_lines;
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
