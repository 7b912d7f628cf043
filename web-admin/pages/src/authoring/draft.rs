//! Drafts of exercises, courses and instruments.

use std::collections::BTreeMap;

use askama::Template;
use askama_web::WebTemplate;
use documents::{Curriculum, ExerciseBundle, Issue, Wording};
use model::authoring::draft::{CourseChange, DraftRemark, DraftVerdict, Publishable};
use model::training::progress::Mastery;
use serde::Deserialize;
use time::OffsetDateTime;
use tissue::follow::FieldPlan;

use crate::authoring::diff::DiffLine;
use crate::authoring::document_forms::{DocumentForm, FieldInput};
use crate::authoring::exercise::ExerciseFacts;
use crate::form::{FilledForm, SelectOption};
use crate::format::name_facts;
use crate::training::trainee::rule_in_words;
use crate::{Shell, assets, format};

/// The page of the school's drafts.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "authoring/drafts.html")]
pub struct DraftsPage {
    /// Page frame.
    pub shell: Shell,
    /// Drafts.
    pub drafts: Vec<DraftRow>,
    /// Exercises that can be copied.
    pub exercises: Vec<SelectOption>,
    /// An empty option, and the instruments that can be copied.
    pub instruments: Vec<SelectOption>,
    /// The form that begins a draft.
    pub form: FilledForm<NewDraftForm>,
}

/// Kind of document to begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NewDraftKind {
    /// An exercise, copied from another.
    #[default]
    Exercise,
    /// A course without exercises.
    Course,
    /// An instrument, copied from another or without questions.
    Instrument,
}

/// Input of the form that begins a draft.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewDraftForm {
    /// Kind of document.
    pub kind: NewDraftKind,
    /// Id of the exercise to copy.
    pub exercise: String,
    /// Id of the instrument to copy; empty to begin without questions.
    pub instrument: String,
    /// Title.
    pub title: String,
    /// Id; empty to derive it from the title.
    pub id: String,
}

impl DraftsPage {
    /// Returns why the form of a kind was refused.
    #[must_use]
    pub fn refusal_of(&self, kind: NewDraftKind) -> Option<&str> {
        self.form.refused.as_deref().filter(|_| self.form.typed.kind == kind)
    }

    /// Returns the input of the form of a kind if that form was refused; else an empty input.
    #[must_use]
    pub fn typed_of(&self, kind: NewDraftKind) -> NewDraftForm {
        if self.form.typed.kind == kind { self.form.typed.clone() } else { NewDraftForm::default() }
    }
}

/// A draft in the list.
#[derive(Clone, Debug)]
pub struct DraftRow {
    /// Address of its page.
    pub href: String,
    /// Kind of document.
    pub kind: &'static str,
    /// Title in the document; empty if it has none.
    pub title: String,
    /// Id of the document that the draft will revise.
    pub document_id: String,
    /// Name of the user who saved it last.
    pub saved_by: String,
    /// Time of that save.
    pub saved_at: OffsetDateTime,
}

/// The page that edits a draft.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "authoring/draft.html")]
pub struct DraftPage {
    /// Page frame.
    pub shell: Shell,
    /// The draft.
    pub draft: DraftRow,
    /// Whether it is an instrument.
    pub is_instrument: bool,
    /// Codes of the languages in which an instrument can be previewed.
    pub languages: Vec<String>,
    /// Text of the exercise, course or instrument, as entered.
    pub document: String,
    /// Text of an exercise's scene, as entered.
    pub scene: Option<String>,
    /// Version that the user has edited, to detect conflicts.
    pub seen: i64,
    /// Differences between the version that another user has saved meanwhile and this user's text.
    pub conflict: Option<Vec<Vec<DiffLine>>>,
    /// Whether the requested action was refused, because of problems or because of advice that the
    /// author has not overruled.
    pub refused: bool,
    /// Whom publishing would concern, where it was asked for and waits for the author's word.
    pub change: CourseChange,
    /// What it comes to.
    pub verdict: DraftVerdict,
    /// The document as a form; `None` if its text is shown.
    pub form: Option<DocumentForm>,
    /// Exercises whose scene can be reused, listed with the form of an exercise.
    pub scenes: Vec<SelectOption>,
    /// Title of the scene, shown with the form of an exercise.
    pub scene_title: String,
    /// Whether a form was requested but the text is not valid TOML.
    pub unreadable: bool,
    /// Whether the draft has just been saved.
    pub saved: bool,
    /// Why a picture was refused; nothing was saved in that case.
    pub picture_refused: Option<String>,
}

impl DraftPage {
    /// Shows why a picture was refused, and keeps the description the user entered.
    #[must_use]
    pub fn with_refused_picture(self, alt: String, why: String) -> Self {
        let form = self.form.map(|form| form.with_refused_picture(&alt, &why));
        Self { form, picture_refused: Some(why), ..self }
    }

