//! Every sentence that is said has a place in every catalogue, and every catalogue holds what is said and no more.
//! Fails when a sentence was added, changed or taken away and the catalogues were not brought up to date, when nobody
//! has translated it, or when a translation lost a value that stands in the sentence.
//!
//! To bring the catalogues up to date: `STYLET_UPDATE_WORDS=1 cargo test --workspace --test main words`. It adds what is
//! new with an empty translation, takes out what is gone and keeps the rest. A new language begins as a file with a
//! header alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use assessment::{Absent, UnmetRequirement};
use polib::catalog::Catalog;
use polib::message::{Message, MessageView};
use polib::po_file;

/// Words that are data as well, and are said by `words::known`: of libraries that speak English alone.
const KNOWN: [&str; 17] = [
    "target",
    "vessel",
    "nerve",
    "bone",
    "organ",
    "trainee",
    "instructor",
    "administrator",
    "professional",
    "experts",
    "trocar",
    "needle",
    "diamond",
    "conical",
    "blunt",
    "all",
    "bevel",
];

/// Where sentences are said.
const SAID_IN: [&str; 18] = [
    "pages/templates",
    "pages/src",
    "../sim/words/src",
    "model/src",
    "platform/src",
    "acts/src",
    "src",
    "routes",
    "../sim/phrase/src",
    "../sim/law/src",
    "../sim/tissue/src",
    "../sim/anatomy/src",
    "../sim/documents/src",
    "../sim/dossier/src",
    "../sim/assessment/src",
    "../sim/haptics/src",
    "../sim/render/src",
    "../sim/client/src",
];

/// A sentence: its form for one where it has two, and where it is said.
#[derive(Debug, Default)]
struct Said {
    many: Option<String>,
    files: Vec<String>,
}

type Sentences = BTreeMap<String, Said>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension != "bin") {
            found.push(path);
        }
    }
}

/// A string literal at the beginning of a source, and what follows it.
fn literal(source: &str) -> Option<(String, &str)> {
    let inner = source.trim_start().strip_prefix('"')?;
    let mut text = String::new();
    let mut rest = inner.char_indices();
    while let Some((at, c)) = rest.next() {
        match c {
            '"' => return Some((text, &inner[at + 1..])),
            '\\' => match rest.next()?.1 {
                '\n' => {
                    while rest.as_str().starts_with([' ', '\n']) {
                        rest.next();
                    }
                }
                other => text.push(other),
            },
            other => text.push(other),
        }
    }
    None
}

/// The sentences of a source, by the macros that say them.
fn sentences_of(source: &str, file: &str, all: &mut Sentences) {
    let code: String =
        source.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(|line| [line, "\n"]).collect();
    for (opening, has_two) in [("tr!(", false), ("trn!(", true), ("sentence!(", false), ("phrase!(", false)] {
        // Not the end of another macro's name, as that of include_str is.
        let is_whole = |at: &usize| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        for at in code.match_indices(opening).map(|(at, _)| at).filter(is_whole) {
            let Some((one, rest)) = literal(&code[at + opening.len()..]) else { continue };
            let said = all.entry(one).or_default();
            if has_two {
                said.many = rest.trim_start().strip_prefix(',').and_then(literal).map(|(many, _)| many);
            }
            if said.files.last().is_none_or(|last| last != file) {
                said.files.push(file.to_owned());
            }
        }
    }
}

fn sentences() -> Sentences {
    let mut paths = Vec::new();
    for folder in SAID_IN {
        files_below(&root().join(folder), &mut paths);
    }
    let mut all = Sentences::new();
    for path in paths {
        let file = path.strip_prefix(root()).unwrap().to_string_lossy().trim_start_matches("../").to_owned();
        sentences_of(&fs::read_to_string(&path).unwrap(), &file, &mut all);
    }
    let catalogue =
        assessment::catalogue::DEFINITIONS.iter().flat_map(|d| [d.label, d.definition, d.advice, d.unoffered]);
    let absent = Absent::ALL.into_iter().chain([Absent::OfAnotherVersion]).map(Absent::words);
    let unmet = UnmetRequirement::ALL.into_iter().flat_map(|unmet| [unmet.words(), unmet.failure_words()]);
    for word in KNOWN.into_iter().chain(absent).chain(unmet).chain(catalogue).filter(|word| !word.is_empty()) {
        all.entry(word.to_owned()).or_default().files.push("data".to_owned());
    }
    all
}

fn catalogues() -> Vec<(PathBuf, Catalog)> {
    let mut paths = Vec::new();
    files_below(&root().join("../sim/words/locales"), &mut paths);
    paths.into_iter().map(|path| (path.clone(), po_file::parse(&path).unwrap())).collect()
}

