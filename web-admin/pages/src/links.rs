//! Addresses that open a recording in a viewer elsewhere.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::SessionId;

use super::Shell;

/// Addresses that were made for a recording, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "links.html")]
pub struct RecordingLinksPage {
    /// Frame.
    pub shell: Shell,
    /// The attempt.
    pub session: SessionId,
    /// Name and address of each viewer, with the recording.
    pub viewers: Vec<(&'static str, String)>,
    /// The recording's own address.
    pub recording: String,
    /// How long they work, in minutes.
    pub minutes: i64,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn says_how_long_the_addresses_work() {
        let page = RecordingLinksPage {
            shell: samples::shell(Role::Trainee),
            session: SessionId::nil(),
            viewers: vec![("Foxglove", "https://app.foxglove.dev/?x=1&y=2".to_owned())],
            recording: "https://school.example/recordings/a/b.mcap".to_owned(),
            minutes: 15,
        };
        let html = samples::keep_page("links", &page);
        assert!(html.contains("15 minutes") && html.contains("Foxglove") && html.contains("x=1&#38;y=2"), "{html}");
    }
}
