//! The pages agree with the tree, are short enough to be read, and are written in plain English. Fails when a page names a missing path,
//! heading or attack, when ARCHITECTURE.md misses a member or draws a wrong arrow, when a dependency has no reason, when a comment of the
//! simulator cites a missing section of docs/physics.md, when a page outgrows its size, or when its text falls back into house idioms.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use tests::{metadata_with, pages, root};

use crate::house::{edges, reachable, sources};

fn architecture() -> String {
    std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md")
}

/// Words in backticks that look like paths of the tree.
fn named_paths(text: &str) -> Vec<&str> {
    let top = ["sim/", "web-admin/", "migrations", "curricula", "tests/", "deploy/", ".ci/", "docs/"];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|word| top.iter().any(|t| word.starts_with(t)) && !word.contains([' ', '*', '<', '{', '…'])).collect()
}

/// What a page names that is made on a machine and lies in no tree.
const MADE: [&str; 3] = ["tests/fuzz/artifacts", "tests/browser/node_modules", "target"];

#[test]
fn every_path_that_a_page_names_exists() {
    let (mut count, mut gone) = (0, Vec::new());
    for page in pages() {
        let text = std::fs::read_to_string(root().join(&page)).expect("a readable page");
        let is_made = |path: &str| MADE.iter().any(|made| path.starts_with(made));
        for path in named_paths(&text) {
            count += 1;
            if !root().join(path).exists() && !is_made(path) {
                gone.push(format!("{page}: {path}"));
            }
        }
    }
    assert!(count > 300, "only {count} paths were found in all pages");
    assert!(gone.is_empty(), "pages name what is gone: {gone:#?}");
}

/// Where a page's links lead, from the page's own folder; those to other sites are left out.
fn relative_links(text: &str) -> Vec<&str> {
    let outside = |target: &str| target.contains("://") || target.starts_with("mailto:") || target.starts_with('/');
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !outside(target) && !target.contains(' ')).collect()
}

/// The names by which headings are linked to.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let letter = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        _ => None,
    };
    headings.map(|heading| heading.chars().filter_map(letter).collect()).collect()
}

/// What is wrong with a link of a page, if anything.
fn broken(page: &str, text: &str, link: &str) -> Option<String> {
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let folder = root().join(page).parent().map(Path::to_path_buf).unwrap_or_default();
    let target = if file.is_empty() { root().join(page) } else { folder.join(file) };
    if !target.exists() {
        return Some(format!("{page}: {link} is not there"));
    }
    let there = if file.is_empty() || anchor.is_empty() {
        text.to_owned()
    } else {
        std::fs::read_to_string(&target).expect("a readable page")
    };
    let known = anchor.is_empty() || anchors(&there).iter().any(|known| known == anchor);
    (!known).then(|| format!("{page}: {link} is no heading"))
}

#[test]
fn every_link_within_the_tree_leads_somewhere() {
    let (mut count, mut wrong) = (0, Vec::new());
    for page in pages() {
        let text = std::fs::read_to_string(root().join(&page)).expect("a readable page");
        let links = relative_links(&text);
        count += links.len();
        wrong.extend(links.iter().filter_map(|link| broken(&page, &text, link)));
    }
    assert!(count > 50, "only {count} links were found in all pages");
    assert!(wrong.is_empty(), "pages link to what is gone: {wrong:#?}");
}

/// Other people's books that comments cite by section, too.
const BOOKS: [&str; 4] = ["Hetényi", "Oppenheim", "Ericson", "assessment"];

/// The sections of docs/physics.md that a source cites. A bare "section 4" is of the physics unless the file cites a book.
fn cited_sections(source: &str) -> Vec<u32> {
    let cites_books = BOOKS.iter().any(|book| source.contains(book));
    let lower = source.to_lowercase();
    let ours = |before: &str| {
        before.ends_with("physics ") || before.ends_with("physics, ") || before.ends_with("physics.md, ")
    };
    let mut sections = Vec::new();
    for (at, _) in lower.match_indices("section ") {
        let (before, rest) = (&lower[..at], &lower[at + "section ".len()..]);
        let number: String = rest.chars().take_while(char::is_ascii_digit).collect();
        if let Ok(number) = number.parse()
            && (ours(before) || !cites_books)
        {
            sections.push(number);
        }
    }
    sections
}

