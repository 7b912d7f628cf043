//! Pages of the choice of content for a course of a learning platform.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::deep_linking::{ContentKind, LinkableContent};

use crate::{Shell, assets, format};

/// The page on which a teacher chooses content.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/choose.html")]
pub struct ChooseContentPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the learning platform.
    pub platform: String,
    /// Address of this page.
    pub href: String,
    /// What can be chosen.
    pub content: Vec<LinkableContent>,
    /// Whether the platform takes several links.
    pub takes_several: bool,
    /// Why the last choice was refused.
    pub refused: Option<String>,
}

impl ChooseContentPage {
    /// Returns the kinds of which there is content: heading, and content.
    fn groups(&self) -> Vec<(&'static str, Vec<&LinkableContent>)> {
        let heading = |kind| match kind {
            ContentKind::Assignment => tr!("Assignments"),
            ContentKind::Course => tr!("Courses"),
            ContentKind::Exercise => tr!("Exercises"),
        };
        let of = |kind| self.content.iter().filter(|content| content.kind == kind).collect::<Vec<_>>();
        let groups = ContentKind::ALL.map(|kind| (heading(kind), of(kind)));
        groups.into_iter().filter(|(_, content)| !content.is_empty()).collect()
    }

    const fn input(&self) -> &'static str {
        if self.takes_several { "checkbox" } else { "radio" }
    }
}

/// The page whose form posts the signed response to the platform.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/link_content.html")]
pub struct LinkContentPage {
    /// Name of the learning platform.
    pub platform: String,
    /// Address to which the form is posted.
    pub return_url: String,
    /// The response.
    pub jwt: String,
    /// Number of links.
    pub links: usize,
}

impl LinkContentPage {
    fn said_links(&self) -> String {
        let platform = &self.platform;
        match self.links {
            0 => tr!("Nothing was chosen. {platform} adds no link.", platform = platform),
            links => trn!(
                "{count} link is ready. {platform} adds it to the course.",
                "{count} links are ready. {platform} adds them to the course.",
                links,
                count = links,
                platform = platform
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn page(takes_several: bool) -> ChooseContentPage {
        let content = |kind, id: &str, cohort: Option<&str>| LinkableContent {
            kind,
            id: id.to_owned(),
            title: format!("<b>{id}"),
            cohort: cohort.map(str::to_owned),
        };
        ChooseContentPage {
            shell: samples::shell(Role::Instructor),
            platform: "Moodle".to_owned(),
            href: "/lti/deep-link/1".to_owned(),
            content: vec![
                content(ContentKind::Exercise, "feel-the-layers", None),
                content(ContentKind::Assignment, "7", Some("Spring")),
            ],
            takes_several,
            refused: Some("no".to_owned()),
        }
    }

    #[test]
    fn content_is_listed_by_kind() {
        let html = samples::keep_page("lti-choose", &page(true));
        assert!(html.contains("value=\"assignment:7\"") && html.contains("Spring"), "{html}");
        assert!(html.contains("&#60;b&#62;feel-the-layers") && !html.contains("Courses</legend>"), "{html}");
        assert_eq!(html.matches("type=\"checkbox\" name=\"content\"").count(), 2, "{html}");
        assert_eq!(page(false).render().unwrap().matches("type=\"radio\" name=\"content\"").count(), 2);
    }

    #[test]
    fn the_response_is_posted_by_a_visible_button() {
        let page = LinkContentPage {
            platform: "Moodle".to_owned(),
            return_url: "https://lms.example.edu/return?a=1&b=\"".to_owned(),
            jwt: "a.b.c".to_owned(),
            links: 2,
        };
        let html = samples::keep_page("lti-link-content", &page);
        assert!(html.contains("action=\"https://lms.example.edu/return?a=1&#38;b=&#34;\""), "{html}");
        assert!(html.contains("name=\"JWT\" value=\"a.b.c\"") && html.contains("<button type=\"submit\">"), "{html}");
        assert!(html.contains("2 links are ready"), "{html}");
    }
}
