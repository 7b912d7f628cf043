//! The confirmation page for erasing a person: data that is erased, data that stays, and other
//! texts that may mention the name.

use askama::Template;
use askama_web::WebTemplate;
use model::people::directory::DirectoryEntry;
use model::privacy::texts::{MOST_MENTIONS, TextCounts};

use crate::Shell;

/// The page that erases a person.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "privacy/erase.html")]
pub struct ErasePage {
    /// Page frame.
    pub shell: Shell,
    /// The person to erase.
    pub person: DirectoryEntry,
    /// Number of free texts, by author.
    pub texts: TextCounts,
    /// Whether the school's rule erases the recordings as well.
    pub recordings: bool,
    /// Texts by others about others that may mention the name: address of the attempt's page, and
    /// the text.
    pub mentions: Vec<(String, String)>,
    /// Whether the person is on legal hold and cannot be erased.
    pub held: bool,
    /// Whether the address entered as confirmation was wrong.
    pub unconfirmed: bool,
}

impl ErasePage {
    fn more(&self) -> bool {
        self.mentions.len() >= MOST_MENTIONS
    }

    fn written(&self) -> String {
        let written = self.texts.written;
        trn!("Make {n} text by them unreadable", "Make {n} texts by them unreadable", written)
    }

    fn about(&self) -> String {
        let about = self.texts.about;
        trn!("Make {n} text by others about them unreadable", "Make {n} texts by others about them unreadable", about)
    }

    fn sealed(&self) -> String {
        let sealed = self.texts.sealed;
        trn!(
            "{n} reason stays in the audit log, which cannot be changed.",
            "{n} reasons stay in the audit log, which cannot be changed.",
            sealed
        )
    }
}

#[cfg(test)]
mod tests {
    use model::Role;
    use model::ids::PersonId;
    use model::people::directory::AccountState;

    use super::*;
    use crate::samples;

    fn page(held: bool, mentions: Vec<(String, String)>) -> ErasePage {
        let person = DirectoryEntry {
            id: PersonId::nil(),
            name: "Ana Ek".to_owned(),
            email: "ana@example.org".to_owned(),
            role: Role::Trainee,
            state: AccountState::Active,
            pseudonym: "p-1".to_owned(),
            registrar_id: None,
            cohorts: String::new(),
        };
        ErasePage {
            shell: samples::shell(Role::Administrator),
            person,
            texts: TextCounts { written: 3, about: 1, sealed: 2 },
            recordings: held,
            mentions,
            held,
            unconfirmed: !held,
        }
    }

    #[test]
    fn it_is_said_what_goes_and_what_stays() {
        let mentions = vec![("/sessions/1".to_owned(), "Do as Ana <does>".to_owned())];
        let html = samples::keep_page("erase", &page(false, mentions));
        assert!(html.contains("3 texts by them") && html.contains("1 text by others"), "{html}");
        assert!(
            html.contains("Ana &#60;does&#62;")
                && html.contains("recordings are kept")
                && html.contains("2 reasons stay")
        );
        assert!(html.contains("not this person’s email address"), "{html}");
        let held = samples::keep_page("erase-held", &page(true, vec![]));
        assert!(held.contains("legal hold") && !held.contains("name=\"confirm\""), "{held}");
    }
}