#[test]
fn every_cited_section_is_a_heading_of_the_physics() {
    assert_eq!(cited_sections("/// (physics section 7), as Hetényi, section 13, has it"), [7]);
    let physics = std::fs::read_to_string(root().join("docs/physics.md")).expect("docs/physics.md");
    let (mut open, mut count) = (vec![root().join("sim")], 0);
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).expect("a readable folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let source = std::fs::read_to_string(&path).expect("a readable source");
                for section in cited_sections(&source) {
                    let heading = format!("\n## {section} ");
                    assert!(physics.contains(&heading), "{} cites section {section}", path.display());
                    count += 1;
                }
            }
        }
    }
    assert!(count > 20, "only {count} citations were found");
}

/// The largest size of pages that are read from beginning to end, in bytes.
const LARGEST: [(&str, usize); 3] = [("ARCHITECTURE.md", 16_000), ("CHANGELOG.md", 6_000), ("SECURITY.md", 4_000)];

#[test]
fn pages_for_every_reader_stay_short() {
    for (page, largest) in LARGEST {
        let size = std::fs::read(root().join(page)).expect("a readable page").len();
        assert!(size <= largest, "{page} has {size} bytes, {largest} at most");
    }
}

/// Paraphrases in place of a noun of the field or of a plain verb: alternatives for each word, in order.
const IDIOMS: [&[&[&str]]; 10] = [
    &[&["whoever", "whatever", "wherever", "whomever"]],
    &[
        &["what"],
        &["is", "was", "were", "are", "has", "had", "it", "they", "he", "she", "one", "nobody", "somebody", "others"],
    ],
    &[&["told", "tells", "tell"]],
    &[&["said", "says", "say"]],
    &[&["somebody", "nobody"]],
    &[&["come", "comes"], &["to", "of"]],
    &[&["came"], &["to", "of"]],
    &[&["beside"]],
    &[&["as"], &["it", "they"], &["is", "was", "are", "were"]],
    &[&["is", "are", "was"], &["none"]],
];

/// The most idioms in 1000 words of a page. Respected pages of this kind have 0.2 to 0.3.
const MOST_IDIOMS: f64 = 2.0;

/// The text of a page without the tables that are made from code.
fn written_text(page: &str) -> String {
    let mut parts = page.split("<!-- made from ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.filter_map(|part| part.split_once("<!-- until here -->")).fold(first, |text, (_, rest)| text + rest)
}

/// How many idioms stand in 1000 words of a text.
fn idioms_in_1000_words(text: &str) -> f64 {
    let letter =
        |c: char| if c.is_alphanumeric() || c == '_' || c.is_whitespace() { c.to_string() } else { format!(" {c} ") };
    let spaced: String = text.to_lowercase().chars().map(letter).collect();
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let is_idiom =
        |idiom: &[&[&str]], found: &[&str]| idiom.iter().zip(found).all(|(words, word)| words.contains(word));
    let count = |idiom: &&[&[&str]]| tokens.windows(idiom.len()).filter(|found| is_idiom(idiom, found)).count();
    let idioms: usize = IDIOMS.iter().map(count).sum();
    let words = text.split(|c: char| !c.is_ascii_alphabetic() && c != '\'').filter(|word| !word.is_empty()).count();
    1000.0 * idioms as f64 / words.max(1) as f64
}

#[test]
fn pages_are_written_in_plain_english() {
    let text = "Whoever came\nto it tells what, is told as they were; a beside b is none. Plain words follow here.";
    assert!((idioms_in_1000_words(text) - 350.0).abs() < 1e-9, "{}", idioms_in_1000_words(text));
    assert_eq!(written_text("a<!-- made from x -->b<!-- until here -->c"), "ac");
    let is_ours = |page: &String| !page.contains('/') || page.starts_with("docs/");
    let pages: Vec<String> = pages().into_iter().filter(is_ours).collect();
    assert!(pages.len() > 15, "only {} pages were found", pages.len());
    let read = |page: String| {
        let text = std::fs::read_to_string(root().join(&page)).expect("a readable page");
        (idioms_in_1000_words(&written_text(&text)), page)
    };
    let wordy: Vec<_> = pages.into_iter().map(read).filter(|(idioms, _)| *idioms > MOST_IDIOMS).collect();
    assert!(wordy.is_empty(), "pages with more than {MOST_IDIOMS} idioms in 1000 words: {wordy:?}");
}

/// The comments of a source that stand on lines of their own.
fn comments(source: &str) -> String {
    let lines = source.lines().map(str::trim_start).filter_map(|line| line.strip_prefix("//"));
    lines.map(|line| line.trim_start_matches(['/', '!']).to_owned() + "\n").collect()
}

#[test]
fn comments_are_written_in_plain_english() {
    let mut crates: BTreeMap<String, String> = BTreeMap::new();
    for (path, source) in sources() {
        let parts: Vec<_> = path.iter().take(2).map(|part| part.to_string_lossy()).collect();
        let is_shipped =
            !path.iter().any(|part| part == "tests") && ["sim", "web-admin", "xtask"].contains(&&*parts[0]);
        if is_shipped {
            crates.entry(parts.join("/")).or_default().push_str(&comments(&source));
        }
    }
    assert!(crates.len() > 20, "only {} crates were found", crates.len());
    let measured = crates.into_iter().map(|(name, text)| (idioms_in_1000_words(&text), name));
    let wordy: Vec<_> = measured.filter(|(idioms, _)| *idioms > MOST_IDIOMS).collect();
    assert!(wordy.is_empty(), "crates with more than {MOST_IDIOMS} idioms in 1000 words of comment: {wordy:?}");
}

#[test]
fn the_readme_is_one_that_is_read() {
    let text = std::fs::read_to_string(root().join("README.md")).expect("the README");
    assert!(text.lines().count() <= 110, "README.md has {} lines", text.lines().count());
    let run = std::fs::read_to_string(root().join("deploy/run")).expect("deploy/run");
    let packages = run.lines().find_map(|line| line.strip_prefix("need_programs_or_packages ")).expect("its packages");
    assert!(text.contains(&format!("apt install {packages}\n")), "README.md asks for other packages than deploy/run");
}

#[test]
fn every_member_is_named() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    let text = architecture();
    let members =
        manifest.lines().skip_while(|l| !l.starts_with("members")).skip(1).take_while(|l| !l.starts_with(']'));
    for member in members.map(|l| l.trim().trim_matches([',', '"'])) {
        assert!(text.contains(&format!("`{member}`")), "ARCHITECTURE.md misses the member {member}");
    }
}

