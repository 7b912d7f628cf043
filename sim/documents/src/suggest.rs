//! Finds the known key nearest to an unknown one, so that the error for a wrong unit or a typo
//! suggests the right key.

use crate::describe::{DescribedField, DescribedTable};

/// Returns the field whose key is nearest to `key`: similar in spelling, or with the same first
/// word (`thickness_m`).
pub(crate) fn find_nearest_key<'t>(key: &str, table: &'t DescribedTable) -> Option<&'t DescribedField> {
    let distance = |f: &&DescribedField| (first_word(f.key) != first_word(key), edit_distance(f.key, key));
    let field = table.fields.iter().min_by_key(distance)?;
    let (other_word, edits) = distance(&field);
    (!other_word || edits <= 1 + key.len() / 4).then_some(field)
}

fn first_word(key: &str) -> &str {
    key.split('_').next().unwrap_or(key)
}

/// Returns the Levenshtein distance, in characters.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    //! A wrong unit must not suggest another quantity's key, and an unrelated key must not suggest
    //! any.

    use super::{edit_distance, find_nearest_key};
    use crate::describe::{DescribedTable, FieldKind, SCENE};

    fn layer() -> &'static DescribedTable {
        match SCENE.fields.iter().find(|f| f.key == "layer").map(|f| f.kind) {
            Some(FieldKind::Tables { table, .. }) => table,
            _ => panic!("a scene has layers"),
        }
    }

    #[test]
    fn a_slip_of_a_unit_names_the_key_with_the_right_one() {
        for (wrong, right) in [
            ("thickness_m", "thickness_mm"),
            ("thickness", "thickness_mm"),
            ("stiffness_n_per_mm", "stiffness_n_per_m"),
            ("density_g_per_cm3", "density_kg_per_m3"),
            ("youngs_modulus_kpa", "youngs_modulus_pa"),
            ("friction_n", "friction_n_per_m"),
            ("tip_ruptur_n", "tip_rupture_n"),
            ("nmae", "name"),
        ] {
            assert_eq!(find_nearest_key(wrong, layer()).map(|f| f.key), Some(right), "{wrong}");
        }
    }

    #[test]
    fn a_stranger_gets_no_suggestion() {
        assert!(find_nearest_key("viscosity_model", layer()).is_none());
    }

    #[test]
    fn edits_are_counted_in_characters() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("µm", "mm"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
