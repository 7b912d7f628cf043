//! The curricula of a school.

use askama::Template;
use askama_web::WebTemplate;

use crate::{Shell, StatusWord};

/// The list of curricula.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/curricula.html")]
pub struct CurriculaPage {
    /// Page frame.
    pub shell: Shell,
    /// Whether the visitor may write documents.
    pub staff: bool,
    /// Title of the course that was just published.
    pub published: Option<String>,
    /// Curricula.
    pub courses: Vec<CourseCard>,
}

/// A curriculum.
#[derive(Clone, Debug)]
pub struct CourseCard {
    /// Id in its document.
    pub id: String,
    /// Title.
    pub title: String,
    /// Description of its content.
    pub description: String,
    /// The mastery rule as text.
    pub rule: String,
    /// Its exercises in order.
    pub exercises: Vec<ExerciseLine>,
}

/// An exercise of a curriculum.
#[derive(Clone, Debug)]
pub struct ExerciseLine {
    /// Address of the exercise's page.
    pub href: String,
    /// Its title.
    pub title: String,
    /// Difficulty, 1–5.
    pub difficulty: u8,
    /// Titles of the exercises to be mastered first.
    pub prerequisites: Vec<String>,
    /// The visitor's status, if the visitor is a trainee.
    pub status: Option<StatusWord>,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn page() -> CurriculaPage {
        let line = |title: &str, id: &str, difficulty, before: &[&str], status| ExerciseLine {
            href: format!("/exercises/{id}"),
            title: title.to_owned(),
            difficulty,
            prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
            status: Some(status),
        };
        CurriculaPage {
            shell: samples::shell(Role::Trainee),
            staff: false,
            published: None,
            courses: vec![CourseCard {
                id: "lower-back-basics".to_owned(),
                title: "Lower back: first punctures".to_owned(),
                description: "Exercises with a trocar on the lower back.".to_owned(),
                rule: "mastered after 3 passes within 5 consecutive attempts".to_owned(),
                exercises: vec![
                    line("Feel the layers", "feel-the-layers", 1, &[], StatusWord::Mastered),
                    line("Stop in the fat", "stop-in-the-fat", 2, &["Feel the layers"], StatusWord::Current),
                    line("Reach 20 mm in muscle", "reach-the-muscle", 2, &["Stop in the fat"], StatusWord::Locked),
                ],
            }],
        }
    }

    #[test]
    fn lists_exercises_with_what_comes_before_them() {
        let html = samples::keep_page("curricula", &page());
        assert!(
            html.contains("after Feel the layers") && html.contains(r#"href="/exercises/stop-in-the-fat""#),
            "{html}"
        );
        let empty = CurriculaPage {
            shell: samples::shell(Role::Administrator),
            staff: true,
            published: Some("Lower back".to_owned()),
            courses: vec![],
        };
        assert!(samples::keep_page("curricula-empty", &empty).contains("No courses yet"));
    }
}