    /// Returns a remark as shown on this page.
    #[must_use]
    pub fn show_remark(&self, remark: &DraftRemark) -> ShownRemark {
        ShownRemark::new(self.form.as_ref(), remark)
    }

    /// Returns the address of the script that updates the verdict during editing.
    #[must_use]
    pub fn script(&self) -> String {
        assets::asset_address("draft.js")
    }
}

/// The verdict alone, which a script inserts into the page during editing.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "authoring/verdict.html")]
pub struct VerdictPart {
    /// Result of the check.
    pub verdict: DraftVerdict,
    /// The form that is being edited; `None` if the text is edited.
    pub form: Option<DocumentForm>,
}

impl VerdictPart {
    /// Returns a remark as shown in this fragment.
    #[must_use]
    pub fn show_remark(&self, remark: &DraftRemark) -> ShownRemark {
        ShownRemark::new(self.form.as_ref(), remark)
    }
}

/// A remark on a draft as displayed: with a form, by the name of the field; with a text, by line
/// and column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownRemark {
    /// Link to the field on the page; `None` if the field is not shown.
    pub href: Option<String>,
    /// Label of the field, or line and column.
    pub place: String,
    /// Text of the remark.
    pub what: String,
}

impl ShownRemark {
    fn new(form: Option<&DocumentForm>, remark: &DraftRemark) -> Self {
        let DraftRemark { place, field, what } = remark.clone();
        match form.and_then(|form| form.find_place(&field)) {
            Some((id, label)) => Self { href: Some(format!("#{id}")), place: label, what },
            None if field.is_empty() => Self { href: None, place, what },
            None => Self { href: None, place, what: format!("{field}: {what}") },
        }
    }
}

/// Returns the verdict on an exercise that can be published.
#[must_use]
pub fn verdict_of_exercise(exercise: &Publishable) -> DraftVerdict {
    let Publishable { bundle, plan, advice } = exercise;
    let view = ExerciseFacts::new(bundle, &[]);
    let mut facts = view.facts;
    facts.extend(describe_tissue(bundle, plan.as_ref()));
    let facts = name_facts(facts);
    let advice = advice.iter().map(remark_on_issue).collect();
    DraftVerdict { advice, drawing: Some(view.drawing), facts, ..DraftVerdict::default() }
}

/// Returns the verdict on a course that can be published; `titles` holds exercise titles by id.
#[must_use]
pub fn verdict_of_course(course: &Curriculum, mastery: &Mastery, titles: &BTreeMap<String, Wording>) -> DraftVerdict {
    let title = |id: &String| {
        titles.get(id).map_or_else(|| id.clone(), |title| title.in_language(words::current().code()).to_owned())
    };
    let line = |entry: &documents::curriculum::CurriculumEntry| {
        let first: Vec<String> = entry.prerequisites.iter().map(title).collect();
        match first.as_slice() {
            [] => title(&entry.exercise),
            first => tr!("{exercise}, after {missing}", exercise = title(&entry.exercise), missing = first.join(", ")),
        }
    };
    DraftVerdict {
        facts: name_facts(vec![
            (tr!("Title"), course.title.in_language(words::current().code()).to_owned()),
            (tr!("An exercise is"), rule_in_words(mastery)),
        ]),
        exercises: course.entries.iter().map(line).collect(),
        ..DraftVerdict::default()
    }
}

/// Returns the verdict on a draft with problems.
#[must_use]
pub fn verdict_of_refused(issues: &[Issue]) -> DraftVerdict {
    DraftVerdict { problems: issues.iter().map(remark_on_issue).collect(), ..DraftVerdict::default() }
}

/// Returns the verdict on a draft that has not been checked because the queue is busy;
/// `retry_after_s` is the time until the next try, in s.
#[must_use]
pub fn verdict_while_waiting(retry_after_s: u64) -> DraftVerdict {
    let what = tr!("other drafts of this school are checked first; try again in {wait} s", wait = retry_after_s);
    DraftVerdict { problems: vec![DraftRemark::on_all(tr!("Not checked yet"), what)], ..DraftVerdict::default() }
}

/// Describes an issue in a document: its place, and the problem with field name.
#[must_use]
pub fn say_issue(issue: &Issue) -> (String, String) {
    (say_issue_place(issue), format!("{}: {}", issue.field, say_fault(issue)))
}

fn say_issue_place(issue: &Issue) -> String {
    let Issue { line, column, .. } = issue;
    if is_in_scene(issue) {
        tr!("Scene, line {line}, column {column}", line = line, column = column)
    } else {
        tr!("Document, line {line}, column {column}", line = line, column = column)
    }
}

