//! Documents being written.

use std::collections::BTreeMap;

use askama::Template;
use askama_web::WebTemplate;
use documents::{Curriculum, ExerciseBundle, Issue, Wording};
use model::draft::{CourseChange, DraftRemark, DraftVerdict, Publishable};
use model::progress::Mastery;
use serde::Deserialize;
use time::OffsetDateTime;
use tissue::follow::FieldPlan;

use super::authoring::{DocumentForm, FieldInput};
use super::diff::DiffLine;
use super::exercise::ExerciseFacts;
use super::form::FilledForm;
use super::people::SelectOption;
use super::trainee::rule_in_words;
use super::{Shell, assets, format};

/// The drafts of a school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "drafts.html")]
pub struct DraftsPage {
    /// Frame.
    pub shell: Shell,
    /// Drafts.
    pub drafts: Vec<DraftRow>,
    /// The exercises that may be copied.
    pub exercises: Vec<SelectOption>,
    /// Nothing, and the instruments that may be copied.
    pub instruments: Vec<SelectOption>,
    /// A document to be begun, and why it was not.
    pub form: FilledForm<NewDraftForm>,
}

/// What kind of document is to be begun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NewDraftKind {
    /// An exercise, as a copy of another.
    #[default]
    Exercise,
    /// A course without exercises.
    Course,
    /// An instrument, as a copy of another or without questions.
    Instrument,
}

/// A document to be begun, as it was typed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewDraftForm {
    /// What it will be.
    pub kind: NewDraftKind,
    /// Id of the exercise that is copied.
    pub exercise: String,
    /// Id of the instrument that is copied; empty where it begins without questions.
    pub instrument: String,
    /// Title.
    pub title: String,
    /// Id; empty where it is made from the title.
    pub id: String,
}

impl DraftsPage {
    /// Why the form of a kind was refused.
    #[must_use]
    pub fn refusal_of(&self, kind: NewDraftKind) -> Option<&str> {
        self.form.refused.as_deref().filter(|_| self.form.typed.kind == kind)
    }

    /// What was typed into the form of a kind, once it was refused.
    #[must_use]
    pub fn typed_of(&self, kind: NewDraftKind) -> NewDraftForm {
        if self.form.typed.kind == kind { self.form.typed.clone() } else { NewDraftForm::default() }
    }
}

/// A draft in the list.
#[derive(Clone, Debug)]
pub struct DraftRow {
    /// Its page.
    pub href: String,
    /// What it is.
    pub kind: &'static str,
    /// The title that stands in it; empty where there is none.
    pub title: String,
    /// Of what it will be a revision.
    pub document_id: String,
    /// Who saved it last.
    pub saved_by: String,
    /// When.
    pub saved_at: OffsetDateTime,
}

/// The page where a draft is written.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "draft.html")]
pub struct DraftPage {
    /// Frame.
    pub shell: Shell,
    /// The draft.
    pub draft: DraftRow,
    /// It is an instrument.
    pub is_instrument: bool,
    /// Codes of the languages in which an instrument can be seen as whoever answers sees it.
    pub languages: Vec<String>,
    /// The exercise, the course or the instrument, as it was typed.
    pub document: String,
    /// The scene of an exercise, as it was typed.
    pub scene: Option<String>,
    /// The version that was seen.
    pub seen: i64,
    /// What somebody else has saved meanwhile, against what was typed here.
    pub conflict: Option<Vec<Vec<DiffLine>>>,
    /// What was just asked for and not done, because of the problems or, until the author insists, the advice.
    pub refused: bool,
    /// Whom publishing would concern, where it was asked for and waits for the author's word.
    pub change: CourseChange,
    /// What it comes to.
    pub verdict: DraftVerdict,
    /// The document as a form; absent where its text is shown.
    pub form: Option<DocumentForm>,
    /// Exercises whose scene can be taken, beside the form of an exercise.
    pub scenes: Vec<SelectOption>,
    /// Title of the scene, beside the form of an exercise.
    pub scene_title: String,
    /// A form was wanted, and the text is no TOML.
    pub unreadable: bool,
    /// It was just saved.
    pub saved: bool,
    /// Why a picture was not added, and nothing saved.
    pub picture_refused: Option<String>,
}

impl DraftPage {
    /// The same after a picture was refused, with what was typed of it.
    #[must_use]
    pub fn with_refused_picture(self, alt: String, why: String) -> Self {
        let form = self.form.map(|form| form.with_refused_picture(&alt, &why));
        Self { form, picture_refused: Some(why), ..self }
    }

