//! No query reads a table of many rows from end to end, nor all that a school has in one. Every statement is taken from the storage's own source: each literal that is
//! one, wherever it stands, and each that a macro puts together; SQLite is asked how it would run it. Fails when a query
//! loses its index, when a new one never had any, when a statement can no longer be planned, and when sqlx is given something
//! that this test cannot see.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::support::App;

/// Tables that grow with attempts, people, cohorts or acts. Unfinished uploads do not: they expire.
const BIG: [&str; 22] = [
    "notices",
    "assignment_extensions",
    "segment_extensions",
    "study_participants",
    "survey_letters",
    "sessions",
    "scores",
    "regrading_lines",
    "grades",
    "metrics",
    "session_curves",
    "comments",
    "reviews",
    "supervisions",
    "ratings",
    "survey_responses",
    "practice",
    "tallies",
    "people",
    "cohorts",
    "cohort_members",
    "audit_log",
];

/// Tables of which a school's part is listed, but that nobody reads from end to end.
const LISTED: [&str; 2] = ["assignments", "segment_tasks"];

/// What may read everything: beginnings of statements, each with the reason.
const WHOLE: [(&str, &str); 21] = [
    ("WITH RECURSIVE", "the generator of invented practice"),
    ("INSERT INTO tallies", "sums a school up anew, after the generator"),
    ("DELETE FROM tallies", "the same"),
    ("INSERT INTO scores (id, school_id, session_id, score", "the generator of invented practice"),
    ("SELECT (SELECT count(*) FROM people WHERE role", "/metrics: short rows, rarely asked"),
    ("SELECT id, recording_path, recording_sha256", "verify and backup read every recording"),
    ("SELECT seq, at, school_id, actor", "verify and serve walk the whole audit log"),
    ("SELECT count(*) > 0 FROM audit_log WHERE hash", "verify --expect-head, which has walked the whole log"),
    ("SELECT g.session_id FROM grades g JOIN scores c", "verify holds every grade against its score"),
    ("SELECT session_id, score FROM scores ORDER BY rowid", "the same"),
    ("SELECT object, CASE action WHEN 'session.scored'", "verify holds every score against the audit log"),
    ("SELECT id, name FROM cohorts", "the cohorts to choose from, all of them"),
    ("SELECT c.id, c.name FROM cohorts c WHERE", "the cohorts that somebody sees, for an administrator all of them"),
    ("SELECT count(*) FROM people", "greets an empty service, once at its start"),
    ("SELECT c.session_id, c.body FROM comments", "an administrator looks for a name before erasing whose it is"),
    ("WITH everybody AS", "once a day, and when somebody asks: whom a school keeps no longer"),
    ("DELETE FROM uploads WHERE session_id IS NULL", "in the copy that a backup is made of"),
    (
        "SELECT id, display_name, email, registrar_id FROM people WHERE sort_name",
        "at a start: an index that is empty but after an update",
    ),
    ("SELECT coalesce(sum(iif(p.role = 'guest'", "a school is written for research: its guests and staff, by command"),
    (
        "SELECT u.title AS survey, l.name, l.email, l.sent_at",
        "somebody’s own data, by an address in any case of letters",
    ),
    ("SELECT seq, hash FROM audit_log ORDER BY seq DESC", "reads one row from the end of the primary key"),
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// What a source is made of, as far as statements go.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Text(String),
    Word(String),
    Sign(char),
}

impl Token {
    fn is(&self, word: &str) -> bool {
        matches!(self, Self::Word(found) if found == word)
    }

    const fn is_sign(&self, sign: char) -> bool {
        matches!(self, Self::Sign(found) if *found == sign)
    }

    fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }
}

/// The tokens of a source, without its comments.
fn tokens(mut source: &str) -> Vec<Token> {
    let mut found = Vec::new();
    while let Some(first) = source.chars().next() {
        let (token, rest) = if source.starts_with("//") {
            (None, source.split_once('\n').map_or("", |(_, rest)| rest))
        } else if let Some(raw) = source.strip_prefix("r#\"") {
            let (text, rest) = raw.split_once("\"#").unwrap();
            (Some(Token::Text(text.to_owned())), rest)
        } else if first == '"' {
            let (text, rest) = literal(&source[1..]);
            (Some(Token::Text(text)), rest)
        } else if let Some(rest) = character(source) {
            (None, rest)
        } else if first.is_alphanumeric() || first == '_' {
            let end = source.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(source.len());
            (Some(Token::Word(source[..end].to_owned())), &source[end..])
        } else {
            (Some(Token::Sign(first)).filter(|_| !first.is_whitespace()), &source[first.len_utf8()..])
        };
        found.extend(token);
        source = rest;
    }
    found
}

