//! Links that open a recording in an external viewer.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::SessionId;

use crate::Shell;

/// Newly created links to a recording, shown only once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "recordings/links.html")]
pub struct RecordingLinksPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the attempt.
    pub session: SessionId,
    /// Name of each viewer, and its address with the recording.
    pub viewers: Vec<(&'static str, String)>,
    /// Address of the recording itself.
    pub recording: String,
    /// Validity of the links, in minutes.
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
