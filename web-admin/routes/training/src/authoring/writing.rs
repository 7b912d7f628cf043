//! A submitted draft: its text, or the fields of its form.

use acts::error::Error;
use model::authoring::{EditedDocument, FieldSort, SentForm, TypedField, add_course_exercise};
use model::ids::SchoolId;
use pages::authoring::document_forms::{FIELD_PREFIX, begin_scale, place_id};
use routes_base::forms::unix_lines;
use serde::Deserialize;
use store::authoring::drafts::Texts;

/// View in which a draft is shown and edited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum DraftView {
    /// As a form, field by field.
    #[default]
    Form,
    /// As text.
    Toml,
}

/// The school and the view for which a draft is shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownFor {
    pub school: SchoolId,
    pub view: DraftView,
}

impl DraftView {
    /// Returns this view for a school.
    pub(super) const fn of(self, school: SchoolId) -> ShownFor {
        ShownFor { school, view: self }
    }

    /// Returns the query string that selects this view.
    pub(super) const fn query(self) -> &'static str {
        match self {
            Self::Form => "",
            Self::Toml => "?view=toml",
        }
    }
}

/// Action on a submitted draft.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DraftAct {
    Save,
    Publish,
    /// Publish in spite of advice.
    Insist,
    /// Save, and switch to this view.
    Show(DraftView),
    /// Save, and preview it in this language as respondents see it.
    Look(String),
    /// Save it with the scene of this exercise in place of its own.
    TakeScene(String),
    /// Add the picture uploaded with it.
    AddPicture,
    /// Rows of the form have changed: the anchor on the page to continue at.
    Changed(String),
}

/// A submitted draft.
#[derive(Clone, Debug)]
pub(super) struct SentDraft {
    /// The version that the author has seen; 0 if it does not matter.
    pub seen: i64,
    /// The view in which it was edited.
    pub view: DraftView,
    /// The resulting texts, with the form's fields and the added or removed rows applied.
    pub texts: Texts,
    /// The requested action.
    pub act: DraftAct,
}

impl SentDraft {
    /// Parses the submitted fields.
    ///
    /// # Errors
    /// When the text is missing, or the action is unknown.
    pub(super) fn from_fields(fields: Vec<(String, String)>) -> Result<Self, Error> {
        let first = |name: &str| fields.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
        let written = |name: &str| first(name).map(unix_lines);
        let view = if first("view") == Some("form") { DraftView::Form } else { DraftView::Toml };
        let document = written("document").ok_or_else(|| refuse_field("document"))?;
        let scene = written("scene").unwrap_or_default();
        let seen = first("seen").unwrap_or("0").parse().map_err(|_| refuse_field("seen"))?;
        let asked = first("act").unwrap_or("save");
        let form = read_form(&fields);
        let (document, act) = match EditedDocument::from_text(&document).filter(|_| view == DraftView::Form) {
            Some(mut edited) => {
                form.write_into(&mut edited);
                let chosen = |array: &str| first(&format!("new.{array}")).unwrap_or_default().to_owned();
                let act = match change_rows(&mut edited, asked, chosen) {
                    Some(place) => DraftAct::Changed(place),
                    None if asked == "scene" => DraftAct::TakeScene(chosen("scene")),
                    None => read_act(asked)?,
                };
                (edited.into_text(), act)
            }
            None => (document, read_act(asked)?),
        };
        Ok(Self { seen, view, texts: Texts { document, scene }, act })
    }
}

fn refuse_field(name: &str) -> Error {
    Error::BadRequest(tr!(
        "The form lacks “{field}” or contains a value that no page sends. Reload the page and try again.",
        field = name
    ))
}

fn read_act(asked: &str) -> Result<DraftAct, Error> {
    match asked {
        "save" => Ok(DraftAct::Save),
        "publish" => Ok(DraftAct::Publish),
        "insist" => Ok(DraftAct::Insist),
        "add:picture" => Ok(DraftAct::AddPicture),
        "toml" => Ok(DraftAct::Show(DraftView::Toml)),
        "form" => Ok(DraftAct::Show(DraftView::Form)),
        _ => match asked.strip_prefix("look:") {
            Some(language) => Ok(DraftAct::Look(language.to_owned())),
            None => Err(refuse_field("act")),
        },
    }
}

