//! In which language the window speaks.

use eframe::egui::Ui;
use words::Language;

/// What decides it: the person's choice in the window, then the one on the command line, then what the school knows of whoever has signed
/// in, then the system's; English where none of them says one that the window speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WindowLanguage {
    chosen: Option<Language>,
    asked: Option<Language>,
    known: Option<Language>,
    system: Option<Language>,
}

impl WindowLanguage {
    /// Of a window that is opened with what its command line asks for.
    #[must_use]
    pub fn new(asked: Option<Language>) -> Self {
        Self { asked, system: find_system_language(sys_locale::get_locales()), ..Self::default() }
    }

    /// The language to speak now.
    #[must_use]
    pub fn spoken(&self) -> Language {
        self.chosen.or(self.asked).or(self.known).or(self.system).unwrap_or(Language::ENGLISH)
    }

    /// Somebody signs in or out, of whom the school knows a language or none. What the one before them chose is theirs no more.
    pub fn change_person(&mut self, known: Option<Language>) {
        (self.chosen, self.known) = (None, known);
    }

    /// The languages by their own names, to choose from.
    pub fn ui(&mut self, ui: &mut Ui) {
        let spoken = self.spoken();
        for language in Language::all() {
            if ui.selectable_label(language == spoken, language.own_name()).clicked() {
                self.chosen = Some(language);
            }
        }
    }
}

/// The first language that a system's user wants and the window speaks. A system without one speaks as programs are written.
fn find_system_language(mut locales: impl Iterator<Item = String>) -> Option<Language> {
    locales.find_map(|locale| match locale.as_str() {
        "C" | "POSIX" => Some(Language::ENGLISH),
        named => Language::named(named),
    })
}

#[cfg(test)]
mod tests {
    //! A person must be able to get their language whatever the machine thinks, and must not leave it to the next one.

    use super::*;

    #[test]
    fn the_person_decides_then_the_command_then_the_school_then_the_system() {
        let german = Language::named("de");
        let mut language = WindowLanguage::default();
        assert_eq!(language.spoken(), Language::ENGLISH);
        language.system = german;
        assert_eq!(Some(language.spoken()), german);
        language.change_person(Some(Language::ENGLISH));
        assert_eq!(language.spoken(), Language::ENGLISH, "the school knows better than the machine");
        language.asked = german;
        assert_eq!(Some(language.spoken()), german, "who started it said so");
        language.chosen = Some(Language::ENGLISH);
        assert_eq!(language.spoken(), Language::ENGLISH, "who sits there says so");
        language.change_person(None);
        assert_eq!(Some(language.spoken()), german, "the next one starts anew");
    }

    #[test]
    fn the_systems_wishes_are_read_in_their_order() {
        let found = |locales: &[&str]| find_system_language(locales.iter().map(|locale| (*locale).to_owned()));
        assert_eq!(found(&["de-AT"]), Language::named("de"));
        assert_eq!(found(&["fr-FR", "de-DE", "en"]), Language::named("de"));
        assert_eq!(found(&["C", "de-DE"]), Some(Language::ENGLISH));
        assert_eq!(found(&["fr-FR"]), None);
    }
}
