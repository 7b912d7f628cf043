//! What is sent of a draft: its text, or what was typed into its form.

use acts::error::Error;
use model::authoring::{EditedDocument, FieldSort, SentForm, TypedField, add_course_exercise};
use model::ids::SchoolId;
use pages::authoring::{FIELD_PREFIX, begin_scale, place_id};
use routes_base::forms::unix_lines;
use serde::Deserialize;
use store::drafts::Texts;

/// How a draft is shown and written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum DraftView {
    /// Field by field.
    #[default]
    Form,
    /// As its text.
    Toml,
}

/// For which school a draft is shown, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownFor {
    pub school: SchoolId,
    pub view: DraftView,
}

impl DraftView {
    /// This view, for a school.
    pub(super) const fn of(self, school: SchoolId) -> ShownFor {
        ShownFor { school, view: self }
    }

    /// The query that asks for it.
    pub(super) const fn query(self) -> &'static str {
        match self {
            Self::Form => "",
            Self::Toml => "?view=toml",
        }
    }
}

/// What is to be done with what was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DraftAct {
    Save,
    Publish,
    /// Publish what an author should change, too.
    Insist,
    /// Save, and show it otherwise.
    Show(DraftView),
    /// Save, and show it in this language as whoever answers sees it.
    Look(String),
    /// Save it with the scene of this exercise in the place of its own.
    TakeScene(String),
    /// Add the picture that is sent with it.
    AddPicture,
    /// Rows of the form have changed: the place on the page to go on from.
    Changed(String),
}

/// What is sent of a draft.
#[derive(Clone, Debug)]
pub(super) struct SentDraft {
    /// The version that was seen; 0 where it does not matter.
    pub seen: i64,
    /// How it was written.
    pub view: DraftView,
    /// What is written now, the form's fields and the rows that come or go included.
    pub texts: Texts,
    /// What is to be done with it.
    pub act: DraftAct,
}

impl SentDraft {
    /// Reads what was sent.
    ///
    /// # Errors
    /// Without a text, or with an act that there is not.
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
    Error::BadRequest(tr!("The form lacks “{field}”, or has something in it that no page sends.", field = name))
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

/// The fields of the document among all that were sent.
fn read_form(fields: &[(String, String)]) -> SentForm {
    let boxes = fields.iter().filter(|(name, _)| name == "box").map(|(_, field)| field.clone()).collect();
    let typed = |(name, value): &(String, String)| {
        let field = name.strip_prefix(FIELD_PREFIX)?.to_owned();
        Some(TypedField { field, typed: unix_lines(value) })
    };
    SentForm { boxes, fields: fields.iter().filter_map(typed).collect() }
}

/// The arrays whose rows come and go by buttons.
const ARRAYS: [&str; 9] =
    ["rubric", "hard_fail", "coaching", "picture", "exercise", "scale", "section", "item", "score"];

/// Adds, takes away or moves a row, where that is asked for: the place on the page to go on from.
fn change_rows(document: &mut EditedDocument, asked: &str, chosen: impl Fn(&str) -> String) -> Option<String> {
    let (verb, what) = asked.split_once(':')?;
    let (array, row) = match what.strip_suffix(']').and_then(|what| what.rsplit_once('[')) {
        Some((array, row)) => (array, row.parse().ok()?),
        None => (what, document.count_rows(what)),
    };
    if array == "languages" {
        return change_languages(document, verb, row, &chosen(array));
    }
    // A picture comes with its file, by an address of its own.
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

/// Adds a language, or takes one away with its texts. A document that does not say in which language it is written is taken to be in the
/// reader's.
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

/// A new row with what was chosen for it.
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