/// Returns the fields of the document among all submitted fields.
fn read_form(fields: &[(String, String)]) -> SentForm {
    let boxes = fields.iter().filter(|(name, _)| name == "box").map(|(_, field)| field.clone()).collect();
    let typed = |(name, value): &(String, String)| {
        let field = name.strip_prefix(FIELD_PREFIX)?.to_owned();
        Some(TypedField { field, typed: unix_lines(value) })
    };
    SentForm { boxes, fields: fields.iter().filter_map(typed).collect() }
}

/// Arrays whose rows can be added and removed by buttons.
const ARRAYS: [&str; 9] =
    ["rubric", "hard_fail", "coaching", "picture", "exercise", "scale", "section", "item", "score"];

/// Adds, removes or moves a row, if requested; returns the anchor on the page to continue at.
fn change_rows(document: &mut EditedDocument, asked: &str, chosen: impl Fn(&str) -> String) -> Option<String> {
    let (verb, what) = asked.split_once(':')?;
    let (array, row) = match what.strip_suffix(']').and_then(|what| what.rsplit_once('[')) {
        Some((array, row)) => (array, row.parse().ok()?),
        None => (what, document.count_rows(what)),
    };
    if array == "languages" {
        return change_languages(document, verb, row, &chosen(array));
    }
    // A picture is added with its file, at an address of its own.
    let is_option = array.starts_with("scale[") && array.ends_with("].option");
    if what == "picture" || !is_option && !ARRAYS.contains(&array) {
        return None;
    }
    match verb {
        "add" => {
            add_chosen(document, array, &chosen(array));
            Some(place_id(&format!("{array}[{row}]")))
        }
        "remove" => {
            match array {
                "item" => document.remove_question(row),
                "section" => document.remove_section(row),
                "scale" => document.remove_scale(row),
                _ => document.remove_row(array, row),
            }
            Some(place_id(array.trim_end_matches(".option")))
        }
        "up" | "down" => {
            let other = if verb == "up" { row.checked_sub(1)? } else { row + 1 };
            document.swap_rows(array, row, other);
            Some(place_id(&format!("{array}[{other}]")))
        }
        _ => None,
    }
}

/// Adds a language, or removes one with its texts. A document that does not name its own language
/// is assumed to be in the reader's language.
fn change_languages(document: &mut EditedDocument, verb: &str, at: usize, chosen: &str) -> Option<String> {
    match verb {
        "add" => {
            let reader = words::current().code();
            document.name_own_language(if reader == chosen { "en" } else { reader });
            document.add_language(chosen);
        }
        "remove" => document.remove_language(at),
        _ => return None,
    }
    Some(place_id("languages"))
}

/// Adds a row with the chosen content.
fn add_chosen(document: &mut EditedDocument, array: &str, chosen: &str) {
    match array {
        "exercise" => add_course_exercise(document, chosen),
        "scale" => drop(begin_scale(document, chosen)),
        "section" => drop(document.add_section()),
        "score" => {
            let row = document.add_named_row(array, "score");
            document.write_field(&format!("score[{row}].combine"), FieldSort::Text, "mean");
        }
        "item" => {
            let made = chosen.strip_prefix("new:").map(|kind| begin_scale(document, kind));
            document.add_question(made.as_deref().unwrap_or(chosen));
        }
        "rubric" | "hard_fail" | "coaching" => {
            let row = document.count_rows(array);
            document.add_row(array, &[]);
            let at = |key: &str| format!("{array}[{row}].{key}");
            match array {
                "coaching" => document.write_field(&at("quantity"), FieldSort::Text, chosen),
                _ => document.write_field(&at("metric"), FieldSort::Metric, chosen),
            }
        }
        _ => drop(document.add_named_row(array, "option")),
    }
}
