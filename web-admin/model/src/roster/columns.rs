//! What the columns of a roster are called, in English, German and the words of Canvas.

/// What a column tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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
    /// The cohort.
    Cohort,
    /// Trainee or instructor.
    Role,
    /// Active or deleted.
    Status,
}

/// Headings in plain form: lower case, letters and digits only.
const HEADINGS: [(RosterColumn, &[&str]); 9] = [
    (
        RosterColumn::Email,
        &["email", "emailaddress", "mail", "mailaddress", "emailadresse", "mailadresse", "emailaddr", "studentemail"],
    ),
    (
        RosterColumn::Login,
        &["loginid", "login", "username", "sisloginid", "benutzername", "benutzerkennung", "kennung"],
    ),
    (
        RosterColumn::Name,
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
    ),
    (RosterColumn::Given, &["firstname", "givenname", "forename", "given", "first", "vorname", "vornamen", "rufname"]),
    (
        RosterColumn::Family,
        &["lastname", "surname", "familyname", "family", "last", "nachname", "familienname", "zuname"],
    ),
    (
        RosterColumn::RegistrarId,
        &[
            "userid",
            "sisuserid",
            "sisid",
            "id",
            "studentid",
            "studentnumber",
            "studentno",
            "registrationnumber",
            "matriculationnumber",
            "matrikelnummer",
            "matrikelnr",
            "matrikel",
            "personalnummer",
        ],
    ),
    (
        RosterColumn::Cohort,
        &[
            "cohort",
            "group",
            "section",
            "class",
            "course",
            "sectionid",
            "kohorte",
            "gruppe",
            "kurs",
            "klasse",
            "jahrgang",
        ],
    ),
    (RosterColumn::Role, &["role", "declaredusertype", "usertype", "rolle", "funktion"]),
    (RosterColumn::Status, &["status", "state", "workflowstate", "zustand"]),
];

/// What a heading means, if anything.
#[must_use]
pub fn meaning(heading: &str) -> Option<RosterColumn> {
    let plain: String = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    HEADINGS.iter().find(|(_, known)| known.contains(&plain.as_str())).map(|(column, _)| *column)
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
            ("Vorname", RosterColumn::Given),
            ("last_name", RosterColumn::Family),
            ("full_name", RosterColumn::Name),
            ("Gruppe", RosterColumn::Cohort),
            ("STATUS", RosterColumn::Status),
        ] {
            assert_eq!(meaning(heading), Some(column), "{heading}");
        }
        assert_eq!(meaning("favourite colour"), None);
        assert_eq!(meaning("password"), None);
    }

    #[test]
    fn no_heading_means_two_things() {
        let mut all: Vec<&str> = HEADINGS.iter().flat_map(|(_, known)| known.iter().copied()).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
