//! Available languages, and language negotiation.

use std::fmt;
use std::str::FromStr;

use super::catalogue;

/// A language of the user interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Language(&'static str);

impl Language {
    /// The language of the sentences in the code, which needs no catalogue.
    pub const ENGLISH: Self = Self("en");

    /// Pseudo-locale that puts every translatable sentence in brackets, so that a test finds
    /// untranslatable text.
    pub const PSEUDO: Self = Self("zxx");

    /// Returns the language code: `de`.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.0
    }

    /// Returns the language's own name: Deutsch.
    #[must_use]
    pub fn own_name(self) -> &'static str {
        own_name(self.0)
    }

    /// Returns every language, English first.
    pub fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::ENGLISH).chain(catalogue::codes().map(Self))
    }

    /// Returns the language of a code, ignoring the region: `de-AT` is `de`.
    #[must_use]
    pub fn named(code: &str) -> Option<Self> {
        let main = code.split(['-', '_']).next().unwrap_or_default();
        Self::all().find(|language| language.0.eq_ignore_ascii_case(main))
    }

    /// Returns the preferred language of an `Accept-Language` header.
    #[must_use]
    pub fn preferred(header: &str) -> Option<Self> {
        let wishes = header.split(',').filter_map(|wish| {
            let (code, quality) = wish.split_once(';').unwrap_or((wish, "q=1"));
            let quality: f32 = quality.trim().strip_prefix("q=")?.parse().ok()?;
            Some((Self::named(code.trim())?, quality)).filter(|_| quality > 0.0)
        });
        // On a tie the first one wins: browsers list by preference.
        wishes.reduce(|best, wish| if wish.1 > best.1 { wish } else { best }).map(|(language, _)| language)
    }
}

/// Returns a language's own name, or its code if the name is unknown.
#[must_use]
pub fn own_name(code: &str) -> &str {
    match code {
        "en" => "English",
        "de" => "Deutsch",
        "es" => "Español",
        "fr" => "Français",
        "it" => "Italiano",
        "nl" => "Nederlands",
        "pt" => "Português",
        "cs" => "Čeština",
        "da" => "Dansk",
        "fi" => "Suomi",
        "ja" => "日本語",
        "nb" => "Norsk bokmål",
        "pl" => "Polski",
        "sv" => "Svenska",
        "zh" => "中文",
        other => other,
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// A language without a catalogue.
#[derive(Debug, thiserror::Error)]
#[error("language: \"{0}\"; there is no catalogue of it")]
pub struct UnknownLanguage(String);

impl FromStr for Language {
    type Err = UnknownLanguage;

    fn from_str(code: &str) -> Result<Self, Self::Err> {
        Self::named(code).ok_or_else(|| UnknownLanguage(code.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    //! The header is parsed as browsers write it; a language without a catalogue is skipped.

    use super::*;

    #[test]
    fn the_best_wish_that_can_be_met_is() {
        let code = |header| Language::preferred(header).map_or("none", Language::code);
        assert_eq!(code("de-CH,de;q=0.9,en;q=0.8"), "de");
        assert_eq!(code("en;q=0.5, de;q=0.7"), "de");
        assert_eq!(code("fi, sv;q=0.9, en-GB;q=0.1"), "en");
        assert_eq!([code("fi"), code(""), code("de;q=0"), code("de;q=x, *")], ["none"; 4]);
    }

    #[test]
    fn a_region_is_its_language() {
        assert_eq!(Language::named("DE_at").map(Language::code), Some("de"));
        assert!(Language::named("tlh").is_none() && Language::named("").is_none());
        assert!("xx".parse::<Language>().is_err_and(|refused| refused.to_string().contains("xx")));
    }
}
