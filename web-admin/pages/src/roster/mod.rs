//! A roster: sent, looked at, confirmed.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RosterId;
use model::roster::{Leaving, LineOutcome, Refusal, RosterChange, RosterColumn, RosterDifference, RosterOutcome};
use serde::Deserialize;

use super::form::{FilledForm, read_ticked_box, read_trimmed_text};
use super::letters::MailWay;
use super::{Shell, StatusWord, roster};

mod columns;

pub use columns::{ColumnsRefused, RosterColumnsForm, RosterColumnsPage, say_column};

/// Lines on one page of a difference.
pub const PER_PAGE: usize = 200;

/// Where a roster is sent from.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "roster/new.html")]
pub struct RosterPage {
    /// Frame.
    pub shell: Shell,
    /// What is typed, and why the last file was refused.
    pub form: FilledForm<RosterForm>,
    /// The cohorts there are.
    pub cohorts: Vec<String>,
}

/// What is sent along with a roster.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RosterForm {
    /// The cohort of people whose line names none; empty: none.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub cohort: String,
    /// Whoever is missing is to leave.
    #[serde(deserialize_with = "read_ticked_box")]
    pub remove_missing: bool,
}

/// Which lines are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RosterFilter {
    /// Those that change something or are refused.
    #[default]
    Changes,
    /// Those that add somebody.
    New,
    /// Those that change somebody.
    Changed,
    /// Those that change nothing.
    Unchanged,
    /// Those that are left out.
    Refused,
}

/// What a roster would change.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "roster/preview.html")]
pub struct RosterPreviewPage {
    /// Frame.
    pub shell: Shell,
    /// Of the roster that waits.
    pub id: RosterId,
    /// What the file was called.
    pub file_name: String,
    /// Where letters go.
    pub mail_way: MailWay,
    /// Headings that are read, and what each tells.
    pub mapped: Vec<(String, RosterColumn)>,
    /// Headings that mean nothing here.
    pub ignored: Vec<String>,
    /// Lines that add, change, leave as it is, and are refused.
    pub counts: [usize; 4],
    /// Nothing would happen.
    pub empty: bool,
    /// Which lines are shown.
    pub shown: RosterFilter,
    /// The lines of this page.
    pub lines: Vec<LineOutcome>,
    /// This page, from 1, and the last one.
    pub pages: (usize, usize),
    /// Who leaves a cohort.
    pub leaving: Vec<Leaving>,
    /// Stands for the difference.
    pub digest: String,
    /// People have changed since this was shown.
    pub stale: bool,
}

impl RosterPreviewPage {
    /// The lines of a page.
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

    /// The lists to choose from: what is in them, their word in the address, how many lines, and whether they are shown.
    fn lists(&self) -> [(&'static str, &'static str, usize, bool); 4] {
        let [new, changed, unchanged, refused] = self.counts;
        [
            (tr!("New"), "new", new, self.shown == RosterFilter::New),
            (tr!("Changed"), "changed", changed, self.shown == RosterFilter::Changed),
            (tr!("Unchanged"), "unchanged", unchanged, self.shown == RosterFilter::Unchanged),
            (tr!("Left out"), "refused", refused, self.shown == RosterFilter::Refused),
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

/// The badge of what comes of a line.
#[must_use]
pub fn line_badge(outcome: &RosterOutcome) -> String {
    match outcome {
        RosterOutcome::New => StatusWord::Passed.badge_saying(tr!("New")),
        RosterOutcome::Changed { .. } => StatusWord::Current.badge_saying(tr!("Changed")),
        RosterOutcome::Unchanged | RosterOutcome::Together(_) => StatusWord::OnTrack.badge_saying(tr!("Unchanged")),
        RosterOutcome::Refused(_) => StatusWord::Refused.badge_saying(tr!("Left out")),
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a line says nothing about why, or what stands in a file runs.

    use model::Role;
    use model::ids::PersonId;
    use model::roster::{RosterEntry, RosterRequest, SchoolPerson, read};

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
        let wanted = RosterRequest { cohort: Some("Spring".to_owned()), remove_missing: true, mapping: None };
        RosterDifference::of(&read(file.as_bytes()).expect("a roster"), &[known, bo], &Default::default(), &wanted)
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
            "a spreadsheet would run",
            "line 3 has this address already",
            "no name",
            "“asleep”",
            "Import 2 lines",
            "colour",
            "People have changed since",
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
        };
        let line =
            |line| LineOutcome { line, shown: String::new(), entry: Some(entry.clone()), outcome: RosterOutcome::New };
        let long = RosterDifference { lines: (1..=450).map(line).collect(), leaving: vec![] };
        let (lines, pages) = RosterPreviewPage::lines(&long, RosterFilter::Changes, 9);
        assert_eq!((lines.len(), lines[0].line, pages), (50, 401, (3, 3)));
    }
}