/// A literal after its first quote, its escapes resolved, and what follows it.
fn literal(source: &str) -> (String, &str) {
    let (mut text, mut characters) = (String::new(), source.char_indices());
    while let Some((at, c)) = characters.next() {
        match c {
            '"' => return (text, &source[at + 1..]),
            '\\' => match characters.next() {
                Some((_, 'n' | '\n')) => text.push(' '),
                Some((_, escaped)) => text.push(escaped),
                None => break,
            },
            c => text.push(c),
        }
    }
    panic!("a literal without an end: {text}");
}

/// What follows a character in single quotes, where one begins here; a lifetime is none.
fn character(source: &str) -> Option<&str> {
    let mut rest = source.strip_prefix('\'')?.chars();
    if rest.next()? == '\\' {
        rest.next()?;
    }
    rest.as_str().strip_prefix('\'')
}

/// What a macro puts together: literals, and its arguments by their places.
type Pieces = Vec<Result<String, usize>>;

/// Macros that put literals together, by name.
fn macros(tokens: &[Token]) -> BTreeMap<String, Pieces> {
    let mut found = BTreeMap::new();
    for (at, _) in tokens.iter().enumerate().filter(|(_, token)| token.is("macro_rules")) {
        let Token::Word(name) = &tokens[at + 2] else { continue };
        let body = &tokens[at..];
        let concat = body.iter().position(|token| token.is("concat")).unwrap();
        let named = |tokens: &[Token]| -> Vec<Token> {
            tokens.windows(2).filter(|pair| pair[0].is_sign('$')).map(|pair| pair[1].clone()).collect()
        };
        let arguments = named(&body[..concat]);
        let end = concat + body[concat..].iter().position(|token| token.is_sign(')')).unwrap();
        let piece = |token: &Token| match token {
            Token::Text(text) => Some(Ok(text.clone())),
            word => arguments.iter().position(|argument| argument == word).map(Err),
        };
        found.insert(name.clone(), body[concat..end].iter().filter_map(piece).collect());
    }
    found
}

/// Every statement of a source, put together where a macro does it.
fn statements(tokens: &[Token], macros: &BTreeMap<String, Pieces>) -> Vec<String> {
    const VERBS: [&str; 5] = ["SELECT ", "INSERT ", "UPDATE ", "DELETE ", "WITH "];
    let is_statement = |text: &&str| VERBS.iter().any(|verb| text.trim_start().starts_with(verb));
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at].is("macro_rules") {
            at += tokens[at..].iter().position(|token| token.is_sign(')')).unwrap();
            at += tokens[at..].iter().position(|token| token.is("concat")).unwrap();
            at += tokens[at..].iter().position(|token| token.is_sign(')')).unwrap();
        } else if let Token::Word(name) = &tokens[at]
            && let Some(pieces) = macros.get(name).filter(|_| tokens[at + 1].is_sign('!'))
        {
            let end = at + tokens[at..].iter().position(|token| token.is_sign(')')).unwrap();
            let arguments: Vec<&str> = tokens[at..end].iter().filter_map(Token::text).collect();
            let piece = |piece: &Result<String, usize>| piece.clone().unwrap_or_else(|at| arguments[at].to_owned());
            found.push(pieces.iter().map(piece).collect());
            at = end;
        } else {
            found.extend(tokens[at].text().filter(is_statement).map(str::to_owned));
        }
        at += 1;
    }
    found
}

/// What sqlx is given and this test cannot see: neither a literal, nor a macro that is known, nor a name that the file gives to one.
fn unseen(tokens: &[Token], macros: &BTreeMap<String, Pieces>) -> Vec<String> {
    let is_query = |token: &Token| ["query", "query_as", "query_scalar", "raw_sql"].iter().any(|name| token.is(name));
    let mut found = Vec::new();
    for (at, _) in
        tokens.iter().enumerate().filter(|(at, token)| is_query(token) && *at > 2 && tokens[at - 3].is("sqlx"))
    {
        let mut depth = 0;
        // The call's own parenthesis, not one among its types.
        let opens = |token: &Token| {
            depth += i32::from(token.is_sign('<')) - i32::from(token.is_sign('>'));
            depth == 0 && token.is_sign('(')
        };
        let open = at + tokens[at..].iter().position(opens).unwrap();
        let bound =
            |name: &Token| tokens.windows(2).any(|pair| (pair[0].is("let") || pair[0].is("for")) && pair[1] == *name);
        let seen = match &tokens[open + 1] {
            Token::Text(_) => true,
            word @ Token::Word(name) => (macros.contains_key(name) && tokens[open + 2].is_sign('!')) || bound(word),
            Token::Sign(_) => false,
        };
        found.extend((!seen).then(|| format!("{:?}", &tokens[at..(open + 4).min(tokens.len())])));
    }
    found
}

