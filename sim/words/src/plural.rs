//! Which form of a sentence goes with a count: by the Unicode CLDR's rules for the language.

use anyhow::Context;
use icu_locale_core::Locale;
use icu_plurals::{PluralCategory, PluralRules};

/// Counts in which every category that a whole number can have occurs, in every language of the CLDR.
const SAMPLES: [u64; 2] = [201, 1_000_000];

/// The forms of a language's sentences, in the order in which its catalogue has them: the categories that whole numbers have,
/// from zero, one, two, few and many to other.
#[derive(Clone, Debug)]
pub(super) struct PluralForms {
    locale: Locale,
    categories: Vec<PluralCategory>,
}

impl PluralForms {
    /// The forms of a language by its code, as `de`; a catalogue has so many.
    ///
    /// # Errors
    /// When there is no such language, or the catalogue has another number of forms.
    pub(super) fn of_language(code: &str, count: usize) -> anyhow::Result<Self> {
        let locale: Locale = code.parse().with_context(|| format!("\"{code}\" is no language's code"))?;
        let rules = PluralRules::try_new_cardinal((&locale).into())?;
        let [whole, large] = SAMPLES;
        let is_taken = |category| (0..whole).chain([large]).any(|n| rules.category_for(n) == category);
        let categories: Vec<_> = rules.categories().filter(|category| is_taken(*category)).collect();
        anyhow::ensure!(
            categories.len() == count,
            "Plural-Forms: nplurals={count}; \"{code}\" has {}: {categories:?}",
            categories.len()
        );
        Ok(Self { locale, categories })
    }

    /// The place of the form that goes with a count.
    pub(super) fn find_form(&self, count: u64) -> Option<usize> {
        // The rules cannot be kept where several threads speak; they are looked up in the program's own data.
        let rules = PluralRules::try_new_cardinal((&self.locale).into()).ok()?;
        let category = rules.category_for(count);
        self.categories.iter().position(|has| *has == category)
    }
}

#[cfg(test)]
mod tests {
    //! Languages with one, two, three and six forms. Fails when a count gets another form than the language gives it.

    use super::*;

    fn forms(code: &str, number: usize, counts: &[u64]) -> Vec<usize> {
        let forms = PluralForms::of_language(code, number).unwrap();
        counts.iter().map(|n| forms.find_form(*n).unwrap()).collect()
    }

    #[test]
    fn known_languages_have_their_forms() {
        assert_eq!(forms("de", 2, &[0, 1, 2, 21]), [1, 0, 1, 1]);
        assert_eq!(forms("ja", 1, &[0, 1, 2]), [0, 0, 0]);
        assert_eq!(forms("pl", 3, &[1, 2, 5, 12, 22, 112, 122]), [0, 1, 2, 2, 1, 2, 1]);
        assert_eq!(forms("ar", 6, &[0, 1, 2, 3, 11, 100]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(forms("fr", 3, &[0, 1, 2, 1_000_000]), [0, 0, 2, 1]);
    }

    #[test]
    fn a_catalogue_with_another_number_of_forms_is_refused() {
        let refused = PluralForms::of_language("pl", 2).unwrap_err().to_string();
        assert!(refused.contains("nplurals=2") && refused.contains("has 3"), "{refused}");
        assert!(PluralForms::of_language("no language", 2).is_err());
    }
}
