//! Reads a curriculum with its exercises: checks for cycles in the prerequisites, then deserialises
//! the typed document.

use phrase::{Phrase, phrase};
use serde::Deserialize;
use serde_json::Value;

use crate::curriculum::{Curriculum, CurriculumEntry, MasteryRule};
use crate::describe::{CURRICULUM, one_of};
use crate::error::DocumentError;
use crate::source::Source;
use crate::walk::{NamedError, Walked};
use crate::wording::{Wording, settle_wordings};

/// A curriculum with the keys of its TOML document.
#[derive(Deserialize)]
struct RawCurriculum {
    id: String,
    title: Wording,
    description: Wording,
    mastery: RawMastery,
    exercise: Vec<RawCurriculumEntry>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct RawMastery {
    rule: String,
    passes: u32,
    of: u32,
    p0: f64,
    p1: f64,
    alpha: f64,
    beta: f64,
    within: Option<u32>,
}

/// Default number of attempts within which the alpha of an LC-CUSUM holds.
const WITHIN: u32 = 50;

#[derive(Deserialize)]
struct RawCurriculumEntry {
    file: String,
    prerequisites: Vec<String>,
    survey: Option<String>,
}

/// An exercise that a curriculum names.
pub(crate) struct NamedExercise<E> {
    /// Its id.
    pub id: String,
    /// The exercise.
    pub exercise: E,
}

/// Reads a curriculum; `read_exercise` loads the exercise at each path.
///
/// # Errors
/// Every issue found in the curriculum, its exercises and their scenes.
pub(crate) fn read_curriculum<E>(
    source: Source,
    read_exercise: impl Fn(&str) -> Result<NamedExercise<E>, NamedError>,
) -> Result<(Curriculum, Vec<E>), DocumentError> {
    let sha256 = source.sha256.clone();
    let mut doc = Walked::new(source, &CURRICULUM)?;
    settle_wordings(&mut doc);
    doc.refuse_duplicates("exercise", "file");
    check_mastery(&mut doc);
    let entries = doc.tables("exercise");
    let mut named_exercises = Vec::new();
    for (at, entry) in entries.iter().enumerate() {
        let named = entry["file"].as_str().map(&read_exercise);
        named_exercises.extend(named.and_then(|named| doc.accept(&format!("exercise[{at}].file"), named)));
    }
    if named_exercises.len() == entries.len() {
        let ids: Vec<&str> = named_exercises.iter().map(|named| named.id.as_str()).collect();
        check_order(&mut doc, &entries, &ids);
    }
    let raw = doc.finish()?;
    let ids: Vec<String> = named_exercises.iter().map(|named| named.id.clone()).collect();
    let exercises = named_exercises.into_iter().map(|named| named.exercise).collect();
    Ok((curriculum(raw, ids, sha256), exercises))
}

/// Checks that ids are unique, that prerequisites exist, and that no exercise depends on itself.
fn check_order(doc: &mut Walked, entries: &[Value], ids: &[&str]) {
    let mut needs: Vec<Vec<usize>> = Vec::new();
    for (at, entry) in entries.iter().enumerate() {
        if let Some(first) = ids.iter().take(at).position(|id| *id == ids[at]) {
            let allowed = phrase!("exercise[{first}] already has this id; each must be unique", first = first);
            doc.refuse(&format!("exercise[{at}].file"), Phrase::quoted(ids[at]), allowed);
        }
        let mut found = Vec::new();
        for id in entry["prerequisites"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            match ids.iter().position(|known| *known == id) {
                Some(needed) => found.push(needed),
                None => {
                    let field = format!("exercise[{at}].prerequisites");
                    doc.refuse(&field, Phrase::quoted(id), one_of(ids));
                }
            }
        }
        needs.push(found);
    }
    if let Some(cycle) = find_cycle(&needs) {
        let path: Vec<_> = cycle.iter().map(|&at| ids[at]).collect();
        let field = format!("exercise[{}].prerequisites", cycle[0]);
        let found = phrase!("a cycle: {path}", path = path.join(" → "));
        doc.refuse(&field, found, phrase!("allowed: prerequisites without a cycle"));
    }
}

/// Returns a path from an exercise along its prerequisites back to itself, if there is one.
fn find_cycle(needs: &[Vec<usize>]) -> Option<Vec<usize>> {
    let mut done = vec![false; needs.len()];
    (0..needs.len()).find_map(|start| visit(needs, start, &mut Vec::new(), &mut done))
}

fn visit(needs: &[Vec<usize>], at: usize, path: &mut Vec<usize>, done: &mut [bool]) -> Option<Vec<usize>> {
    if let Some(start) = path.iter().position(|&p| p == at) {
        return Some(path[start..].iter().copied().chain([at]).collect());
    }
    if done[at] {
        return None;
    }
    path.push(at);
    let cycle = needs[at].iter().find_map(|&next| visit(needs, next, path, done));
    path.pop();
    done[at] = true;
    cycle
}

/// Checks that a rule has the keys that it requires and no others.
fn check_mastery(doc: &mut Walked) {
    const COUNTS: [&str; 2] = ["passes", "of"];
    const RATES: [&str; 4] = ["p0", "p1", "alpha", "beta"];
    let mastery = doc.value["mastery"].clone();
    let Some(rule) = mastery["rule"].as_str() else { return };
    let (needed, other): (&[&str], &[&str]) = if rule == "passes" { (&COUNTS, &RATES) } else { (&RATES, &COUNTS) };
    for key in needed.iter().filter(|key| !doc.is_written(&format!("mastery.{key}"))).collect::<Vec<_>>() {
        doc.refuse(&format!("mastery.{key}"), phrase!("missing"), phrase!("required for the rule {rule}", rule = rule));
    }
    for key in other.iter().filter(|key| !mastery[**key].is_null()) {
        let allowed = phrase!("the rule {rule} has {keys}", rule = rule, keys = needed.join(", "));
        doc.refuse(&format!("mastery.{key}"), phrase!("not a key of this rule"), allowed);
    }
    let pair = |a: &str, b: &str| Some((mastery[a].as_f64()?, mastery[b].as_f64()?));
    if let Some((passes, of)) = pair("passes", "of").filter(|(passes, of)| passes > of) {
        let allowed = phrase!("allowed: at most {of}, the rule's `of`", of = of);
        doc.refuse("mastery.passes", Phrase::data(passes), allowed);
    }
    if let Some((p0, p1)) = pair("p0", "p1").filter(|(p0, p1)| p1 <= p0) {
        doc.refuse("mastery.p1", Phrase::data(p1), phrase!("allowed: above {p0}, the rule's p0", p0 = p0));
    }
    if let Some((alpha, beta)) = pair("alpha", "beta").filter(|(alpha, beta)| alpha + beta >= 1.0) {
        let allowed =
            phrase!("allowed: below {limit}, so that its sum with the rule's alpha is below 1", limit = 1.0 - alpha);
        doc.refuse("mastery.beta", Phrase::data(beta), allowed);
    }
    if rule != "lc-cusum" && !mastery["within"].is_null() {
        doc.refuse("mastery.within", phrase!("not a key of this rule"), phrase!("allowed only for the rule lc-cusum"));
    }
}

fn curriculum(raw: RawCurriculum, ids: Vec<String>, sha256: String) -> Curriculum {
    let entry = |(entry, exercise): (RawCurriculumEntry, String)| CurriculumEntry {
        file: entry.file,
        exercise,
        prerequisites: entry.prerequisites,
        survey: entry.survey,
    };
    let RawMastery { rule, passes, of, p0, p1, alpha, beta, within } = raw.mastery;
    let within = (rule == "lc-cusum").then(|| within.unwrap_or(WITHIN));
    Curriculum {
        id: raw.id,
        title: raw.title,
        description: raw.description.trimmed(),
        entries: raw.exercise.into_iter().zip(ids).map(entry).collect(),
        mastery: match rule.as_str() {
            "passes" => MasteryRule::Passes { passes, of },
            _ => MasteryRule::Cusum { within, p0, p1, alpha, beta },
        },
        sha256,
    }
}