/// Nodes of the picture of the crates that are not called like their crate.
const NODES: [(&str, &[&str]); 4] = [
    ("client", &["stylet"]),
    ("base", &["routes-base"]),
    ("routes", &["routes-people", "routes-training", "routes-scoring", "routes-surveys", "routes-api"]),
    ("program", &["web-admin"]),
];

/// The arrows of the picture, from crate to crate.
fn drawn_arrows(text: &str) -> BTreeMap<String, BTreeSet<String>> {
    let crates = |node: &str| {
        let id = node.split('[').next().unwrap_or_default().trim().to_owned();
        let known = NODES.iter().find(|(name, _)| *name == id);
        known.map_or_else(|| vec![id], |(_, crates)| crates.iter().map(|&name| name.to_owned()).collect())
    };
    let picture = text.split("```mermaid\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap_or_default();
    let mut arrows = BTreeMap::<String, BTreeSet<String>>::new();
    for (from, to) in picture.lines().filter_map(|line| line.split_once(" --> ")) {
        let to: BTreeSet<String> = to.split('&').flat_map(crates).collect();
        for from in crates(from) {
            arrows.entry(from).or_default().extend(to.clone());
        }
    }
    arrows
}

#[test]
fn the_picture_of_the_crates_is_true() {
    let (drawn, real) = (drawn_arrows(&architecture()), edges(&metadata_with("stylet/reports")));
    assert!(drawn.len() > 20, "only {} crates are drawn", drawn.len());
    for (from, to) in &drawn {
        let (used, seen) = (reachable(from, &real), reachable(from, &drawn));
        let wrong: Vec<_> = to.difference(&used).collect();
        assert!(wrong.is_empty(), "ARCHITECTURE.md draws arrows from {from} that are not there: {wrong:?}");
        let ours = real[from].iter().filter(|name| drawn.contains_key(*name) || *name == "phrase");
        let missing: Vec<_> = ours.filter(|name| !seen.contains(*name)).collect();
        assert!(missing.is_empty(), "ARCHITECTURE.md draws no arrow from {from} to {missing:?}");
    }
}

/// Dependencies of other authors without a comment above them.
fn without_reason(manifest: &str) -> Vec<&str> {
    let section = manifest.split("[workspace.dependencies]").nth(1).and_then(|rest| rest.split("\n[").next());
    let lines: Vec<&str> = section.unwrap_or_default().lines().collect();
    let is_reason = |line: &str| line.starts_with("# ") && !line.starts_with("# ---");
    let is_foreign = |line: &str| line.contains(" = ") && !line.starts_with('#') && !line.contains("{ path = ");
    let pairs = lines.windows(2).filter(|pair| is_foreign(pair[1]) && !is_reason(pair[0]));
    pairs.filter_map(|pair| pair[1].split(" = ").next()).collect()
}

#[test]
fn every_dependency_has_its_reason() {
    let made_up = "[workspace.dependencies]\nours = { path = \"ours\" }\n# --- theirs\na = \"1\"\n# For b.\nb = \"1\"\n\n[x]\nc = 1\n";
    assert_eq!(without_reason(made_up), ["a"]);
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    let missing = without_reason(&manifest);
    assert!(missing.is_empty(), "Cargo.toml gives no reason for {missing:?}");
}

/// The attacks of the families in tests/attack, as `family/attack`.
fn attacks() -> Vec<String> {
    let families = std::fs::read_dir(root().join("tests/attack/attacks")).expect("families of attacks");
    let scripts =
        families.flatten().map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "py"));
    let mut found = Vec::new();
    for path in scripts {
        let family = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("a readable script");
        let named = text.lines().filter_map(|line| line.strip_prefix("def attack_")?.split('(').next());
        found.extend(named.map(|attack| format!("{family}/{attack}")));
    }
    found
}