/// Lines of a plan that read a big table from end to end, or all of it that is a school's, also under another name. What an index of
/// few rows holds may be read whole.
fn scans(sql: &str, plan: &[String], few: &[String]) -> Vec<String> {
    let words: Vec<&str> =
        sql.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
    let is_of = |tables: &[&str], name: &str| {
        tables.contains(&name) || words.windows(2).any(|w| w[1] == name && tables.contains(&w[0]))
    };
    let of_school =
        |line: &str| line.ends_with("(school_id=?)") && !line.split(' ').any(|word| few.iter().any(|f| f == word));
    let slow = |line: &&String| {
        let name = line.split(' ').nth(1).unwrap_or_default();
        let (scanned, big) = (line.starts_with("SCAN "), is_of(&BIG, name));
        (scanned && (big || is_of(&LISTED, name))) || (big && of_school(line))
    };
    plan.iter().filter(slow).cloned().collect()
}

#[tokio::test]
async fn every_query_of_a_big_table_uses_an_index() {
    let app = App::new().await;
    let read = |path: PathBuf| (tokens(&std::fs::read_to_string(&path).unwrap()), path);
    let sources: Vec<_> =
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("store/src")).into_iter().map(read).collect();
    let shared: BTreeMap<String, Pieces> = sources.iter().flat_map(|(tokens, _)| macros(tokens)).collect();
    let few: Vec<String> =
        sqlx::query_scalar("SELECT name FROM sqlite_master WHERE type = 'index' AND sql LIKE '%WHERE%'")
            .fetch_all(app.state.db.reader())
            .await
            .unwrap();
    let (mut planned, mut slow) = (0, Vec::new());
    for (tokens, path) in &sources {
        // A file's own macro goes before another's of the same name.
        let macros: BTreeMap<String, Pieces> = shared.clone().into_iter().chain(macros(tokens)).collect();
        assert_eq!(unseen(tokens, &macros), Vec::<String>::new(), "{}", path.display());
        for sql in statements(tokens, &macros) {
            let plan: Vec<(i64, i64, i64, String)> =
                sqlx::query_as(sqlx::AssertSqlSafe(format!("EXPLAIN QUERY PLAN {sql}")))
                    .fetch_all(app.state.db.reader())
                    .await
                    .unwrap_or_else(|error| panic!("{}: {error}: {sql}", path.display()));
            let lines: Vec<String> = plan.into_iter().map(|(.., line)| line).collect();
            planned += 1;
            // What a new row has to do with others is looked for only while a foreign key is broken.
            let added = sql.starts_with("INSERT INTO") && !sql.contains("SELECT");
            let allowed = added || WHOLE.iter().any(|(start, _)| sql.starts_with(start));
            slow.extend(
                scans(&sql, &lines, &few).into_iter().filter(|_| !allowed).map(|line| format!("{line} in: {sql}")),
            );
        }
    }
    assert!(planned > 250, "only {planned} statements found");
    assert!(slow.is_empty(), "{} queries read a whole table:\n{}", slow.len(), slow.join("\n"));
}

#[test]
fn the_check_sees_macros_names_and_what_it_cannot_see() {
    let source = r##"
        macro_rules! m { ($a:literal, $b:literal) => { concat!("SELECT 1 ", $b, " WHERE ", $a) }; }
        // sqlx::query("SELECT 0")
        fn f<'a>(c: char) { let s = if c == '"' { "DELETE FROM \"x\"" } else { r#"UPDATE "y""# };
            sqlx::query(s); sqlx::query_as::<_, (i64,)>(m!("p", "q")); sqlx::query(given); sqlx::query(&format!("SELECT 2")); }
    "##;
    let tokens = tokens(source);
    let macros = macros(&tokens);
    let found = statements(&tokens, &macros);
    assert_eq!(found, ["DELETE FROM \"x\"", "UPDATE \"y\"", "SELECT 1 q WHERE p", "SELECT 2"]);
    assert_eq!(unseen(&tokens, &macros).len(), 2, "a name from elsewhere, and one that is made at run time");
}

#[test]
fn the_check_sees_a_scan_under_another_name() {
    let plan = ["SCAN s", "SEARCH c USING INDEX x (school_id=? AND id=?)", "SCAN schools"].map(str::to_owned);
    assert_eq!(scans("SELECT 1 FROM sessions s JOIN schools", &plan, &[]), ["SCAN s"]);
    assert_eq!(scans("SELECT 1 FROM schools s", &plan, &[]), Vec::<String>::new());
    let plan = ["SEARCH s USING INDEX all (school_id=?)", "SEARCH s USING INDEX few (school_id=?)"].map(str::to_owned);
    assert_eq!(scans("SELECT 1 FROM sessions s", &plan, &["few".to_owned()]), [plan[0].clone()]);
}
