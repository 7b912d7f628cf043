//! The administrator's pages: the school at a glance, its queue and its stations.

use askama::Template;
use askama_web::WebTemplate;
use model::membership::MembershipRequest;
use time::OffsetDateTime;

use super::cohort::CohortLine;
use super::{Shell, StatusWord, format};

/// The administrator's home.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "admin_home.html")]
pub struct AdminHomePage {
    /// Frame.
    pub shell: Shell,
    /// What is new for them.
    pub news: Vec<super::news::NewsItem>,
    /// The school's name.
    pub school: String,
    /// Figures: how many, and of what.
    pub counts: Vec<(i64, &'static str)>,
    /// The queue.
    pub queue: Queue,
    /// The first cohorts by name.
    pub cohorts: Vec<CohortLine>,
    /// There are others.
    pub more: bool,
    /// Nobody has chosen the school's time zone yet, and nobody has practised.
    pub clock_open: bool,
}

/// The administration.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "admin.html")]
pub struct AdminPage {
    /// Frame.
    pub shell: Shell,
    /// The school's name.
    pub school: String,
    /// The queue.
    pub queue: Queue,
    /// Who is asked for in a cohort.
    pub requests: Vec<MembershipRequest>,
    /// Stations with a token.
    pub stations: Vec<StationRow>,
    /// People who were warned that they are to be erased.
    pub warned: i64,
}

impl AdminPage {
    /// Who is to be erased, in words.
    fn warned_words(&self) -> String {
        let warned = self.warned;
        trn!(
            "{n} person was warned, and is to be erased by the rule of retention.",
            "{n} people were warned, and are to be erased by the rule of retention.",
            warned
        )
    }
}

/// What waits to be scored, and what went wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Queue {
    /// Recordings in the queue.
    pub waiting: i64,
    /// Of them, those that failed at least once: session's page, tries and last error.
    pub failing: Vec<(String, i64, String)>,
    /// Recordings that could not be scored.
    pub refused: i64,
    /// Recordings whose re-simulation differs.
    pub flagged: i64,
}

impl Queue {
    /// What waits, in words.
    #[must_use]
    pub fn waiting_words(&self) -> String {
        trn!("{n} recording waits", "{n} recordings wait", self.waiting)
    }

    /// What could not be scored, in words.
    #[must_use]
    pub fn refused_words(&self) -> String {
        trn!("{n} recording could not be scored", "{n} recordings could not be scored", self.refused)
    }

    /// What differs, in words.
    #[must_use]
    pub fn flagged_words(&self) -> String {
        trn!(
            "{n} recording with a re-simulation that differs",
            "{n} recordings with a re-simulation that differs",
            self.flagged
        )
    }
}

/// A station that may upload.
#[derive(Clone, Debug, PartialEq)]
pub struct StationRow {
    /// Name.
    pub name: String,
    /// It signs what is recorded at it.
    pub signs: bool,
    /// Since when.
    pub since: OffsetDateTime,
    /// When it last asked for anything.
    pub seen: Option<OffsetDateTime>,
    /// Where its token is revoked; absent where it was.
    pub revoke_href: Option<String>,
}

/// A code by which a station may join, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "pairing_code.html")]
pub struct PairingCodePage {
    /// Frame.
    pub shell: Shell,
    /// The code.
    pub code: String,
    /// Until when it is good.
    pub expires_at: OffsetDateTime,
    /// For how long, in minutes.
    pub minutes: i64,
    /// Where a station finds the service.
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
            html.contains("1034") && html.contains("4 recordings wait") && html.contains("No cohorts yet"),
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