    /// A remark as this page shows it.
    #[must_use]
    pub fn show_remark(&self, remark: &DraftRemark) -> ShownRemark {
        ShownRemark::new(self.form.as_ref(), remark)
    }

    /// The address of the script that keeps the verdict up with what is typed.
    #[must_use]
    pub fn script(&self) -> String {
        assets::asset_address("draft.js")
    }
}

/// The verdict alone, to be put into the page while somebody types.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "parts/verdict.html")]
pub struct VerdictPart {
    /// What the draft comes to.
    pub verdict: DraftVerdict,
    /// The form that somebody types into; absent where it is the text.
    pub form: Option<DocumentForm>,
}

impl VerdictPart {
    /// A remark as this part shows it.
    #[must_use]
    pub fn show_remark(&self, remark: &DraftRemark) -> ShownRemark {
        ShownRemark::new(self.form.as_ref(), remark)
    }
}

/// A remark on a draft as a page shows it: beside a form by the name of the field, beside a text by line and column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownRemark {
    /// The field on the page; absent where there is none.
    pub href: Option<String>,
    /// Where.
    pub place: String,
    /// What.
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

/// The verdict on an exercise that could be published.
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

/// The verdict on a course that could be published, with the titles of its exercises by their ids.
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

/// The verdict on a draft that is refused.
#[must_use]
pub fn verdict_of_refused(issues: &[Issue]) -> DraftVerdict {
    DraftVerdict { problems: issues.iter().map(remark_on_issue).collect(), ..DraftVerdict::default() }
}

/// The verdict on a draft that nobody has looked at yet; when to ask again, in s.
#[must_use]
pub fn verdict_while_waiting(retry_after_s: u64) -> DraftVerdict {
    let what = tr!("others of this school are before this; try again in {wait} s", wait = retry_after_s);
    DraftVerdict { problems: vec![DraftRemark::on_all(tr!("Not looked at yet"), what)], ..DraftVerdict::default() }
}

/// Facts under their names.
pub(crate) fn name_facts(facts: Vec<(&'static str, String)>) -> Vec<(String, String)> {
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// What is wrong in a document: where, and what.
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

/// What stands at the field, and what is allowed.
fn say_fault(issue: &Issue) -> String {
    format!("{}; {}", words::phrase(&issue.found), words::phrase(&issue.allowed))
}

/// The same as a remark, which a form shows at its field.
fn remark_on_issue(issue: &Issue) -> DraftRemark {
    if is_in_scene(issue) {
        let (place, what) = say_issue(issue);
        return DraftRemark { place, field: String::new(), what };
    }
    DraftRemark { place: say_issue_place(issue), field: issue.field.clone(), what: say_fault(issue) }
}

/// The planner's verdict.
fn describe_tissue(bundle: &ExerciseBundle, plan: Option<&FieldPlan>) -> Vec<(&'static str, String)> {
    let Some(plan) = plan else {
        return vec![(tr!("Tissue"), tr!("the force law alone: the scene names no model").to_owned())];
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
        (tr!("Tissue's error"), error),
        (tr!("Tissue's size"), size),
    ]
}

#[cfg(test)]
mod tests {
    //! A person must see what is wrong and where, and never lose what they typed.

    use documents::metrics::SceneNames;
    use model::Role;
    use model::authoring::EditedDocument;
    use phrase::{Phrase, phrase};

    use super::*;
    use crate::authoring::{DraftPictures, ExerciseContext, make_exercise_form};
    use crate::diff::compare_lines;
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
        for wanted in ["id = &#34;", "<svg", "the force law alone", "name=\"seen\" value=\"3\"", "Publish"] {
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
        for said in ["1 person has mastered it", "keeps the mastery", "12 people are under way", "value=\"insist\""] {
            assert!(html.contains(said), "{said} is not in {html}");
        }
    }

    #[test]
    fn advice_is_shown_before_publishing_and_may_be_overruled_only_afterwards() {
        let issue = Issue {
            file: "document".to_owned(),
            line: 40,
            column: 1,
            field: "rubric[1].full".to_owned(),
            found: phrase!("full {full}, zero {zero}", full = 5.0, zero = 0.5),
            allowed: phrase!("of {metric} less is better: full must be below zero", metric = "overshoot_mm"),
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
    fn an_instrument_is_folded_and_can_be_looked_at_in_its_languages() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments/sus.toml");
        let document = EditedDocument::from_text(&std::fs::read_to_string(path).unwrap()).unwrap();
        let form = Some(crate::authoring::make_instrument_form(&document, &[]));
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
