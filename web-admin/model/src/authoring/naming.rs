//! Document ids derived from titles.

/// Maximum length of an id derived from a title, in characters; a number can be appended to it.
const LONGEST: usize = 60;

/// Returns an id derived from a title: words in lower case, joined by hyphens, without diacritics.
/// Empty if the title contains no letters or digits permitted in ids.
#[must_use]
pub fn id_from_title(title: &str) -> String {
    let mut id = String::new();
    for c in title.chars().flat_map(char::to_lowercase) {
        match plain_letters(c) {
            "" if c.is_ascii_lowercase() || c.is_ascii_digit() => id.push(c),
            "" if !id.ends_with('-') && !id.is_empty() && !is_mark(c) => id.push('-'),
            letters => id.push_str(letters),
        }
        if id.len() >= LONGEST {
            break;
        }
    }
    id.truncate(LONGEST);
    id.trim_end_matches('-').to_owned()
}

/// Returns whether a character within a word is omitted from the id.
const fn is_mark(c: char) -> bool {
    matches!(c, '\'' | '’' | '\u{300}'..='\u{36f}')
}

const fn plain_letters(c: char) -> &'static str {
    match c {
        'ä' | 'æ' => "ae",
        'ö' | 'œ' => "oe",
        'ø' | 'ó' | 'ò' | 'ô' | 'õ' => "o",
        'ü' => "ue",
        'ß' => "ss",
        'á' | 'à' | 'â' | 'ã' | 'å' | 'ą' => "a",
        'é' | 'è' | 'ê' | 'ë' | 'ě' | 'ę' => "e",
        'í' | 'ì' | 'î' | 'ï' => "i",
        'ú' | 'ù' | 'û' | 'ů' => "u",
        'ý' | 'ÿ' => "y",
        'ç' | 'č' | 'ć' => "c",
        'ñ' | 'ň' | 'ń' => "n",
        'š' | 'ś' => "s",
        'ž' | 'ź' | 'ż' => "z",
        'ř' => "r",
        'ł' => "l",
        'ď' => "d",
        'ť' => "t",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    //! Checks that the ids are valid and that words stay separate.

    use super::*;

    #[test]
    fn a_title_gives_a_readable_id() {
        for (title, id) in [
            ("Stop in the fat", "stop-in-the-fat"),
            ("  Größer: 2 × 20 mm!  ", "groesser-2-20-mm"),
            ("Don’t push", "dont-push"),
            ("Épidurale à l’aveugle", "epidurale-a-laveugle"),
            ("针", ""),
            ("--", ""),
        ] {
            assert_eq!(id_from_title(title), id, "{title}");
        }
        assert!(id_from_title(&"ä".repeat(99)).len() <= LONGEST);
    }
}