#[test]
fn what_is_said_of_security_names_attacks_and_files_that_exist() {
    let read = |page: &str| std::fs::read_to_string(root().join("docs").join(page)).expect("a page");
    let [model, standard] = ["threat-model.md", "asvs.md"].map(read);
    let text = [model, standard.clone()].concat();
    let attacks = attacks();
    let families: Vec<_> = attacks.iter().filter_map(|attack| attack.split('/').next()).collect();
    let is_attack = |word: &&str| word.split_once('/').is_some_and(|(family, _)| families.contains(&family));
    let named: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_attack).collect();
    assert!(named.len() > 40, "only {} attacks are named", named.len());
    let gone: Vec<_> = named.iter().filter(|name| attacks.iter().all(|attack| attack != *name)).collect();
    assert!(gone.is_empty(), "the pages on security name attacks that are gone: {gone:?}");
    for chapter in 1..=17 {
        assert!(standard.contains(&format!("\n| V{chapter} ")), "docs/asvs.md misses the chapter V{chapter}");
    }
}

/// Success criteria of WCAG 2.2, levels A and AA, without 4.1.1, which WCAG 2.2 has withdrawn.
const CRITERIA: &str = "1.1.1 1.2.1 1.2.2 1.2.3 1.2.4 1.2.5 1.3.1 1.3.2 1.3.3 1.3.4 1.3.5 1.4.1 1.4.2 1.4.3 1.4.4 1.4.5 1.4.10 1.4.11 \
    1.4.12 1.4.13 2.1.1 2.1.2 2.1.4 2.2.1 2.2.2 2.3.1 2.4.1 2.4.2 2.4.3 2.4.4 2.4.5 2.4.6 2.4.7 2.4.11 2.5.1 2.5.2 2.5.3 2.5.4 2.5.7 \
    2.5.8 3.1.1 3.1.2 3.2.1 3.2.2 3.2.3 3.2.4 3.2.6 3.3.1 3.3.2 3.3.3 3.3.4 3.3.7 3.3.8 4.1.2 4.1.3";

#[test]
fn accessibility_report_answers_every_criterion() {
    let page = std::fs::read_to_string(root().join("docs/adopt/accessibility.md")).expect("a page");
    let rows: Vec<Vec<&str>> = page
        .lines()
        .filter(|line| line.starts_with("| ") && line.as_bytes().get(2).is_some_and(u8::is_ascii_digit))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    let answered: Vec<&str> = rows.iter().filter_map(|row| row[1].split(' ').next()).collect();
    assert_eq!(answered.iter().copied().collect::<BTreeSet<_>>(), CRITERIA.split_whitespace().collect());
    assert_eq!(answered.len(), CRITERIA.split_whitespace().count(), "each criterion once");
    for row in &rows {
        for file in row[4].split('`').skip(1).step_by(2).filter(|word| word.contains('/')) {
            assert!(root().join(file).is_file(), "{}: {file} is gone", row[1]);
        }
    }
    let count = |state: &str| rows.iter().filter(|row| row[3] == state).count();
    let [met, partly, open, none] = ["met", "partly met", "not evaluated", "not applicable"].map(count);
    assert_eq!(met + partly + open + none, rows.len(), "each has a state");
    let total = format!(
        "Of {} criteria {met} are met, {partly} partly met, {open} not evaluated and {none} not applicable.",
        rows.len()
    );
    assert!(page.contains(&total), "the page does not say: {total}");
}

