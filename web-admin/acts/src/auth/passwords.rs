//! Password policy: long, and hard to guess. Common words, the person's own name, address and
//! school, alphabet and keyboard sequences, and digits in place of letters do not count; enough
//! other characters must remain.

use std::sync::LazyLock;

use model::auth::password_refused::PasswordRefused;
use model::limits::MIN_PASSWORD;
use model::search_key::compose_text;
use platform::secret;

/// Minimum number of characters that must remain after removing guessable parts.
const LEAST_LEFT: usize = 5;
/// Minimum length of a part of a name or an address to be removed, in characters.
const SHORTEST_PART: usize = 3;
/// Minimum length of a sequence to be removed, in characters.
const SHORTEST_RUN: usize = 4;

/// Words most often used in passwords, longest first.
static COMMON: LazyLock<Vec<String>> = LazyLock::new(|| longest_first(include_str!("passwords.txt").lines()));

/// Common passwords of ten or more characters, rejected even if their parts are not guessable: from
/// the 50 000 most common ones published by zxcvbn and Django. Each entry is the first six bytes of
/// the SHA-256 of the lower-cased password.
static CHOSEN: &[u8] = include_bytes!("passwords.bin");
/// Length of an entry, in bytes.
const CHOSEN_BYTES: usize = 6;

/// Neighbours in one of these rows form a sequence, in either direction.
const ROWS: [&str; 8] = [
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890",
    "qwertyuiop",
    "qwertzuiop",
    "asdfghjkl",
    "zxcvbnm",
    "yxcvbnm",
    "azertyuiop",
];

/// Checks a new password; `own` are the person's name, address and school.
///
/// # Errors
/// Fails if it is not acceptable.
pub fn check(password: &str, own: &[&str]) -> Result<(), PasswordRefused> {
    if password.chars().count() < MIN_PASSWORD {
        return Err(PasswordRefused::Short);
    }
    if is_often_chosen(password) {
        return Err(PasswordRefused::Common);
    }
    let own = longest_first(own.iter().flat_map(|text| text.split(|c: char| !c.is_alphanumeric())));
    // Trailing digits and signs are usually years and numbers, so they are not read as letters.
    let head = password.trim_end_matches(|c: char| !c.is_alphabetic());
    let tail = outside_runs(&plain(&password[head.len()..]));
    let least = |words: &[&[String]]| left(&plain(password), words).min(left(&unmasked(head), words) + tail);
    let weak = |words: &[&[String]]| least(words) < LEAST_LEFT;
    match (weak(&[&COMMON]), weak(&[&own, &COMMON])) {
        (true, _) => Err(PasswordRefused::Common),
        (false, true) => Err(PasswordRefused::Own),
        (false, false) => Ok(()),
    }
}

fn is_often_chosen(password: &str) -> bool {
    let hash = secret::token_sha256(&password.to_lowercase());
    CHOSEN.chunks_exact(CHOSEN_BYTES).any(|known| hash.starts_with(known))
}

/// Checks a new password that was entered twice.
///
/// # Errors
/// As [`check`], and if the two differ.
pub fn check_typed(password: &str, again: &str, own: &[&str]) -> Result<(), PasswordRefused> {
    check(password, own)?;
    if compose_text(password) == compose_text(again) { Ok(()) } else { Err(PasswordRefused::Different) }
}

fn longest_first<'a>(words: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut words: Vec<String> = words.map(plain).filter(|word| word.chars().count() >= SHORTEST_PART).collect();
    words.sort_by_key(|word| std::cmp::Reverse(word.chars().count()));
    words
}

/// Reduces a text to lower-case letters and digits, without the diacritics of Western keyboards.
fn plain(text: &str) -> String {
    let bare = |c| match c {
        'ä' | 'å' | 'à' | 'á' | 'â' | 'ã' => 'a',
        'ç' => 'c',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ñ' => 'n',
        'ö' | 'ò' | 'ó' | 'ô' | 'õ' | 'ø' => 'o',
        'ü' | 'ù' | 'ú' | 'û' => 'u',
        'ß' => 's',
        other => other,
    };
    text.chars().flat_map(char::to_lowercase).map(bare).filter(|c| c.is_alphanumeric()).collect()
}

