//! Roster import: upload, preview and confirmation.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RosterId;
use model::people::roster::{
    Leaving, LineOutcome, Refusal, RosterChange, RosterColumn, RosterDifference, RosterOutcome,
};
use serde::Deserialize;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::letters::MailWay;
use crate::people::roster;
use crate::{Shell, StatusWord};

mod columns;

pub use columns::{ColumnsRefused, RosterColumnsForm, RosterColumnsPage, say_column};

/// Lines per page of the preview.
pub const PER_PAGE: usize = 200;

/// The page that uploads a roster.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/roster/new.html")]
pub struct RosterPage {
    /// Page frame.
    pub shell: Shell,
    /// The form, with the reason if the last file was refused.
    pub form: FilledForm<RosterForm>,
    /// Names of existing cohorts.
    pub cohorts: Vec<String>,
}

/// Input sent along with a roster file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RosterForm {
    /// Cohort of people whose line names none; empty for no cohort.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub cohort: String,
    /// Whether trainees who are missing from the file leave the cohorts that it fills.
    #[serde(deserialize_with = "read_ticked_box")]
    pub remove_missing: bool,
}

/// Filter of the lines shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RosterFilter {
    /// Lines that change something or are refused.
    #[default]
    Changes,
    /// Lines that add a person.
    New,
    /// Lines that change a person.
    Changed,
    /// Lines that change nothing.
    Unchanged,
    /// Lines that are refused.
    Refused,
}

/// The preview of a roster's changes.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/roster/preview.html")]
pub struct RosterPreviewPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the pending roster.
    pub id: RosterId,
    /// Name of the uploaded file.
    pub file_name: String,
    /// Where letters go.
    pub mail_way: MailWay,
    /// Headings that are read, and what each tells.
    pub mapped: Vec<(String, RosterColumn)>,
    /// Headings that are ignored.
    pub ignored: Vec<String>,
    /// Number of lines that add a person, change a person, change nothing, and are refused.
    pub counts: [usize; 4],
    /// Whether the import would change nothing.
    pub empty: bool,
    /// Filter of the lines shown.
    pub shown: RosterFilter,
    /// Lines on this page.
    pub lines: Vec<LineOutcome>,
    /// Number of this page, from 1, and of the last page.
    pub pages: (usize, usize),
    /// People who leave a cohort.
    pub leaving: Vec<Leaving>,
    /// Digest of the difference, so that exactly this preview is confirmed.
    pub digest: String,
    /// Whether people have changed since the preview.
    pub stale: bool,
    /// Whether the roster lists the members of a course of a learning platform.
    pub is_course: bool,
}

impl RosterPreviewPage {
    /// Returns the lines of a page, with its number and that of the last page.
    #[must_use]
    pub fn lines(
        difference: &RosterDifference,
        shown: RosterFilter,
        page: usize,
    ) -> (Vec<LineOutcome>, (usize, usize)) {
        let fits = |outcome: &RosterOutcome| match shown {
            RosterFilter::Changes => !outcome.changes_nothing(),
            RosterFilter::New => *outcome == RosterOutcome::New,
            RosterFilter::Changed => matches!(outcome, RosterOutcome::Changed { .. }),
            RosterFilter::Unchanged => outcome.changes_nothing(),
            RosterFilter::Refused => matches!(outcome, RosterOutcome::Refused(_)),
        };
        let fitting: Vec<&LineOutcome> = difference.lines.iter().filter(|line| fits(&line.outcome)).collect();
        let last = fitting.len().div_ceil(PER_PAGE).max(1);
        let page = page.clamp(1, last);
        let lines = fitting.into_iter().skip((page - 1) * PER_PAGE).take(PER_PAGE).cloned().collect();
        (lines, (page, last))
    }

    /// Returns the filters: label, name in addresses, number of lines, and whether they are shown.
    fn lists(&self) -> [(&'static str, &'static str, usize, bool); 4] {
        let [new, changed, unchanged, refused] = self.counts;
        [
            (tr!("New"), "new", new, self.shown == RosterFilter::New),
            (tr!("Changed"), "changed", changed, self.shown == RosterFilter::Changed),
            (tr!("Unchanged"), "unchanged", unchanged, self.shown == RosterFilter::Unchanged),
            (tr!("Skipped"), "refused", refused, self.shown == RosterFilter::Refused),
        ]
    }

    fn added(&self) -> usize {
        self.counts[0]
    }

    fn importing(&self) -> usize {
        self.counts[0] + self.counts[1]
    }

    fn refused(&self) -> usize {
        self.counts[3]
    }

    fn word(&self) -> &'static str {
        match self.shown {
            RosterFilter::Changes => "changes",
            RosterFilter::New => "new",
            RosterFilter::Changed => "changed",
            RosterFilter::Unchanged => "unchanged",
            RosterFilter::Refused => "refused",
        }
    }
}

