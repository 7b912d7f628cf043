//! Reads an instrument: checks the references between its parts, then deserialises the typed
//! document.

use phrase::{Phrase, phrase};
use serde_json::Value;

use crate::describe::{INSTRUMENT, one_of};
use crate::error::DocumentError;
use crate::instrument::Instrument;
use crate::source::Source;
use crate::walk::Walked;

/// Required and optional keys of each kind of scale.
const KEYS: [(&str, &[&str], &[&str]); 7] = [
    ("likert", &["points"], &["labels", "first", "last", "relevant_from"]),
    ("slider", &["min", "max", "step"], &["first", "last"]),
    ("pair", &[], &[]),
    ("choice", &["option"], &[]),
    ("choices", &["option"], &[]),
    ("number", &["min", "max", "unit"], &[]),
    ("text", &["max_characters"], &[]),
];

impl Instrument {
    /// Reads an instrument from the bytes of a document; errors refer to it as `name`.
    ///
    /// # Errors
    /// Every issue found.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, DocumentError> {
        read_instrument(Source::new(name, bytes)?)
    }
}

/// Reads an instrument.
///
/// # Errors
/// Every issue found.
pub(crate) fn read_instrument(source: Source) -> Result<Instrument, DocumentError> {
    let sha256 = source.sha256.clone();
    let mut doc = Walked::new(source, &INSTRUMENT)?;
    for array in ["scale", "section", "item", "score"] {
        doc.refuse_duplicates(array, "id");
    }
    check_languages(&mut doc);
    check_scales(&mut doc);
    check_items(&mut doc);
    check_scores(&mut doc);
    let instrument: Instrument = doc.finish()?;
    Ok(Instrument { sha256, ..instrument })
}

/// Returns the texts of a list.
fn texts<'v>(value: &'v Value, key: &str) -> Vec<&'v str> {
    value[key].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Checks that the languages are known and unique, and that every text exists in each of them and
/// in no other.
fn check_languages(doc: &mut Walked) {
    let value = doc.value.clone();
    let languages = texts(&value, "languages");
    if languages.is_empty() && value["languages"].is_array() {
        doc.refuse("languages", phrase!("none"), phrase!("allowed: at least one language"));
    }
    for (at, language) in languages.iter().enumerate() {
        if languages[..at].contains(language) {
            doc.refuse("languages", Phrase::quoted(language), phrase!("each must be unique"));
        }
    }
    let mut found = Vec::new();
    collect_words(&value, "", &mut found);
    for (path, words) in found {
        for language in languages.iter().filter(|language| words[**language].is_null()) {
            // A refused text is present and already has its issue.
            if !doc.is_written(&format!("{path}.{language}")) {
                let allowed = phrase!("a text in each of the languages is required");
                doc.refuse(&format!("{path}.{language}"), phrase!("missing"), allowed);
            }
        }
        for language in words.as_object().into_iter().flat_map(|map| map.keys()) {
            if !languages.contains(&language.as_str()) {
                let languages = languages.join(", ");
                let allowed = phrase!("allowed: {languages}, the languages of this instrument", languages = languages);
                doc.refuse(&format!("{path}.{language}"), phrase!("a text in another language"), allowed);
            }
        }
    }
}

/// Collects every multilingual text below a value, identified by its key.
fn collect_words<'v>(value: &'v Value, path: &str, found: &mut Vec<(String, &'v Value)>) {
    const WORDS: [&str; 6] = ["title", "intro", "text", "name", "first", "last"];
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                if WORDS.contains(&key.as_str()) {
                    found.push((path, inner));
                } else {
                    collect_words(inner, &path, found);
                }
            }
        }
        Value::Array(list) => {
            for (at, inner) in list.iter().enumerate() {
                let element = format!("{path}[{at}]");
                if path.ends_with(".labels") {
                    found.push((element, inner))
                } else {
                    collect_words(inner, &element, found)
                }
            }
        }
        _ => {}
    }
}

