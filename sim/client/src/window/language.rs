//! The language of the window.

use eframe::egui::Ui;
use words::Language;

/// The sources of the language, in order of precedence: the user's choice in the window, the
/// command line, the school's setting for the signed-in user, the system. English if none of them
/// is a supported language.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WindowLanguage {
    chosen: Option<Language>,
    asked: Option<Language>,
    known: Option<Language>,
    system: Option<Language>,
}

impl WindowLanguage {
    /// The sources for a new window, with the language given on the command line.
    #[must_use]
    pub fn new(asked: Option<Language>) -> Self {
        Self { asked, system: find_system_language(sys_locale::get_locales()), ..Self::default() }
    }

    /// Returns the current language.
    #[must_use]
    pub fn spoken(&self) -> Language {
        self.chosen.or(self.asked).or(self.known).or(self.system).unwrap_or(Language::ENGLISH)
    }

    /// Resets the choice when a user signs in or out. `known` is the school's setting for the new
    /// user.
    pub fn change_person(&mut self, known: Option<Language>) {
        (self.chosen, self.known) = (None, known);
    }

    /// Shows the languages by their own names, to choose from.
    pub fn ui(&mut self, ui: &mut Ui) {
        let spoken = self.spoken();
        for language in Language::all() {
            if ui.selectable_label(language == spoken, language.own_name()).clicked() {
                self.chosen = Some(language);
            }
        }
    }
}

/// Returns the first supported language of the system's locales. `C` and `POSIX` stand for English.
fn find_system_language(mut locales: impl Iterator<Item = String>) -> Option<Language> {
    locales.find_map(|locale| match locale.as_str() {
        "C" | "POSIX" => Some(Language::ENGLISH),
        named => Language::named(named),
    })
}

#[cfg(test)]
mod tests {
    //! Fails if the system prevents users from choosing their language, or if the choice is kept
    //! for the next user.

    use super::*;

    #[test]
    fn language_of_the_person_precedes_command_school_and_system() {
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
