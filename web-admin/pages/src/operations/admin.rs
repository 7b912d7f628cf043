//! Administration pages: school overview, scoring queue and stations.

use askama::Template;
use askama_web::WebTemplate;
use model::training::membership::MembershipRequest;
use time::OffsetDateTime;

use crate::training::cohort::CohortLine;
use crate::{Shell, StatusWord, format};

/// The administrator's home page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/admin_home.html")]
pub struct AdminHomePage {
    /// Page frame.
    pub shell: Shell,
    /// News for the administrator.
    pub news: Vec<crate::letters::news::NewsItem>,
    /// Name of the school.
    pub school: String,
    /// Counts for the overview: number and label.
    pub counts: Vec<(i64, &'static str)>,
    /// The scoring queue.
    pub queue: Queue,
    /// The first cohorts by name.
    pub cohorts: Vec<CohortLine>,
    /// Whether there are more cohorts than listed.
    pub more: bool,
    /// Nobody has chosen the school's time zone yet, and nobody has practised.
    pub clock_open: bool,
}

/// The administration page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/admin.html")]
pub struct AdminPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the school.
    pub school: String,
    /// The scoring queue.
    pub queue: Queue,
    /// Open requests for cohort membership.
    pub requests: Vec<MembershipRequest>,
    /// Stations that have or had a token.
    pub stations: Vec<StationRow>,
    /// Number of people who have been warned that they will be erased.
    pub warned: i64,
}

impl AdminPage {
    /// Describes how many people are due for erasure.
    fn warned_words(&self) -> String {
        let warned = self.warned;
        trn!(
            "{n} person was warned and will be erased under the retention rule.",
            "{n} people were warned and will be erased under the retention rule.",
            warned
        )
    }
}

/// State of the scoring queue.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Queue {
    /// Number of recordings waiting to be scored.
    pub waiting: i64,
    /// Waiting recordings that failed at least once: address of the session's page, tries and last
    /// error.
    pub failing: Vec<(String, i64, String)>,
    /// Number of recordings that could not be scored.
    pub refused: i64,
    /// Number of recordings whose re-simulation differs.
    pub flagged: i64,
}

impl Queue {
    /// Describes the number of waiting recordings.
    #[must_use]
    pub fn waiting_words(&self) -> String {
        trn!("{n} recording is waiting", "{n} recordings are waiting", self.waiting)
    }

    /// Describes the number of recordings that could not be scored.
    #[must_use]
    pub fn refused_words(&self) -> String {
        trn!("{n} recording could not be scored", "{n} recordings could not be scored", self.refused)
    }

    /// Describes the number of recordings whose re-simulation differs.
    #[must_use]
    pub fn flagged_words(&self) -> String {
        trn!("{n} recording whose re-simulation differs", "{n} recordings whose re-simulation differs", self.flagged)
    }
}

/// A paired station.
#[derive(Clone, Debug, PartialEq)]
pub struct StationRow {
    /// Name.
    pub name: String,
    /// Whether the station signs its recordings.
    pub signs: bool,
    /// When the station was paired.
    pub since: OffsetDateTime,
    /// Time of the station's last request.
    pub seen: Option<OffsetDateTime>,
    /// Address that revokes the station's token; `None` if it has been revoked.
    pub revoke_href: Option<String>,
}

/// A pairing code for a new station, shown only once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/pairing_code.html")]
pub struct PairingCodePage {
    /// Page frame.
    pub shell: Shell,
    /// The pairing code.
    pub code: String,
    /// Expiry time of the code.
    pub expires_at: OffsetDateTime,
    /// Validity of the code, in minutes.
    pub minutes: i64,
    /// Address of the service, to be entered at the station.
    pub address: String,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn queue() -> Queue {
        let failing = vec![("/sessions/1".to_owned(), 3, "disk full <no>".to_owned())];
        Queue { waiting: 4, failing, refused: 1, flagged: 0 }
    }

    #[test]
    fn the_home_shows_counts_and_the_queue() {
        let page = AdminHomePage {
            clock_open: true,
            news: samples::news(),
            shell: samples::shell(Role::Administrator),
            school: "Example School".to_owned(),
            counts: vec![(28, "trainees"), (3, "instructors"), (1034, "attempts")],
            queue: queue(),
            cohorts: vec![],
            more: false,
        };
        let html = samples::keep_page("admin-home", &page);
        assert!(
            html.contains("1034") && html.contains("4 recordings are waiting") && html.contains("No cohorts yet"),
            "{html}"
        );
    }

    #[test]
    fn the_administration_lists_stations_and_what_fails() {
        let page = AdminPage {
            shell: samples::shell(Role::Administrator),
            school: "Example School".to_owned(),
            queue: queue(),
            requests: vec![samples::request()],
            stations: vec![
                StationRow {
                    name: "Skills lab 2".to_owned(),
                    signs: true,
                    since: samples::NOW,
                    seen: Some(samples::NOW),
                    revoke_href: Some("/admin/stations/1/revoke".to_owned()),
                },
                StationRow {
                    name: "Skills lab 1".to_owned(),
                    signs: false,
                    since: samples::NOW,
                    seen: None,
                    revoke_href: None,
                },
            ],
            warned: 2,
        };
        let html = samples::keep_page("admin", &page);
        assert!(
            html.contains("disk full &#60;no&#62;")
                && html.contains("href=\"/people\"")
                && html.contains("Skills lab 2")
        );
        assert_eq!(html.matches("/revoke\"").count(), 1, "what is revoked cannot be revoked again");
    }

    #[test]
    fn a_pairing_code_comes_with_what_to_do_with_it() {
        let page = PairingCodePage {
            shell: samples::shell(Role::Administrator),
            code: "ABCD-EFGH".to_owned(),
            expires_at: samples::NOW,
            minutes: 10,
            address: "https://skills.example".to_owned(),
        };
        let html = samples::keep_page("pairing-code", &page);
        assert!(
            html.contains("stylet pair --server https://skills.example")
                && html.contains("ABCD-EFGH")
                && html.contains("10 minutes"),
            "{html}"
        );
    }
}
