//! The page of a person's calendar address.

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use crate::{Shell, format};

/// The page on which a person creates, copies and revokes the address of their calendar.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/calendar_feed.html")]
pub struct CalendarFeedPage {
    /// Page frame.
    pub shell: Shell,
    /// When the address was created; `None` without one.
    pub made_at: Option<OffsetDateTime>,
    /// The address, directly after it was created.
    pub address: Option<String>,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn an_address_is_shown_once_and_can_be_revoked() {
        let page = |made_at, address| CalendarFeedPage { shell: samples::shell(Role::Trainee), made_at, address };
        let html = samples::keep_page("calendar-none", &page(None, None));
        assert!(html.contains("Create an address") && !html.contains("revoke\""), "{html}");
        let secret = "https://stylet.example/calendar/abc.ics".to_owned();
        let html = samples::keep_page("calendar-made", &page(Some(samples::NOW), Some(secret.clone())));
        assert!(html.contains(&secret) && html.contains("/account/calendar/revoke"), "{html}");
        let html = samples::keep_page("calendar", &page(Some(samples::NOW), None));
        assert!(!html.contains(".ics") && html.contains("Create a new address"), "{html}");
    }
}
