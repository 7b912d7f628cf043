//! Every statement of the storage, taken from its own source: each literal that is one, wherever it stands, and each that a macro puts
//! together. Fails when sqlx is given something that cannot be seen here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A statement, and the source that it stands in.
pub struct StoredStatement {
    /// As the engine is given it.
    pub sql: String,
    /// The source.
    pub place: PathBuf,
}

/// Which of two twins an engine is given, by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TwinPlace {
    /// SQLite.
    First,
    /// PostgreSQL.
    Second,
}

/// All of them that an engine is given, but for those of its own module, and of what moves rows between both.
pub fn stored_statements(of: TwinPlace) -> Vec<StoredStatement> {
    let read = |path: PathBuf| (chosen(&tokens(&std::fs::read_to_string(&path).unwrap()), of), path);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("store/src");
    let sources: Vec<_> = sources(&folder).into_iter().map(read).collect();
    let is_own = |place: &Path| ["engine", "operations/moving"].iter().any(|own| place.starts_with(folder.join(own)));
    let sources: Vec<_> = sources.into_iter().filter(|(_, place)| !is_own(place)).collect();
    let shared: BTreeMap<String, Pieces> = sources.iter().flat_map(|(tokens, _)| macros(tokens)).collect();
    let mut found = Vec::new();
    for (tokens, place) in &sources {
        // A file's own macro goes before another's of the same name.
        let macros: BTreeMap<String, Pieces> = shared.clone().into_iter().chain(macros(tokens)).collect();
        assert_eq!(unseen(tokens, &macros), Vec::<String>::new(), "{}", place.display());
        let statement = |sql| StoredStatement { sql, place: place.clone() };
        found.extend(statements(tokens, &macros).into_iter().map(statement));
    }
    found
}

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

/// A source where each pair of twins is one of them.
fn chosen(tokens: &[Token], of: TwinPlace) -> Vec<Token> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at].is("twin") && tokens.get(at + 1).is_some_and(|token| token.is_sign('!')) {
            let to = tokens[at..].iter().position(|token| token.is_sign(',')).expect("what the twins are for");
            let (first, second, end) = twins(tokens, at + to + 1);
            found.extend_from_slice(if of == TwinPlace::First { first } else { second });
            at = end;
        } else {
            found.push(tokens[at].clone());
            at += 1;
        }
    }
    found
}

/// The two twins of a pair, which begins at a place, and the place behind it.
fn twins(tokens: &[Token], begin: usize) -> (&[Token], &[Token], usize) {
    let (mut depth, mut comma) = (0, None);
    for (at, token) in tokens.iter().enumerate().skip(begin) {
        match token {
            Token::Sign('(') => depth += 1,
            Token::Sign(')') if depth == 0 => {
                let comma = comma.expect("two twins");
                let second = &tokens[comma + 1..at];
                return (&tokens[begin..comma], second.strip_suffix(&[Token::Sign(',')]).unwrap_or(second), at + 1);
            }
            Token::Sign(')') => depth -= 1,
            Token::Sign(',') if depth == 0 && comma.is_none() => comma = Some(at),
            _ => {}
        }
    }
    panic!("twins without an end");
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
    const VERBS: [&str; 5] = ["SELECT", "INSERT", "UPDATE", "DELETE", "WITH"];
    let begins = |text: &str| text.split_once(char::is_whitespace).is_some_and(|(verb, _)| VERBS.contains(&verb));
    let is_statement = |text: &&str| begins(text.trim_start());
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
        let binds = |token: &Token| ["let", "for", "const"].iter().any(|word| token.is(word));
        let bound = |name: &Token| tokens.windows(2).any(|pair| binds(&pair[0]) && pair[1] == *name);
        let seen = match &tokens[open + 1] {
            Token::Text(_) => true,
            word @ Token::Word(name) => (macros.contains_key(name) && tokens[open + 2].is_sign('!')) || bound(word),
            Token::Sign(_) => false,
        };
        found.extend((!seen).then(|| format!("{:?}", &tokens[at..(open + 4).min(tokens.len())])));
    }
    found
}

#[test]
fn the_check_sees_of_twins_the_one_that_is_meant() {
    let source =
        tokens(r#"f(twin!(to, m!("SELECT 1", ","), "SELECT 2",)); twin!(to, "SELECT 3", m!("SELECT 4", "x"))"#);
    let texts =
        |of| -> Vec<String> { chosen(&source, of).iter().filter_map(|t| t.text().map(str::to_owned)).collect() };
    assert_eq!(texts(TwinPlace::First), ["SELECT 1", ",", "SELECT 3"]);
    assert_eq!(texts(TwinPlace::Second), ["SELECT 2", "SELECT 4", "x"]);
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