fn check_scales(doc: &mut Walked) {
    for (at, scale) in doc.tables("scale").iter().enumerate() {
        let Some((kind, needed, allowed)) = KEYS.iter().find(|(kind, ..)| scale["kind"] == *kind) else { continue };
        let path = format!("scale[{at}]");
        for key in needed.iter().filter(|key| !doc.is_written(&format!("{path}.{key}"))).collect::<Vec<_>>() {
            doc.refuse(
                &format!("{path}.{key}"),
                phrase!("missing"),
                phrase!("required for the kind {kind}", kind = *kind),
            );
        }
        for key in scale.as_object().into_iter().flat_map(|map| map.keys()) {
            if !["id", "kind"].contains(&key.as_str())
                && !needed.contains(&key.as_str())
                && !allowed.contains(&key.as_str())
            {
                let keys = [*needed, *allowed].concat().join(", ");
                let allowed = match keys.as_str() {
                    "" => phrase!("the kind {kind} has no keys of its own", kind = *kind),
                    keys => phrase!("the kind {kind} has {keys}", kind = *kind, keys = keys),
                };
                doc.refuse(&format!("{path}.{key}"), phrase!("not a key of this kind"), allowed);
            }
        }
        check_range(doc, scale, &path);
        let ids: Vec<&str> =
            scale["option"].as_array().into_iter().flatten().filter_map(|o| o["id"].as_str()).collect();
        for (nth, id) in ids.iter().enumerate().filter(|(nth, id)| ids[..*nth].contains(id)) {
            doc.refuse(&format!("{path}.option[{nth}].id"), Phrase::quoted(id), phrase!("each must be unique"));
        }
    }
}

fn check_range(doc: &mut Walked, scale: &Value, path: &str) {
    if let (Some(min), Some(max)) = (scale["min"].as_f64(), scale["max"].as_f64()) {
        if max <= min {
            let allowed = phrase!("allowed: above {min}, its min", min = min);
            doc.refuse(&format!("{path}.max"), Phrase::data(max), allowed);
        } else if scale["step"].as_f64().is_some_and(|step| step > max - min) {
            let allowed = phrase!("allowed: at most {most}, its max minus its min", most = max - min);
            doc.refuse(&format!("{path}.step"), Phrase::data(&scale["step"]), allowed);
        }
    }
    let Some(points) = scale["points"].as_u64() else { return };
    if let Some(labels) = scale["labels"].as_array().map(Vec::len).filter(|labels| *labels as u64 != points) {
        let found = phrase!("{count} labels", count = labels);
        doc.refuse(&format!("{path}.labels"), found, phrase!("allowed: {points}, one for each point", points = points));
    }
    if let Some(from) = scale["relevant_from"].as_u64().filter(|from| *from > points) {
        let allowed = phrase!("allowed: at most {points}, its points", points = points);
        doc.refuse(&format!("{path}.relevant_from"), Phrase::data(from), allowed);
    }
}

fn check_items(doc: &mut Walked) {
    let (sections, items, scales) = (doc.tables("section"), doc.tables("item"), doc.tables("scale"));
    for (at, item) in items.iter().enumerate() {
        let path = format!("item[{at}]");
        refuse_unknown(doc, &format!("{path}.scale"), &item["scale"], &scales);
        match (item["section"].as_str(), sections.is_empty()) {
            (Some(_), _) => refuse_unknown(doc, &format!("{path}.section"), &item["section"], &sections),
            (None, false) if !doc.is_written(&format!("{path}.section")) => {
                let allowed = phrase!("required for every item of an instrument with sections");
                doc.refuse(&format!("{path}.section"), phrase!("missing"), allowed);
            }
            (None, _) => {}
        }
        check_pair(doc, &path, item, &items, &scales);
        check_condition(doc, &format!("{path}.when"), &item["when"], position_of(&sections, &item["section"]));
    }
    for (at, section) in sections.iter().enumerate() {
        check_condition(doc, &format!("section[{at}].when"), &section["when"], Some(at));
    }
}

fn position_of(tables: &[Value], id: &Value) -> Option<usize> {
    tables.iter().position(|table| table["id"] == *id)
}

fn refuse_unknown(doc: &mut Walked, field: &str, id: &Value, tables: &[Value]) {
    if let Some(written) = id.as_str().filter(|_| position_of(tables, id).is_none()) {
        let known: Vec<&str> = tables.iter().filter_map(|table| table["id"].as_str()).collect();
        doc.refuse(field, Phrase::quoted(written), one_of(&known));
    }
}

fn scale_of<'v>(item: &Value, scales: &'v [Value]) -> Option<&'v Value> {
    scales.iter().find(|scale| scale["id"] == item["scale"])
}

fn check_pair(doc: &mut Walked, path: &str, item: &Value, items: &[Value], scales: &[Value]) {
    let is_pair = scale_of(item, scales).is_some_and(|scale| scale["kind"] == "pair");
    let pair = texts(item, "pair");
    let field = format!("{path}.pair");
    if is_pair && pair.len() != 2 {
        let found = phrase!("{count} items", count = pair.len());
        doc.refuse(&field, found, phrase!("two are required for an item of kind pair"));
    } else if !is_pair && !pair.is_empty() {
        doc.refuse(&field, phrase!("a pair"), phrase!("allowed: only where the scale is of kind pair"));
    }
    for id in pair {
        refuse_unknown(doc, &field, &Value::from(id), items);
    }
}

