//! What the columns of a roster are called: in Moodle, Canvas, Stud.IP, HISinOne, OneRoster and by hand, in English and German.

use serde::{Deserialize, Serialize};

/// What a column tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RosterColumn {
    /// The address.
    Email,
    /// What somebody signs in with elsewhere; an address in some systems.
    Login,
    /// The whole name.
    Name,
    /// The given name.
    Given,
    /// The family name.
    Family,
    /// The number that the registrar knows somebody by.
    RegistrarId,
    /// The cohort, or several.
    Cohort,
    /// Trainee or instructor.
    Role,
    /// Active or deleted.
    Status,
    /// Whether the account may be used: true or false.
    Enabled,
    /// Whether the account is suspended: 1 or 0.
    Suspended,
    /// Whether the account is deleted: 1 or 0.
    Deleted,
}

/// Headings in plain form: lower case, letters and digits only. Of two columns that tell the same, the one of the earlier list counts.
const HEADINGS: [(RosterColumn, &[&[&str]]); 12] = [
    (
        RosterColumn::Email,
        &[
            &[
                "email",
                "emailaddress",
                "mail",
                "mailaddress",
                "emailadresse",
                "mailadresse",
                "emailaddr",
                "studentemail",
            ],
            &["emailuni", "emailhochschule", "emailadressehochschule", "primaryemail", "emaildienstlich"],
            &["emailprivat", "privateemail", "secondaryemail"],
        ],
    ),
    (
        RosterColumn::Login,
        &[
            &["loginid", "login", "username", "sisloginid"],
            &["benutzername", "nutzername", "anmeldename", "benutzerkennung", "kennung", "nutzerkennung"],
        ],
    ),
    (
        RosterColumn::Name,
        &[
            &[
                "name",
                "fullname",
                "displayname",
                "student",
                "studentname",
                "vollständigername",
                "anzeigename",
                "vollername",
            ],
            &["sortablename"],
            &["shortname"],
        ],
    ),
    (
        RosterColumn::Given,
        &[&["firstname", "givenname", "forename", "given", "first", "vorname", "vornamen"], &["rufname"]],
    ),
    (
        RosterColumn::Family,
        &[&["lastname", "surname", "familyname", "family", "last", "nachname", "familienname", "zuname"]],
    ),
    (
        RosterColumn::RegistrarId,
        &[
            &["matriculationnumber", "matrikelnummer", "matrikelnr", "matrikel", "mtknr", "mtnr", "matrnr", "matnr"],
            &[
                "sisuserid",
                "sisid",
                "studentid",
                "studentnumber",
                "studentno",
                "registrationnumber",
                "idnumber",
                "idnummer",
            ],
            &["identifier", "personalnummer"],
            &["userid"],
            &["id", "sourcedid"],
        ],
    ),
    (
        RosterColumn::Cohort,
        &[
            &["cohort", "group", "groups", "kohorte", "gruppe", "gruppen", "cohorts", "kohorten"],
            &["section", "class", "klasse", "jahrgang"],
            &["course", "kurs", "sectionid"],
        ],
    ),
    (RosterColumn::Role, &[&["role", "roles", "rolle", "rollen", "funktion"], &["declaredusertype", "usertype"]]),
    (RosterColumn::Status, &[&["status", "state", "workflowstate", "zustand"]]),
    (RosterColumn::Enabled, &[&["enableduser", "enabled", "accountenabled"]]),
    (RosterColumn::Suspended, &[&["suspended", "issuspended", "gesperrt"]]),
    (RosterColumn::Deleted, &[&["deleted", "isdeleted", "gelöscht"]]),
];

/// A heading in plain form.
fn plain(heading: &str) -> String {
    heading.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect()
}

/// What a heading means, if anything, and how little it is sure: 0 is the surest.
#[must_use]
pub fn meaning(heading: &str) -> Option<(RosterColumn, usize)> {
    let plain = plain(heading);
    HEADINGS.iter().find_map(|(column, ranks)| {
        let rank = ranks.iter().position(|known| known.contains(&plain.as_str()))?;
        Some((*column, rank))
    })
}

/// Whether a heading says that a field holds several groups.
#[must_use]
pub(super) fn is_plural(heading: &str) -> bool {
    ["groups", "gruppen", "cohorts", "kohorten"].contains(&plain(heading).as_str())
}

/// Whether the headings are those of Canvas's gradebook, which lists the sections of a student in a sentence.
#[must_use]
pub(super) fn is_canvas_gradebook(headings: &[String]) -> bool {
    let has = |wanted: &str| headings.iter().any(|heading| plain(heading) == wanted);
    has("student") && has("section") && (has("sisloginid") || has("sisuserid"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_known_however_they_are_written() {
        for (heading, column) in [
            ("E-Mail", RosterColumn::Email),
            ("email address", RosterColumn::Email),
            ("E-Mail-Adresse", RosterColumn::Email),
            ("login_id", RosterColumn::Login),
            ("user_id", RosterColumn::RegistrarId),
            ("Matrikel-Nr.", RosterColumn::RegistrarId),
            ("Mtknr", RosterColumn::RegistrarId),
            ("Vorname", RosterColumn::Given),
            ("last_name", RosterColumn::Family),
            ("full_name", RosterColumn::Name),
            ("Gruppe", RosterColumn::Cohort),
            ("STATUS", RosterColumn::Status),
        ] {
            assert_eq!(meaning(heading).map(|(column, _)| column), Some(column), "{heading}");
        }
        assert_eq!(meaning("favourite colour"), None);
        assert_eq!(meaning("password"), None);
    }

    #[test]
    fn no_heading_means_two_things() {
        let mut all: Vec<&str> =
            HEADINGS.iter().flat_map(|(_, ranks)| ranks.iter().flat_map(|known| known.iter().copied())).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
