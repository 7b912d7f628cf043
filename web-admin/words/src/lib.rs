//! Words in the reader's language.
//!
//! An English sentence stands where it is said, in a template or in the code, and is its own key: `tr!("Sign out")`. The
//! catalogues in `web-admin/words/locales` hold it in other languages. Which one is spoken is a matter of the request (see
//! [`speaking`]); where nobody has settled it, as in the API, in logs and on the command line, it is English.

use std::fmt::Display;
use std::future::Future;

use phrase::Phrase;

tokio::task_local! {
    static SPOKEN: Language;
}

/// A sentence in the reader's language. Values stand in it by name: `tr!("{passed} of {all}", passed = 3, all = 5)`.
#[macro_export]
macro_rules! tr {
    ($sentence:literal) => {
        $crate::say($sentence)
    };
    ($sentence:literal, $($name:ident = $value:expr),+ $(,)?) => {
        $crate::fill(
            $crate::say($sentence),
            &[$((stringify!($name), &$value as &dyn std::fmt::Display)),+],
        )
    };
}

/// A sentence that changes with a count, which stands in it as `{n}`: `trn!("{n} attempt", "{n} attempts", count)`.
#[macro_export]
macro_rules! trn {
    ($one:literal, $many:literal, $count:expr $(, $name:ident = $value:expr)* $(,)?) => {{
        let count = $count;
        $crate::fill(
            $crate::say_counted($one, $many, count),
            &[("n", &count as &dyn std::fmt::Display) $(, (stringify!($name), &$value as &dyn std::fmt::Display))*],
        )
    }};
}

/// Marks a sentence that is said later, by [`say`], for the catalogues: a constant, or a word that is also data.
#[macro_export]
macro_rules! sentence {
    ($sentence:literal) => {
        $sentence
    };
}

mod catalogue;
pub mod dates;
mod language;
mod plural;

pub use language::{Language, own_name};
pub use phrase::fill;

/// The language that is spoken here: English where nobody has settled it.
#[must_use]
pub fn current() -> Language {
    SPOKEN.try_with(|language| *language).unwrap_or(Language::ENGLISH)
}

/// Speaks a language for as long as a future runs.
pub async fn speaking<F: Future>(language: Language, future: F) -> F::Output {
    SPOKEN.scope(language, future).await
}

/// Speaks a language for one call.
pub fn within<T>(language: Language, call: impl FnOnce() -> T) -> T {
    SPOKEN.sync_scope(language, call)
}

/// A sentence in the language that is spoken here; as it is where the language has it not.
#[must_use]
pub fn say(sentence: &'static str) -> &'static str {
    let language = current();
    if language == Language::PSEUDO {
        return bracketed(sentence);
    }
    catalogue::find(language).and_then(|catalogue| catalogue.say(sentence)).unwrap_or(sentence)
}

/// A word that is data as well, as the label of a metric: in the language that is spoken here, where it has it.
#[must_use]
pub fn known(word: &str) -> String {
    let language = current();
    if language == Language::PSEUDO {
        return bracketed(word).to_owned();
    }
    catalogue::find(language).and_then(|catalogue| catalogue.say(word)).unwrap_or(word).to_owned()
}

/// A sentence in the form that goes with a count. A negative count has none: it goes with many, in English.
#[must_use]
pub fn say_counted(one: &'static str, many: &'static str, count: impl TryInto<u64>) -> &'static str {
    let count = count.try_into().ok();
    let english = if count == Some(1) { one } else { many };
    let language = current();
    if language == Language::PSEUDO {
        return bracketed(english);
    }
    catalogue::find(language)
        .zip(count)
        .and_then(|(catalogue, count)| catalogue.say_counted(one, count))
        .unwrap_or(english)
}

/// A number that was written with a full stop, as the reader's language writes it, with a true minus sign.
#[must_use]
pub fn decimal(number: &str) -> String {
    // The catalogue of a language tells its sign by this number.
    let sign = tr!("0.0").trim_matches(|c: char| !matches!(c, '.' | ','));
    number.replace('.', sign).replace('-', "−")
}

/// A phrase of the simulator's, in the language that is spoken here.
#[must_use]
pub fn phrase(phrase: &Phrase) -> String {
    match phrase {
        Phrase::Data(data) => data.clone(),
        Phrase::Number(number) => decimal(number),
        Phrase::Sentence { words, values } => {
            let said: Vec<_> = values.iter().map(|(name, value)| (*name, self::phrase(value))).collect();
            let values: Vec<(&str, &dyn Display)> = said.iter().map(|(name, value)| (*name, value as _)).collect();
            fill(say(words), &values)
        }
    }
}

/// For tests that look for what was forgotten: everything said is in brackets.
fn bracketed(sentence: &str) -> &'static str {
    Box::leak(format!("⟦{sentence}⟧").into_boxed_str())
}

/// Reads every catalogue.
///
/// # Errors
/// When one is broken.
pub fn check() -> anyhow::Result<()> {
    catalogue::check()
}

#[cfg(test)]
mod tests {
    //! What is said must hold its values, in the form that goes with the count, and fall back to English rather than to
    //! nothing.

    use super::*;

    fn german<T>(call: impl FnOnce() -> T) -> T {
        within(Language::named("de").expect("German"), call)
    }

    #[test]
    fn the_count_chooses_the_form() {
        let attempts = |n: u32| trn!("{n} attempt", "{n} attempts", n);
        assert_eq!([attempts(0), attempts(1), attempts(2)], ["0 attempts", "1 attempt", "2 attempts"]);
        assert_eq!(german(|| [attempts(0), attempts(1), attempts(2)]), ["0 Versuche", "1 Versuch", "2 Versuche"]);
    }

    #[test]
    fn what_a_language_lacks_is_said_in_english() {
        assert_eq!(german(|| say("no such sentence")), "no such sentence");
        assert_eq!(german(|| known("a layer of my own")), "a layer of my own");
        assert_eq!([say("Sign out"), german(|| say("Sign out"))], ["Sign out", "Abmelden"]);
    }

    #[test]
    fn a_phrase_is_said_with_its_values() {
        let phrase = phrase::phrase!("allowed: at most {most} bytes", most = Phrase::number(1.5, 1));
        assert_eq!(german(|| self::phrase(&phrase)), "erlaubt: höchstens 1,5 Bytes");
        assert_eq!(self::phrase(&phrase), phrase.to_string());
    }

    #[tokio::test]
    async fn a_language_is_spoken_for_as_long_as_its_future_runs() {
        let german = Language::named("de").expect("German");
        assert_eq!(speaking(german, async { current() }).await, german);
        assert_eq!(current(), Language::ENGLISH);
    }
}
