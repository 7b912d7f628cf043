//! Translations of the user interface.
//!
//! English sentences in templates and code are their own keys: `tr!("Sign out")`. The catalogues in
//! `sim/words/locales` contain the translations, for the service and for the simulator's window.
//! The language is set for each request (see [`speaking`]) or for the user of the window (see
//! [`within`]); if it is not set, as in the API, in logs and on the command line, it is English.

use std::cell::Cell;
use std::fmt::Display;
use std::future::{Future, poll_fn};
use std::pin::pin;

use phrase::Phrase;

thread_local! {
    static SPOKEN: Cell<Option<Language>> = const { Cell::new(None) };
}

/// Translates a sentence. Values are inserted by name: `tr!("{passed} of {all}", passed = 3, all =
/// 5)`.
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

/// Translates a sentence with a count, which is inserted at `{n}`: `trn!("{n} attempt", "{n}
/// attempts", count)`.
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

mod catalogue;
pub mod dates;
mod language;
mod plural;

pub use language::{Language, own_name};
pub use phrase::{fill, sentence};

/// Returns the current language; English if none is set.
#[must_use]
pub fn current() -> Language {
    SPOKEN.get().unwrap_or(Language::ENGLISH)
}

/// Sets the language while a future runs, on any thread.
pub async fn speaking<F: Future>(language: Language, future: F) -> F::Output {
    let mut future = pin!(future);
    poll_fn(|context| within(language, || future.as_mut().poll(context))).await
}

/// Sets the language for one call.
pub fn within<T>(language: Language, call: impl FnOnce() -> T) -> T {
    let _before = SpokenBefore(SPOKEN.replace(Some(language)));
    call()
}

/// The previous language, restored when the call returns or panics.
struct SpokenBefore(Option<Language>);

impl Drop for SpokenBefore {
    fn drop(&mut self) {
        SPOKEN.set(self.0);
    }
}

/// Translates a sentence into the current language; falls back to English.
#[must_use]
pub fn say(sentence: &'static str) -> &'static str {
    let language = current();
    if language == Language::PSEUDO {
        return bracketed(sentence);
    }
    catalogue::find(language).and_then(|catalogue| catalogue.say(sentence)).unwrap_or(sentence)
}

/// Translates a word that is also data, such as the label of a metric, into the current language;
/// falls back to the word itself.
#[must_use]
pub fn known(word: &str) -> String {
    let language = current();
    if language == Language::PSEUDO {
        return bracketed(word).to_owned();
    }
    catalogue::find(language).and_then(|catalogue| catalogue.say(word)).unwrap_or(word).to_owned()
}

/// Returns the plural form of a sentence for a count. A negative count has none: it uses the
/// English plural.
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

/// Localises a number written with a decimal point: decimal separator and a true minus sign.
#[must_use]
pub fn decimal(number: &str) -> String {
    // A language's translation of this number defines its decimal separator.
    let sign = tr!("0.0").trim_matches(|c: char| !matches!(c, '.' | ','));
    number.replace('.', sign).replace('-', "−")
}

/// Formats a localised number with `decimals` decimal places; a zero has no sign.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    decimal(if is_zero { text.trim_start_matches('-') } else { &text })
}

/// Translates a phrase into the current language.
#[must_use]
pub fn phrase(phrase: &Phrase) -> String {
    match phrase {
        Phrase::Data(data) => data.clone(),
        Phrase::Known(word) => known(word),
        Phrase::Number(number) => decimal(number),
        Phrase::Languages { own, others } => others.get(current().code()).unwrap_or(own).clone(),
        Phrase::Sentence { words, values } => {
            let said: Vec<_> = values.iter().map(|(name, value)| (*name, self::phrase(value))).collect();
            let values: Vec<(&str, &dyn Display)> = said.iter().map(|(name, value)| (*name, value as _)).collect();
            fill(say(words), &values)
        }
    }
}

/// For tests that search for untranslatable text: puts every sentence in brackets.
fn bracketed(sentence: &str) -> &'static str {
    Box::leak(format!("⟦{sentence}⟧").into_boxed_str())
}

/// Parses every catalogue.
///
/// # Errors
/// If one is invalid.
pub fn check() -> anyhow::Result<()> {
    catalogue::check()
}

#[cfg(test)]
mod tests {
    //! A translation must contain its values, in the plural form for the count, and fall back to
    //! English instead of an empty text.

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

    #[tokio::test]
    async fn two_that_take_turns_on_a_thread_speak_each_their_own() {
        let german = Language::named("de").expect("German");
        let spoken = || async {
            tokio::task::yield_now().await;
            current()
        };
        let both = tokio::join!(speaking(german, spoken()), spoken());
        assert_eq!(both, (german, Language::ENGLISH));
        let ended = std::panic::catch_unwind(|| within(german, || assert!(current() != german, "as it should")));
        assert!(ended.is_err() && current() == Language::ENGLISH, "a call that fails leaves nothing behind");
    }

    #[test]
    fn multilingual_text_is_read_in_the_current_language() {
        let text =
            Phrase::Languages { own: "too deep".to_owned(), others: [("de".to_owned(), "zu tief".to_owned())].into() };
        assert_eq!([phrase(&text), german(|| phrase(&text))], ["too deep", "zu tief"]);
        assert_eq!(text.to_string(), "too deep");
    }
}