/// Families of questions of HECVAT 4.1.4 and the number of questions in each.
const QUESTIONS: [(&str, usize); 35] = [
    ("GNRL", 9),
    ("COMP", 5),
    ("REQU", 8),
    ("DOCU", 7),
    ("ITAC", 18),
    ("THRD", 5),
    ("CONS", 9),
    ("APPL", 14),
    ("AAAI", 18),
    ("CHNG", 16),
    ("DATA", 23),
    ("DCTR", 16),
    ("FIDP", 11),
    ("PPPR", 15),
    ("HFIH", 4),
    ("VULN", 6),
    ("HIPA", 29),
    ("PCID", 12),
    ("OPEM", 10),
    ("PRGN", 5),
    ("PCOM", 4),
    ("PDOC", 3),
    ("PTHP", 2),
    ("PCHG", 2),
    ("PDAT", 8),
    ("PRPO", 13),
    ("INTL", 5),
    ("DRPV", 15),
    ("DPAI", 8),
    ("AIQU", 2),
    ("AIGN", 5),
    ("AIPL", 5),
    ("AISC", 5),
    ("AIML", 8),
    ("AILM", 7),
];

/// An edition of the answers to HECVAT: its file in docs/adopt and its words for yes, no, not applicable and operator.
struct Edition {
    file: &'static str,
    answers: [&'static str; 4],
}

const ENGLISH: Edition = Edition { file: "hecvat.md", answers: ["yes", "no", "n. a.", "operator"] };
const GERMAN: Edition = Edition { file: "hecvat-de.md", answers: ["ja", "nein", "entfällt", "Betreiber"] };

/// The questions that a cell such as `DATA-01, DATA-05 to DATA-09` names, with "to" or "bis".
fn questions_in(cell: &str) -> Vec<(String, usize)> {
    let question = |text: &str| {
        let (family, number) = text.trim().split_once('-')?;
        Some((family.to_owned(), number.parse::<usize>().ok()?))
    };
    let range = |part: &str| {
        let ends = part.split_once(" to ").or_else(|| part.split_once(" bis "));
        let (first, last) = ends.unwrap_or((part, part));
        let ((family, from), (_, to)) = (question(first)?, question(last)?);
        Some((from..=to).map(move |number| (family.clone(), number)))
    };
    cell.split(',').filter_map(range).flatten().collect()
}

/// The questions of an edition, as family and number, in the order of its rows, and the index of the answer to each.
fn hecvat_answers(edition: &Edition) -> Vec<((String, usize), usize)> {
    let page = std::fs::read_to_string(root().join("docs/adopt").join(edition.file)).expect("a page");
    let mut answers = Vec::new();
    for line in page.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let questions = questions_in(cells[1]);
        let answer = edition.answers.iter().position(|answer| *answer == cells[2]);
        assert!(answer.is_some() || questions.is_empty(), "{}: {}: {}", edition.file, cells[1], cells[2]);
        answers.extend(questions.into_iter().zip(std::iter::repeat(answer.unwrap_or_default())));
    }
    answers
}

#[test]
fn hecvat_page_answers_every_question_once() {
    assert_eq!(questions_in("A-01, B-02 to B-03").len(), 3);
    let mut answered = BTreeMap::new();
    for (question, _) in hecvat_answers(&ENGLISH) {
        *answered.entry(question).or_insert(0) += 1;
    }
    let asked: BTreeMap<(String, usize), i32> = QUESTIONS
        .iter()
        .flat_map(|(family, count)| (1..=*count).map(move |number| (((*family).to_owned(), number), 1)))
        .collect();
    assert_eq!(answered, asked);
}

#[test]
fn german_hecvat_page_gives_the_same_answers() {
    assert_eq!(questions_in("A-01, B-02 bis B-03"), questions_in("A-01, B-02 to B-03"));
    let [english, german] = [&ENGLISH, &GERMAN].map(hecvat_answers);
    let different: Vec<_> = english.iter().zip(&german).filter(|(english, german)| english != german).collect();
    assert!(different.is_empty(), "the editions differ in their questions or answers: {different:?}");
    assert_eq!(english.len(), german.len(), "each edition has as many questions");
}
