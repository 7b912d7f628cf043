//! Preview of an instrument draft as respondents will see it.

use documents::Instrument;

use super::form::{FormPage, FormQuestion, GivenField, speak_language};

/// Additional content of a form page that its author previews.
#[derive(Clone, Debug)]
pub struct FormPreview {
    /// Address of the draft.
    pub draft: String,
    /// Introduction before the first question; empty on later pages.
    pub intro: String,
    /// Whether the page is asked only after certain answers.
    pub is_conditional: bool,
    /// Address of the previous page.
    pub back: Option<String>,
    /// Address of the next page.
    pub next: Option<String>,
    /// This page in each language.
    pub languages: Vec<PreviewLanguage>,
}

/// A page of a preview in a language.
#[derive(Clone, Debug)]
pub struct PreviewLanguage {
    /// Code.
    pub code: String,
    /// Address.
    pub href: String,
}

impl FormPage {
    /// Builds a page of an instrument draft.
    #[must_use]
    pub fn of_draft(instrument: &Instrument, draft: &str, language: &str, page: usize) -> Self {
        let pages = instrument.pages();
        let page = page.min(pages.len().saturating_sub(1));
        let (section, items) = pages.get(page).cloned().unwrap_or_default();
        let read = |words: &documents::instrument::Words| words.in_language(language).to_owned();
        let heading =
            section.map(|section| (read(&section.title), section.text.as_ref().map_or_else(String::new, read)));
        let question =
            |at: usize| FormQuestion::new(instrument, &instrument.items[at], language, &GivenField::default());
        let href = |language: &str, page: usize| format!("{draft}/questions?lang={language}&page={page}");
        let in_language = |code: &String| PreviewLanguage { code: code.clone(), href: href(code, page) };
        let intro = instrument.intro.as_ref().filter(|_| page == 0).map_or_else(String::new, read);
        let preview = FormPreview {
            draft: draft.to_owned(),
            intro,
            is_conditional: section.is_some_and(|section| section.when.is_some()),
            back: page.checked_sub(1).map(|page| href(language, page)),
            next: (page + 1 < pages.len()).then(|| href(language, page + 1)),
            languages: instrument.languages.iter().map(in_language).collect(),
        };
        speak_language(language, || Self {
            language: language.to_owned(),
            title: read(&instrument.title),
            heading,
            step: (page + 1, pages.len().max(1)),
            is_last: page + 1 >= pages.len(),
            page,
            questions: items.into_iter().map(question).collect(),
            action: String::new(),
            preview: Some(preview),
        })
    }
}