fn is_in_scene(issue: &Issue) -> bool {
    issue.file == "attached scene"
}

/// Describes the value found and the values allowed.
fn say_fault(issue: &Issue) -> String {
    format!("{}; {}", words::phrase(&issue.found), words::phrase(&issue.allowed))
}

/// Converts an issue into a remark, which a form shows at its field.
fn remark_on_issue(issue: &Issue) -> DraftRemark {
    if is_in_scene(issue) {
        let (place, what) = say_issue(issue);
        return DraftRemark { place, field: String::new(), what };
    }
    DraftRemark { place: say_issue_place(issue), field: issue.field.clone(), what: say_fault(issue) }
}

/// Describes the planned tissue model, its error and its size.
fn describe_tissue(bundle: &ExerciseBundle, plan: Option<&FieldPlan>) -> Vec<(&'static str, String)> {
    let Some(plan) = plan else {
        return vec![(tr!("Tissue"), tr!("force law only: the scene names no tissue model").to_owned())];
    };
    let error = tr!(
        "{expected} % expected, {allowed} % allowed",
        expected = format::format_fixed(100.0 * plan.expected_relative_error, 1),
        allowed = format::format_fixed(100.0 * bundle.scene.tissue.tolerance, 1)
    );
    let size = tr!(
        "{unknowns} unknowns, {size} MB",
        unknowns = plan.unknowns,
        size = format::format_fixed(plan.bytes as f64 * 1e-6, 2)
    );
    vec![
        (tr!("Tissue"), format!("{}: {}", plan.model.name(), words::phrase(&plan.reason))),
        (tr!("Tissue model error"), error),
        (tr!("Tissue model size"), size),
    ]
}

#[cfg(test)]
mod tests {
    //! Problems must be shown with their place, and user input must never be lost.

    use documents::metrics::SceneNames;
    use model::Role;
    use model::authoring::EditedDocument;
    use phrase::{Phrase, phrase};

    use super::*;
    use crate::authoring::diff::compare_lines;
    use crate::authoring::document_forms::{DraftPictures, ExerciseContext, make_exercise_form};
    use crate::samples;

    fn row() -> DraftRow {
        DraftRow {
            href: "/drafts/1".to_owned(),
            kind: "Exercise",
            title: "Stop in the fat".to_owned(),
            document_id: "stop-in-the-fat".to_owned(),
            saved_by: "Dr Peter Osei".to_owned(),
            saved_at: samples::NOW,
        }
    }

    fn page(verdict: DraftVerdict) -> DraftPage {
        DraftPage {
            shell: samples::shell(Role::Instructor),
            draft: row(),
            is_instrument: false,
            languages: Vec::new(),
            document: "id = \"<b>\"\n".to_owned(),
            scene: Some("id = \"s\"\n".to_owned()),
            seen: 3,
            conflict: None,
            refused: false,
            change: CourseChange::default(),
            verdict,
            form: None,
            scenes: Vec::new(),
            scene_title: String::new(),
            unreadable: false,
            saved: false,
            picture_refused: None,
        }
    }