/// Like [`plain`], with digits and signs read as the letters that they resemble.
fn unmasked(text: &str) -> String {
    let letter = |c| match c {
        '0' => 'o',
        '1' | '!' | '|' => 'i',
        '3' => 'e',
        '4' | '@' => 'a',
        '5' | '$' => 's',
        '7' => 't',
        other => other,
    };
    plain(&text.chars().map(letter).collect::<String>())
}

/// Counts the characters that remain without words and sequences.
fn left(text: &str, words: &[&[String]]) -> usize {
    let mut text = text.to_owned();
    for word in words.iter().copied().flatten() {
        // A separator, so that the parts around a removed word do not form a new one.
        text = text.replace(word.as_str(), "\0");
    }
    text.split('\0').map(outside_runs).sum()
}

fn outside_runs(text: &str) -> usize {
    let characters: Vec<char> = text.chars().collect();
    let runs = characters.chunk_by(|a, b| are_neighbours(*a, *b));
    runs.map(<[char]>::len).filter(|length| *length < SHORTEST_RUN).sum()
}

fn are_neighbours(a: char, b: char) -> bool {
    let (there, back) = (String::from_iter([a, b]), String::from_iter([b, a]));
    a == b || ROWS.iter().any(|row| row.contains(&there) || row.contains(&back))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_guessed_first_is_refused() {
        for guessed in [
            "password1234",
            "P@ssw0rd2024!",
            "Passwort123!",
            "qwertyuiop",
            "1234567890",
            "aaaaaaaaaaaa",
            "Sommer2026!!",
            "iloveyou123",
            "passwordpassword",
            "abcdefghijk",
            "Qwertz123456",
            "letmein2026",
            "Krankenhaus1",
            "welcome-2025",
            "stylet2026!",
            "1q2w3e4r5t",
            "Metallica1",
            "strawberry",
            "7894561230",
        ] {
            assert_eq!(check(guessed, &[]), Err(PasswordRefused::Common), "{guessed}");
        }
    }

    #[test]
    fn the_list_of_what_is_often_chosen_is_whole() {
        let known: Vec<_> = CHOSEN.chunks_exact(CHOSEN_BYTES).collect();
        assert!(known.len() > 2000 && CHOSEN.len() == known.len() * CHOSEN_BYTES && known.is_sorted());
    }

    #[test]
    fn ones_own_name_address_and_school_are_no_secret() {
        let own = ["Ana Ekström", "ana.ek@uni-north.example", "North Clinic"];
        for guessed in ["anaekstrom1", "Ekström-2026", "North+Clinic", "An4Ekström!!", "uni-north-2026"] {
            assert_eq!(check(guessed, &own), Err(PasswordRefused::Own), "{guessed}");
        }
        assert_eq!(check("Ekström-2026", &[]), Ok(()), "which is nothing to somebody else");
    }

    #[test]
    fn a_few_words_that_do_not_belong_together_are_fine() {
        for good in [
            "a long enough password",
            "another password",
            "correct horse",
            "Vier Käse im Wind",
            "k7#pX!2vQz",
            "x9f2k5m8w3",
        ] {
            assert_eq!(check(good, &["Ana Ek", "ana@example.org", "North"]), Ok(()), "{good}");
        }
        assert_eq!(check("käse Wind", &[]), Err(PasswordRefused::Short));
    }

    #[test]
    fn the_words_are_plain_and_none_comes_twice() {
        let mut words: Vec<&str> = include_str!("passwords.txt").lines().collect();
        assert!(
            words.len() > 150 && words.iter().all(|word| plain(word) == **word && word.len() >= SHORTEST_PART),
            "{words:?}"
        );
        words.sort_unstable();
        assert!(words.windows(2).all(|pair| pair[0] != pair[1]), "{words:?}");
    }
}
