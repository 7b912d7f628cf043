//! The catalogues: a PO file for each language, embedded in the program and parsed once.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use anyhow::Context;
use polib::message::MessageView;
use polib::po_file;
use rust_embed::Embed;

use super::Language;
use super::plural::PluralForms;

#[derive(Embed)]
#[folder = "locales/"]
struct CatalogueFiles;

/// The translations of a language, by English sentence.
#[derive(Debug)]
pub(super) struct Catalogue {
    plural: PluralForms,
    forms: BTreeMap<String, Vec<String>>,
}

/// Beginning of the header that defines the plural rule.
const HEADER: &[u8] = b"\"Plural-Forms:";

/// Catalogues by language code.
type Catalogues = BTreeMap<&'static str, Catalogue>;

/// The catalogues, parsed once, or the error, which [`check`] reports when the service starts.
static READ: LazyLock<anyhow::Result<Catalogues>> = LazyLock::new(read_all);

impl Catalogue {
    fn read(text: &[u8]) -> anyhow::Result<Self> {
        let file = po_file::parse_from_reader(text).map_err(|refused| anyhow::anyhow!("{refused}"))?;
        // Without the header, the parser would assume a language with a single form.
        anyhow::ensure!(text.windows(HEADER.len()).any(|part| part == HEADER), "the header Plural-Forms is missing");
        let plural = PluralForms::parse(file.metadata.plural_rules.nplurals, &file.metadata.plural_rules.expr)?;
        // A sentence without a translation, or with an outdated (fuzzy) one, stays in English.
        let said = file.messages().filter(|message| message.is_translated() && !message.is_fuzzy());
        Ok(Self { plural, forms: said.map(|message| (message.msgid().to_owned(), forms(message))).collect() })
    }

    /// Returns the translation of a sentence.
    pub(super) fn say(&self, sentence: &str) -> Option<&str> {
        self.forms.get(sentence)?.first().map(String::as_str)
    }

    /// Returns the plural form for a count.
    pub(super) fn say_counted(&self, one: &str, count: u64) -> Option<&str> {
        self.forms.get(one)?.get(self.plural.find_form(count)?).map(String::as_str)
    }
}

fn forms(message: &dyn MessageView) -> Vec<String> {
    match message.msgstr_plural() {
        Ok(forms) => forms.clone(),
        Err(_) => message.msgstr().map(|form| vec![form.to_owned()]).unwrap_or_default(),
    }
}

fn read_all() -> anyhow::Result<Catalogues> {
    let mut all = Catalogues::new();
    for name in CatalogueFiles::iter() {
        let Some((code, file)) = name.strip_suffix(".po").zip(CatalogueFiles::get(&name)) else { continue };
        // Leaked on purpose: the codes are read once and live as long as the program.
        all.insert(
            &*code.to_owned().leak(),
            Catalogue::read(&file.data).with_context(|| format!("the catalogue {name}"))?,
        );
    }
    Ok(all)
}

/// Returns the catalogue of a language; `None` for English.
pub(super) fn find(language: Language) -> Option<&'static Catalogue> {
    if language == Language::ENGLISH { None } else { READ.as_ref().ok()?.get(language.code()) }
}

/// Returns the codes of the languages that have a catalogue.
pub(super) fn codes() -> impl Iterator<Item = &'static str> {
    READ.iter().flat_map(Catalogues::keys).copied()
}

/// Checks that every catalogue can be parsed.
///
/// # Errors
/// If one is invalid.
pub(super) fn check() -> anyhow::Result<()> {
    READ.as_ref().map(drop).map_err(|broken| anyhow::anyhow!("{broken:#}"))
}

#[cfg(test)]
mod tests {
    //! A catalogue without a usable plural rule must be refused.

    use super::*;

    fn read(header: &str) -> anyhow::Result<Catalogue> {
        let text = format!(
            "msgid \"\"\nmsgstr \"\"\n\"Language: de\\n\"\n{header}\nmsgid \"{{n}} key\"\nmsgid_plural \"{{n}} keys\"\n\
             msgstr[0] \"{{n}} Schlüssel\"\nmsgstr[1] \"{{n}} Schlüssel alle\"\n"
        );
        Catalogue::read(text.as_bytes())
    }

    #[test]
    fn the_header_chooses_the_form() {
        let catalogue = read("\"Plural-Forms: nplurals=2; plural=n != 1;\\n\"\n").unwrap();
        let said = [0, 1, 2].map(|n| catalogue.say_counted("{n} key", n).unwrap());
        assert_eq!(said, ["{n} Schlüssel alle", "{n} Schlüssel", "{n} Schlüssel alle"]);
    }

    #[test]
    fn a_catalogue_without_a_sound_header_is_refused() {
        for (header, expected) in [
            ("", "Plural-Forms is missing"),
            ("\"Plural-Forms: nplurals=2;\\n\"\n", "plural rule expression does not exist"),
            ("\"Plural-Forms: nplurals=two; plural=n != 1;\\n\"\n", "nplurals"),
            ("\"Plural-Forms: nplurals=2; plural=n !! 1;\\n\"\n", "expected an operator at character 3"),
            ("\"Plural-Forms: nplurals=3; plural=n != 1;\\n\"\n", "no n has form 2"),
        ] {
            let refused = format!("{:#}", read(header).unwrap_err());
            assert!(refused.contains(expected), "{header}: {refused}");
        }
    }
}