    #[test]
    fn what_is_written_can_be_seen_and_what_is_wrong_has_a_place() {
        let exercise = Publishable { bundle: samples::bundle(), plan: None, advice: Vec::new() };
        let html = samples::keep_page("draft", &page(verdict_of_exercise(&exercise)));
        for wanted in ["id = &#34;", "<svg", "force law only", "name=\"seen\" value=\"3\"", "Publish"] {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
        let issue = Issue {
            file: "attached scene".to_owned(),
            line: 7,
            column: 2,
            field: "layer[0].thickness_mm".to_owned(),
            found: Phrase::data("-1 mm"),
            allowed: phrase!("allowed: a number from {min} to {most}", min = 0.0, most = "200 mm"),
        };
        let refused = DraftPage { refused: true, ..page(verdict_of_refused(&[issue])) };
        let html = samples::keep_page("draft-refused", &refused);
        assert!(html.contains("Scene, line 7, column 2") && html.contains("not published"), "{html}");
    }

    #[test]
    fn publishing_a_course_says_whom_it_concerns_and_asks() {
        let change = CourseChange { mastered: 1, under_way: 12 };
        let html =
            samples::keep_page("draft-change", &DraftPage { refused: true, change, ..page(DraftVerdict::default()) });
        for said in [
            "1 person has mastered the current revision",
            "keeps the mastery",
            "12 people have started the course",
            "value=\"insist\"",
        ] {
            assert!(html.contains(said), "{said} is not in {html}");
        }
    }

    #[test]
    fn advice_can_be_overruled_only_after_a_refused_publication() {
        let issue = Issue {
            file: "document".to_owned(),
            line: 40,
            column: 1,
            field: "rubric[1].full".to_owned(),
            found: phrase!("full {full}, zero {zero}", full = 5.0, zero = 0.5),
            allowed: phrase!("lower {metric} is better: `full` must be less than `zero`", metric = "overshoot_mm"),
        };
        let exercise = Publishable { bundle: samples::bundle(), plan: None, advice: vec![issue] };
        let html = samples::keep_page("draft-advice", &page(verdict_of_exercise(&exercise)));
        assert!(html.contains("Document, line 40, column 1") && html.contains("<svg"), "{html}");
        assert!(!html.contains("not published") && !html.contains("value=\"insist\""), "{html}");
        let held = DraftPage { refused: true, ..page(verdict_of_exercise(&exercise)) };
        let html = samples::keep_page("draft-held", &held);
        assert!(html.contains("not published") && html.contains("value=\"insist\""), "{html}");
    }

    #[test]
    fn in_a_form_what_is_wrong_stands_at_its_field() {
        let text =
            "title = \"T\"\n[target]\ndepth_mm = 900\n[[rubric]]\nmetric = \"peak_force_n\"\nfull = 0.50\nzero = 5\n";
        let document = EditedDocument::from_text(text).expect("TOML");
        let issue = |field: &str, allowed| Issue {
            file: "document".to_owned(),
            line: 3,
            column: 1,
            field: field.to_owned(),
            found: Phrase::data("900 mm"),
            allowed,
        };
        let verdict = verdict_of_refused(&[
            issue("target.depth_mm", phrase!("allowed: at most {length} mm, the needle's length", length = 120.0)),
            issue("rubric[0].weight", phrase!("missing")),
        ]);
        let scene = SceneNames { layers: vec!["fat".to_owned()], structures: Vec::new(), has_rim: true };
        let context = ExerciseContext { scene, pictures: DraftPictures::default() };
        let form = Some(make_exercise_form(&document, &verdict.problems, &context));
        let html = samples::keep_page("draft-form", &DraftPage { form, ..page(verdict) });
        let parts = [
            "href=\"#f-target-depth-mm\">Target depth<",
            "id=\"f-target-depth-mm-why\">900 mm; allowed: at most 120 mm",
            "value=\"0.50\"",
            "Full marks at <span class=\"unit\">(N)</span>",
            "Advance after the pop, tip into fat in mm (better: lower)",
            "1. Peak force: Weight",
        ];
        for wanted in parts {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn instrument_draft_is_folded_and_previewed_per_language() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments/sus.toml");
        let document = EditedDocument::from_text(&std::fs::read_to_string(path).unwrap()).unwrap();
        let form = Some(crate::authoring::document_forms::make_instrument_form(&document, &[]));
        let languages = document.languages();
        let page = DraftPage { form, languages, is_instrument: true, scene: None, ..page(DraftVerdict::default()) };
        let html = samples::keep_page("draft-instrument", &page);
        for wanted in [
            "value=\"look:de\"",
            "<details class=\"form-row folded\" id=\"f-item-9\">",
            "href=\"/surveys/instruments\"",
        ] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn a_conflict_shows_both_texts() {
        let conflict = Some(compare_lines("pass_mark = 70\n", "pass_mark = 75\n"));
        let html = samples::keep_page("draft-conflict", &DraftPage { conflict, ..page(DraftVerdict::default()) });
        assert!(
            html.contains("pass_mark = 70") && html.contains("pass_mark = 75") && html.contains("not saved"),
            "{html}"
        );
    }

    #[test]
    fn drafts_are_listed_or_it_says_how_to_begin() {
        let exercise = ("stop-in-the-fat".to_owned(), "Stop in the fat".to_owned());
        let exercises = vec![SelectOption { value: exercise.0, label: exercise.1, chosen: false }];
        let form = FilledForm::refused(
            NewDraftForm { title: "Ä".to_owned(), kind: NewDraftKind::Course, ..NewDraftForm::default() },
            "id: taken".to_owned(),
        );
        let empty = DraftsPage {
            shell: samples::shell(Role::Instructor),
            drafts: vec![],
            exercises: exercises.clone(),
            instruments: vec![],
            form: FilledForm::default(),
        };
        assert!(samples::keep_page("drafts-empty", &empty).contains("No drafts"));
        let instruments = exercises.clone();
        let full =
            DraftsPage { shell: samples::shell(Role::Instructor), drafts: vec![row()], exercises, instruments, form };
        let html = samples::keep_page("drafts", &full);
        assert!(
            html.contains("href=\"/drafts/1\"") && html.contains("d: taken") && html.contains("value=\"Ä\""),
            "{html}"
        );
    }
}