/// Formats the outcome of a line as a badge.
#[must_use]
pub fn line_badge(outcome: &RosterOutcome) -> String {
    match outcome {
        RosterOutcome::New => StatusWord::Passed.badge_saying(tr!("New")),
        RosterOutcome::Changed { .. } => StatusWord::Current.badge_saying(tr!("Changed")),
        RosterOutcome::Unchanged | RosterOutcome::Together(_) => StatusWord::OnTrack.badge_saying(tr!("Unchanged")),
        RosterOutcome::Refused(_) => StatusWord::Refused.badge_saying(tr!("Skipped")),
    }
}

#[cfg(test)]
mod tests {
    //! Each line must state its outcome and reason, and file content must never become markup.

    use model::Role;
    use model::ids::PersonId;
    use model::people::roster::{RosterEntry, RosterRequest, SchoolPerson, read};

    use super::*;
    use crate::samples;

    fn difference() -> RosterDifference {
        let known = SchoolPerson {
            id: PersonId::nil(),
            registrar_id: None,
            email: "ana@example.org".to_owned(),
            name: "Ana Ek".to_owned(),
            role: Role::Trainee,
            enabled: true,
            cohorts: vec!["Spring".to_owned()],
        };
        let bo = SchoolPerson {
            id: PersonId::from_u128(u128::MAX),
            email: "bo@example.org".to_owned(),
            name: "Bo".to_owned(),
            ..known.clone()
        };
        let file = "email,name,id,status\nana@example.org,Ana Berg,7,deleted\nnew@example.org,<b>New,,\nx,X,,\n\
                    f@example.org,=1+1,,\nn@example.org,,,\nnew@example.org,N,,\nk@example.org,K,,asleep\nq@localhost,Q,,\n";
        let wanted =
            RosterRequest { cohort: Some("Spring".to_owned()), remove_missing: true, ..RosterRequest::default() };
        RosterDifference::of(&read(file.as_bytes()).expect("a roster"), &[known, bo], &wanted)
    }

    fn page(shown: RosterFilter) -> RosterPreviewPage {
        let difference = difference();
        let (lines, pages) = RosterPreviewPage::lines(&difference, shown, 1);
        RosterPreviewPage {
            shell: samples::shell(Role::Administrator),
            id: RosterId::nil(),
            file_name: "spring.csv".to_owned(),
            mail_way: MailWay::Folder,
            mapped: vec![("Mtknr".to_owned(), RosterColumn::RegistrarId)],
            ignored: vec!["colour".to_owned()],
            counts: difference.counts(),
            empty: difference.is_empty(),
            shown,
            lines,
            pages,
            leaving: difference.leaving,
            digest: "d".to_owned(),
            stale: true,
            is_course: false,
        }
    }

    #[test]
    fn every_line_says_what_comes_of_it_and_why() {
        let html = samples::keep_page("roster-preview", &page(RosterFilter::Changes));
        for words in [
            "name was “Ana Ek”",
            "no longer sign in",
            "no domain",
            "Mtknr",
            "&#60;b&#62;New",
            "a spreadsheet would execute",
            "line 3 already has this address",
            "the name is missing",
            "“asleep”",
            "Import 2 lines",
            "colour",
            "people have changed since",
        ] {
            assert!(html.contains(words), "{words} is missing in {html}");
        }
        assert!(html.contains("Bo") && html.contains("leave"), "who is missing leaves");
        assert_eq!(page(RosterFilter::New).lines.len(), 1);
    }

    #[test]
    fn the_form_keeps_what_was_typed() {
        let page = RosterPage {
            shell: samples::shell(Role::Administrator),
            form: FilledForm::refused(
                RosterForm { cohort: "Spring".to_owned(), remove_missing: true },
                "no column for the <email>".to_owned(),
            ),
            cohorts: vec!["Autumn".to_owned()],
        };
        let html = samples::keep_page("roster", &page);
        assert!(html.contains("&#60;email&#62;") && html.contains("value=\"Spring\"") && html.contains("checked"));
    }

    #[test]
    fn long_lists_come_in_pages() {
        let entry = RosterEntry {
            email: String::new(),
            name: String::new(),
            registrar_id: None,
            cohorts: Vec::new(),
            role: None,
            standing: None,
            identity: None,
        };
        let line =
            |line| LineOutcome { line, shown: String::new(), entry: Some(entry.clone()), outcome: RosterOutcome::New };
        let long = RosterDifference { lines: (1..=450).map(line).collect(), leaving: vec![] };
        let (lines, pages) = RosterPreviewPage::lines(&long, RosterFilter::Changes, 9);
        assert_eq!((lines.len(), lines[0].line, pages), (50, 401, (3, 3)));
    }
}
