//! The page of grades for a learning platform.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::auth::grade_service::DeliveryState;
use time::OffsetDateTime;

use crate::{Shell, format};

/// The page of grades for a learning platform, in one state.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/deliveries.html")]
pub struct DeliveriesPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the platform.
    pub platform: String,
    /// Address of the page of the platform.
    pub href: String,
    /// State of the grades.
    pub shown: DeliveryState,
    /// The grades.
    pub rows: Vec<DeliveryRow>,
    /// Last one of this page, if there are further ones.
    pub next: Option<String>,
}

impl DeliveriesPage {
    fn can_retry(&self) -> bool {
        matches!(self.shown, DeliveryState::Stopped | DeliveryState::Waiting)
    }
}

fn say_state(state: impl Borrow<DeliveryState>) -> &'static str {
    match state.borrow() {
        DeliveryState::Stopped => tr!("Refused"),
        DeliveryState::Waiting => tr!("Waiting"),
        DeliveryState::Sent => tr!("Sent"),
        DeliveryState::Idle => tr!("Without a grade"),
    }
}

/// A grade for a learning platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeliveryRow {
    /// Name of the person.
    pub name: String,
    /// Address of the person's page.
    pub trainee: String,
    /// Path that the link opens.
    pub page: String,
    /// Title of that page; the path if it has none.
    pub title: String,
    /// Number of tries since the last success or change.
    pub tries: u32,
    /// Time of the next try.
    pub next: Option<OffsetDateTime>,
    /// Last HTTP status.
    pub status: Option<i64>,
    /// Last answer of a platform that has refused.
    pub answer: Option<String>,
    /// When it was last sent.
    pub sent: Option<OffsetDateTime>,
    /// Address of the form that has it sent again.
    pub retry: String,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn page(shown: DeliveryState) -> DeliveriesPage {
        DeliveriesPage {
            shell: samples::shell(Role::Administrator),
            platform: "Moodle".to_owned(),
            href: "/admin/platforms/1".to_owned(),
            shown,
            rows: vec![DeliveryRow {
                name: "Ada <b>".to_owned(),
                trainee: "/trainees/1".to_owned(),
                page: "/exercises/feel-the-layers".to_owned(),
                title: "Feel the layers".to_owned(),
                tries: 2,
                next: Some(samples::NOW),
                status: Some(404),
                answer: Some("<script>".to_owned()),
                sent: None,
                retry: "/admin/platforms/1/deliveries/2/retry".to_owned(),
            }],
            next: Some("2".to_owned()),
        }
    }

    #[test]
    fn a_refused_grade_shows_the_answer_and_a_button() {
        let html = samples::keep_page("deliveries", &page(DeliveryState::Stopped));
        assert!(html.contains("&#60;script&#62;") && html.contains("Ada &#60;b&#62;"), "{html}");
        assert!(html.contains("/deliveries/2/retry") && html.contains("state=stopped&amp;after=2"), "{html}");
        let sent = samples::keep_page("deliveries-sent", &page(DeliveryState::Sent));
        assert!(!sent.contains("/retry") && sent.contains(">Feel the layers</a>"), "{sent}");
    }
}