/// A form without scripts receives an answer only when its section is submitted, so conditions may
/// only refer to earlier sections.
fn check_condition(doc: &mut Walked, path: &str, when: &Value, section: Option<usize>) {
    let Some(asked) = when["item"].as_str() else { return };
    let (sections, items, scales) = (doc.tables("section"), doc.tables("item"), doc.tables("scale"));
    let Some(item) = items.iter().find(|item| item["id"] == asked) else {
        return refuse_unknown(doc, &format!("{path}.item"), &when["item"], &items);
    };
    let earlier = position_of(&sections, &item["section"]).zip(section).is_some_and(|(asked, here)| asked < here);
    if !earlier {
        let allowed = phrase!("allowed: an item of an earlier section");
        doc.refuse(&format!("{path}.item"), Phrase::quoted(asked), allowed);
    }
    let Some(scale) = scale_of(item, &scales) else { return };
    let points = (1..=scale["points"].as_u64().unwrap_or(0)).map(|point| point.to_string());
    let options = scale["option"].as_array().into_iter().flatten().filter_map(|o| o["id"].as_str()).map(str::to_owned);
    let known: Vec<String> = points.chain(options).collect();
    for answer in texts(when, "is").into_iter().filter(|answer| !known.iter().any(|k| k == answer)) {
        let allowed = if known.is_empty() { phrase!("allowed: likert, choice and choices") } else { one_of(&known) };
        doc.refuse(&format!("{path}.is"), Phrase::quoted(answer), allowed);
    }
}

fn check_scores(doc: &mut Walked) {
    let (items, scales) = (doc.tables("item"), doc.tables("scale"));
    let kind = |id: &str| {
        let item = items.iter().find(|item| item["id"] == id)?;
        scale_of(item, &scales)?["kind"].as_str()
    };
    for (at, score) in doc.tables("score").iter().enumerate() {
        let path = format!("score[{at}]");
        let counted = texts(score, "items");
        if counted.is_empty() && score["items"].is_array() {
            doc.refuse(&format!("{path}.items"), phrase!("none"), phrase!("allowed: at least one item"));
        }
        for (key, allowed) in [("items", &["likert", "slider", "number"][..]), ("pairs", &["pair"])] {
            for id in texts(score, key).into_iter().filter(|id| !kind(id).is_some_and(|kind| allowed.contains(&kind))) {
                let allowed = phrase!("allowed: items of kind {kinds}", kinds = allowed.join(", "));
                doc.refuse(&format!("{path}.{key}"), Phrase::quoted(id), allowed);
            }
        }
        for id in texts(score, "reversed").into_iter().filter(|id| !counted.contains(id)) {
            doc.refuse(&format!("{path}.reversed"), Phrase::quoted(id), phrase!("allowed: items of this score"));
        }
        check_combination(doc, score, &path, counted.len());
    }
}

fn check_combination(doc: &mut Walked, score: &Value, path: &str, counted: usize) {
    let weighted = score["combine"] == "pair-weighted";
    if weighted == texts(score, "pairs").is_empty() {
        let found = if weighted { phrase!("missing") } else { phrase!("pairs") };
        let allowed = phrase!("required for a pair-weighted score, not allowed for others");
        doc.refuse(&format!("{path}.pairs"), found, allowed);
    }
    let least = score["least_answered"].as_u64();
    match (score["missing"] == "mean-of-answered", least) {
        (true, None) => {
            doc.refuse(&format!("{path}.least_answered"), phrase!("missing"), phrase!("required for mean-of-answered"));
        }
        (true, Some(_)) if weighted => {
            let allowed = phrase!("allowed with pair-weighted: no-score");
            doc.refuse(&format!("{path}.missing"), Phrase::data("mean-of-answered"), allowed);
        }
        (true, Some(least)) if least > counted as u64 => {
            let allowed = phrase!("allowed: at most {counted}, the items of this score", counted = counted);
            doc.refuse(&format!("{path}.least_answered"), Phrase::data(least), allowed);
        }
        (false, Some(_)) => {
            let found = phrase!("not a key of this policy");
            doc.refuse(&format!("{path}.least_answered"), found, phrase!("allowed only for mean-of-answered"));
        }
        _ => {}
    }
}
