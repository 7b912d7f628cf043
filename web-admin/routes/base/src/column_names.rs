//! Column names that are valid in statistical programs.

use std::collections::BTreeSet;

/// Maximum length of a name, in bytes: the limit of SPSS.
const LONGEST: usize = 64;
/// Bytes reserved for a number after a name.
const FOR_NUMBER: usize = 4;
/// Reserved words of SPSS.
const RESERVED: [&str; 13] = ["all", "and", "by", "eq", "ge", "gt", "le", "lt", "ne", "not", "or", "to", "with"];

/// Returns a name for each column that is valid in R and SPSS, unique regardless of case. A valid
/// name is kept, for the first of several equal ones; all others are changed, and numbered if the
/// name is taken.
#[must_use]
pub fn name_columns(wanted: &[String]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let kept: Vec<bool> =
        wanted.iter().map(|name| make_legal(name) == *name && taken.insert(name.to_ascii_lowercase())).collect();
    let named = wanted.iter().zip(kept).map(|(name, kept)| {
        if kept {
            return name.clone();
        }
        let legal = make_legal(name);
        let numbered = (2..).map(|number| format!("{}_{number}", shorten(&legal, LONGEST - FOR_NUMBER)));
        let free = std::iter::once(legal.clone()).chain(numbered).find(|name| taken.insert(name.to_ascii_lowercase()));
        free.unwrap_or(legal)
    });
    named.collect()
}

/// Returns a name of a letter, then letters, digits and underscores, that is not a reserved word of
/// SPSS.
fn make_legal(name: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let begins = safe.starts_with(|c: char| c.is_ascii_alphabetic());
    let reserved = RESERVED.contains(&safe.to_ascii_lowercase().as_str());
    let legal = if begins && !reserved { safe } else { format!("x_{safe}") };
    shorten(&legal, LONGEST).to_owned()
}

/// The name is ASCII, so it can be cut at any byte.
fn shorten(legal: &str, most: usize) -> &str {
    &legal[..legal.len().min(most)]
}

#[cfg(test)]
mod tests {
    //! Fails when SPSS would refuse a name, or two columns have the same name.

    use super::*;

    fn named(wanted: &[&str]) -> Vec<String> {
        name_columns(&wanted.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn a_name_that_is_legal_stays_and_the_others_make_way() {
        let wanted = [
            "role",
            "role",
            "a-b",
            "a_b",
            "a_b_2",
            "Q1",
            "q1",
            "1st",
            "with",
            "score_total",
            "",
            "größe",
            "m_peak_force_layer_n.skin",
        ];
        let expected = [
            "role",
            "role_2",
            "a_b_3",
            "a_b",
            "a_b_2",
            "Q1",
            "q1_2",
            "x_1st",
            "x_with",
            "score_total",
            "x_",
            "gr__e",
            "m_peak_force_layer_n_skin",
        ];
        assert_eq!(named(&wanted), expected);
        let long: Vec<usize> = named(&[&"a".repeat(70), &"A".repeat(70)]).iter().map(String::len).collect();
        assert_eq!(long, [64, 62]);
    }

    #[test]
    fn every_name_is_legal_and_its_own() {
        let long = "z".repeat(70);
        let some = ["a", "A", "a_2", "A-2", "1", "_", "With", "x_with", "größe", "", "b.", long.as_str()];
        for one in some {
            for two in some {
                for three in some {
                    let names = named(&[one, two, three, one]);
                    let folded: BTreeSet<String> = names.iter().map(|name| name.to_ascii_lowercase()).collect();
                    assert_eq!(folded.len(), 4, "{names:?}");
                    assert!(names.iter().all(|name| make_legal(name) == *name && name.len() <= LONGEST), "{names:?}");
                }
            }
        }
    }
}
