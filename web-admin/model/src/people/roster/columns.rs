//! Headings of roster columns in Moodle, Canvas, Stud.IP, HISinOne, OneRoster and hand-written
//! lists, in English and German.

use serde::{Deserialize, Serialize};

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RosterColumn {
    /// Email address.
    Email,
    /// User name in another system; in some systems an email address.
    Login,
    /// Full name.
    Name,
    /// Given name.
    Given,
    /// Family name.
    Family,
    /// Registration number.
    RegistrarId,
    /// One or more cohorts.
    Cohort,
    /// Trainee or instructor.
    Role,
    /// Active or deleted.
    Status,
    /// The account is enabled: true or false.
    Enabled,
    /// The account is suspended: 1 or 0.
    Suspended,
    /// The account is deleted: 1 or 0.
    Deleted,
}

/// Normalized headings: lower case, letters and digits only. If two columns have the same meaning,
/// the one in the earlier list takes precedence.
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

/// Normalizes a heading.
fn plain(heading: &str) -> String {
    heading.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect()
}

/// Returns the meaning of a heading, if it is known, and its rank: 0 is the most certain.
#[must_use]
pub fn meaning(heading: &str) -> Option<(RosterColumn, usize)> {
    let plain = plain(heading);
    HEADINGS.iter().find_map(|(column, ranks)| {
        let rank = ranks.iter().position(|known| known.contains(&plain.as_str()))?;
        Some((*column, rank))
    })
}

/// Returns whether a heading indicates several groups per field.
#[must_use]
pub(super) fn is_plural(heading: &str) -> bool {
    ["groups", "gruppen", "cohorts", "kohorten"].contains(&plain(heading).as_str())
}

/// Returns whether the headings are those of Canvas's gradebook, which lists a student's sections
/// as a sentence.
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
