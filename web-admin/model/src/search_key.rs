//! Normalization of names for search: without diacritics and case, and with umlauts spelled out.
//! "grosser" and "groesser" both find "Größer".

use unicode_normalization::UnicodeNormalization;
use unicode_normalization::char::is_combining_mark;

/// Maximum number of words in a search; further words are ignored.
const MOST_WORDS: usize = 8;

/// Folds a text: converts compatibility forms, removes diacritics and case, and replaces letters
/// with a stroke or ligature, such as "ø" and "æ", by plain letters.
#[must_use]
pub fn fold_text(text: &str) -> String {
    let bare = text.nfkd().filter(|letter| !is_combining_mark(*letter));
    bare.flat_map(char::to_lowercase).fold(String::with_capacity(text.len()), |mut folded, letter| {
        match plain_letters(letter) {
            Some(plain) => folded.push_str(plain),
            None => folded.push(letter),
        }
        folded
    })
}

/// Returns a text with its letters composed, because keyboards differ in whether they send "ä" as
/// one character or as two.
#[must_use]
pub fn compose_text(text: &str) -> String {
    text.nfc().collect()
}

/// Returns a key that is equal for names that look alike: it ignores case, width, spaces and the
/// composition of letters, but not diacritics.
#[must_use]
pub fn look_alike_key(text: &str) -> String {
    let folded: String = text.nfkc().flat_map(char::to_lowercase).nfkc().collect();
    folded.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the sort key for lists by family name: the last word of the name, then the rest. A
/// degree after a comma is ignored.
#[must_use]
pub fn family_sort_key(name: &str) -> String {
    let bare = name.split(',').next().unwrap_or_default().trim();
    let (given, family) = bare.rsplit_once(char::is_whitespace).unwrap_or(("", bare));
    fold_text(&format!("{family} {given}"))
}

const fn plain_letters(letter: char) -> Option<&'static str> {
    Some(match letter {
        'ß' => "ss",
        'æ' => "ae",
        'œ' => "oe",
        'ø' => "o",
        'ł' => "l",
        'đ' | 'ð' => "d",
        'þ' => "th",
        'ı' => "i",
        _ => return None,
    })
}

/// Spells out umlauts as usual without the letters on the keyboard, then folds the text.
fn spell_out(text: &str) -> String {
    let composed = text.nfc().flat_map(char::to_lowercase);
    let spelt = composed.fold(String::with_capacity(text.len()), |mut spelt, letter| {
        match letter {
            'ä' => spelt.push_str("ae"),
            'ö' | 'ø' => spelt.push_str("oe"),
            'ü' => spelt.push_str("ue"),
            'å' => spelt.push_str("aa"),
            _ => spelt.push(letter),
        }
        spelt
    });
    fold_text(&spelt)
}

/// Returns the search text of a person: name in both spellings, email address and registration
/// number.
#[must_use]
pub fn make_search_text(name: &str, email: &str, registrar_id: Option<&str>) -> String {
    let (folded, spelt) = (fold_text(name), spell_out(name));
    let spelt = Some(spelt).filter(|spelt| *spelt != folded);
    let parts = [Some(folded), spelt, Some(fold_text(email)), registrar_id.map(fold_text)];
    parts.into_iter().flatten().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Returns the words of a search, all of which must be found.
#[must_use]
pub fn split_search_words(typed: &str) -> Vec<String> {
    fold_text(typed).split_whitespace().take(MOST_WORDS).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    //! Checks that people are found with the letters available on other keyboards.

    use proptest::prelude::*;

    use super::*;

    fn finds(typed: &str, name: &str) -> bool {
        let text = make_search_text(name, "x@example.org", Some("0047-B"));
        split_search_words(typed).iter().all(|word| text.contains(word.as_str()))
    }

    #[test]
    fn names_are_found_by_plain_letters_and_by_their_own() {
        let found = [
            ("grosser", "Jörg Größer"),
            ("GROESSER joerg", "Jörg Größer"),
            ("größer", "Jörg Größer"),
            ("gro\u{308}ßer", "Jörg Größer"),
            ("sorensen", "Åse Sørensen"),
            ("aase soerensen", "Åse Sørensen"),
            ("lukasz", "Łukasz Wróbel"),
            ("dang", "Đặng Thu"),
            ("istanbul", "İstanbul"),
            ("0047-b", "Anyone"),
            ("example.org", "Anyone"),
            ("", "Anyone"),
        ];
        for (typed, name) in found {
            assert!(finds(typed, name), "{typed} finds {name}: {}", make_search_text(name, "", None));
        }
        assert!(!finds("grosser anna", "Jörg Größer"), "every word is asked for");
    }

    #[test]
    fn a_list_of_names_is_sorted_by_family() {
        let mut names =
            ["Ada Okafor", "Bruno Keller", "Jörg von der Aue", "Zoe Öztürk", "Cher", "Ana Berg, MD", "Ada Berg"];
        names.sort_by_key(|name| family_sort_key(name));
        assert_eq!(
            names,
            ["Jörg von der Aue", "Ada Berg", "Ana Berg, MD", "Cher", "Bruno Keller", "Ada Okafor", "Zoe Öztürk"]
        );
    }

    #[test]
    fn names_that_look_alike_have_one_key() {
        for other in ["GRUPPE ä", "Gruppe a\u{308}", " Gruppe\u{a0}\u{2003}Ä", "Ｇruppe Ä"] {
            assert_eq!(look_alike_key(other), look_alike_key("Gruppe Ä"), "{other:?}");
        }
        assert_ne!(look_alike_key("Gruppe A"), look_alike_key("Gruppe Ä"));
    }

    #[test]
    fn what_is_sorted_by_stands_where_a_reader_looks() {
        let mut names = ["Zoe", "Ärmel", "anna", "Öztürk", "Otto"];
        names.sort_by_key(|name| fold_text(name));
        assert_eq!(names, ["anna", "Ärmel", "Otto", "Öztürk", "Zoe"]);
    }

    proptest! {
        #[test]
        fn folding_once_is_folding(text in "\\PC{0,40}") {
            let folded = fold_text(&text);
            prop_assert_eq!(fold_text(&folded), folded);
        }

        #[test]
        fn everybody_is_found_by_their_own_name(name in "[\\p{L} ]{1,30}") {
            prop_assert!(finds(&name, &name));
        }
    }
}
