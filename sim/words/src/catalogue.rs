//! The catalogues: a PO file for each language, carried inside the program and read once.

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

/// The sentences of a language, by their English.
#[derive(Debug)]
pub(super) struct Catalogue {
    plural: PluralForms,
    forms: BTreeMap<String, Vec<String>>,
}

/// By the language's code.
type Catalogues = BTreeMap<&'static str, Catalogue>;

/// Read once, or why they cannot be, which [`check`] tells when the service starts.
static READ: LazyLock<anyhow::Result<Catalogues>> = LazyLock::new(read_all);

impl Catalogue {
    fn read(code: &str, text: &[u8]) -> anyhow::Result<Self> {
        let file = po_file::parse_from_reader(text).map_err(|refused| anyhow::anyhow!("{refused}"))?;
        let plural = PluralForms::of_language(code, file.metadata.plural_rules.nplurals)?;
        // A sentence that nobody has translated yet, or that has changed since, is said in English.
        let said = file.messages().filter(|message| message.is_translated() && !message.is_fuzzy());
        Ok(Self { plural, forms: said.map(|message| (message.msgid().to_owned(), forms(message))).collect() })
    }

    /// A sentence.
    pub(super) fn say(&self, sentence: &str) -> Option<&str> {
        self.forms.get(sentence)?.first().map(String::as_str)
    }

    /// The form of a sentence that goes with a count.
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
        // Read once, and for as long as the program runs.
        all.insert(
            &*code.to_owned().leak(),
            Catalogue::read(code, &file.data).with_context(|| format!("the catalogue {name}"))?,
        );
    }
    Ok(all)
}

/// The catalogue of a language; none of English.
pub(super) fn find(language: Language) -> Option<&'static Catalogue> {
    if language == Language::ENGLISH { None } else { READ.as_ref().ok()?.get(language.code()) }
}

/// The languages that have a catalogue.
pub(super) fn codes() -> impl Iterator<Item = &'static str> {
    READ.iter().flat_map(Catalogues::keys).copied()
}

/// Whether every catalogue can be read.
///
/// # Errors
/// When one is broken.
pub(super) fn check() -> anyhow::Result<()> {
    READ.as_ref().map(drop).map_err(|broken| anyhow::anyhow!("{broken:#}"))
}
