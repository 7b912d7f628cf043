//! Ids of documents out of their titles.

/// Longest id that a title gives, in characters: there is room for a number behind it.
const LONGEST: usize = 60;

/// An id out of a title: its words in lower case, joined by hyphens, letters without their marks. Empty where the title has neither
/// letters nor digits that an id may have.
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

/// What stands inside a word and is left out of an id.
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
    //! Fails when a title gives an id that documents refuse, or two words run into one.

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