/// A catalogue with exactly these sentences, and what it had for them.
fn up_to_date(old: &Catalog, sentences: &Sentences) -> Catalog {
    let mut new = Catalog::new(old.metadata.clone());
    new.preheader.clone_from(&old.preheader);
    for (one, said) in sentences {
        let known = old.find_message(None, one, said.many.as_deref());
        let comments = known.map_or("", MessageView::translator_comments).to_owned();
        let mut message = match &said.many {
            Some(many) => {
                let forms = known.and_then(|known| known.msgstr_plural().ok().cloned());
                let forms = forms.unwrap_or_else(|| vec![String::new(); old.metadata.plural_rules.nplurals]);
                let mut message = Message::build_plural();
                message.with_msgid_plural(many.clone()).with_msgstr_plural(forms);
                message
            }
            None => {
                let mut message = Message::build_singular();
                message.with_msgstr(known.and_then(|known| known.msgstr().ok()).unwrap_or_default().to_owned());
                message
            }
        };
        message.with_msgid(one.clone()).with_source(said.files.join("\n")).with_translator_comments(comments);
        new.append_or_update(message.done());
    }
    new
}

/// Names in braces, in order, each once.
fn names(sentence: &str) -> Vec<&str> {
    let mut names: Vec<&str> =
        sentence.split('{').skip(1).filter_map(|rest| rest.split_once('}')).map(|(name, _)| name).collect();
    names.sort_unstable();
    names.dedup();
    names
}

#[test]
fn every_catalogue_says_everything_that_is_said() {
    let sentences = sentences();
    assert!(sentences.len() > 500, "{} sentences are found: the search is broken", sentences.len());
    for (path, old) in catalogues() {
        let new = up_to_date(&old, &sentences);
        if std::env::var_os("STYLET_UPDATE_WORDS").is_some() {
            po_file::write_to_file(&new, &path).unwrap();
        }
        let ids = |catalogue: &Catalog| -> Vec<String> { catalogue.messages().map(|m| m.msgid().to_owned()).collect() };
        let (mut has, needs) = (ids(&old), ids(&new));
        has.sort();
        let missing: Vec<_> = needs.iter().filter(|id| !has.contains(id)).collect();
        let left_over: Vec<_> = has.iter().filter(|id| !needs.contains(id)).collect();
        let untranslated: Vec<_> =
            new.messages().filter(|m| !m.is_translated() || m.is_fuzzy()).map(|m| m.msgid().to_owned()).collect();
        assert!(missing.is_empty(), "{} lacks {missing:#?}; see the head of this test", path.display());
        assert!(left_over.is_empty(), "{} has what nobody says: {left_over:#?}", path.display());
        assert!(untranslated.is_empty(), "{} has no translation of {untranslated:#?}", path.display());
    }
}

#[test]
fn every_translation_keeps_the_values_and_has_its_forms() {
    for (path, catalogue) in catalogues() {
        for message in catalogue.messages() {
            let id = message.msgid();
            let forms = message
                .msgstr_plural()
                .cloned()
                .or_else(|_| message.msgstr().map(|form| vec![form.to_owned()]))
                .unwrap();
            let many = message.msgid_plural().unwrap_or(id);
            let expected = if message.is_plural() { catalogue.metadata.plural_rules.nplurals } else { 1 };
            assert_eq!(forms.len(), expected, "{}: forms of “{id}”", path.display());
            for form in &forms {
                let fits = names(form) == names(id) || names(form) == names(many);
                assert!(fits, "{}: “{form}” has other values than “{many}”", path.display());
                // An abbreviated month ends with a full stop in one language and not in the other.
                let ends = form.ends_with('.') == many.ends_with('.') || !id.contains(' ');
                assert!(ends, "{}: the full stop of “{form}”", path.display());
            }
        }
    }
}

/// String literals of a source outside its tests, each with its line.
fn literals(source: &str) -> Vec<(String, String)> {
    let code = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut found = Vec::new();
    for line in code.lines().filter(|line| !line.trim_start().starts_with("//")) {
        let mut rest = line;
        while let Some(at) = rest.find('"') {
            let Some((text, after)) = literal(&rest[at..]) else { break };
            found.push((text, line.to_owned()));
            rest = after;
        }
    }
    found
}

/// Whether a text has two words beside each other, as sentences have and names of things in the code have not.
fn reads_like_a_sentence(text: &str) -> bool {
    let is_word = |word: &str| word.len() > 1 && word.chars().all(char::is_alphabetic);
    text.split(' ').collect::<Vec<_>>().windows(2).any(|pair| pair.iter().all(|word| is_word(word)))
}

#[test]
fn the_window_says_nothing_past_the_catalogues() {
    let sentences = sentences();
    let known =
        |text: &str| sentences.contains_key(text) || sentences.values().any(|said| said.many.as_deref() == Some(text));
    let mut paths = Vec::new();
    files_below(&root().join("../sim/client/src/window"), &mut paths);
    let tests = |path: &PathBuf| path.file_name().is_some_and(|name| name == "tests.rs");
    for path in paths.into_iter().filter(|path| !tests(path)) {
        for (text, line) in literals(&fs::read_to_string(&path).unwrap()) {
            // What ends the program is told on the command line, in English.
            let for_the_terminal = line.contains("Failure::") || line.contains("ok_or(");
            let for_developers = line.contains("reason = \"") || line.contains(".expect(\"");
            let said = !reads_like_a_sentence(&text) || known(&text) || for_the_terminal || for_developers;
            assert!(said, "{}: “{text}” is said in English alone: {line}", path.display());
        }
    }
}
