//! An instructor's home page: who needs help, the cohorts, the latest attempts.

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use crate::letters::news::NewsItem;
use crate::training::assignments::DueLine;
use crate::training::cohort::{CohortCard, TraineeRow};
use crate::training::trainee::OwnAttemptRow;
use crate::{Shell, StatusWord, format};

/// An instructor's home page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/instructor.html")]
pub struct InstructorPage {
    /// Page frame.
    pub shell: Shell,
    /// News for the instructor.
    pub news: Vec<NewsItem>,
    /// Cohorts of the instructor.
    pub cohorts: Vec<CohortCard>,
    /// Trainees who may need help, each with the name of their cohort.
    pub help: Vec<(String, TraineeRow)>,
    /// How many more may.
    pub more_help: usize,
    /// What is due soon in those cohorts, and what is late.
    pub due_lines: Vec<DueLine>,
    /// Latest attempts of those cohorts.
    pub recent: Vec<OwnAttemptRow>,
    /// Current time, for relative dates.
    pub now: OffsetDateTime,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn help_comes_first_and_an_empty_home_tells_the_next_step() {
        let cohort = samples::cohort_page();
        let help = cohort.help.iter().map(|row| ("Spring 2026".to_owned(), row.clone())).collect();
        let progress = samples::progress();
        let card = CohortCard::new("/cohorts/1".to_owned(), "Spring 2026".to_owned(), [&progress].into_iter());
        let shell = samples::shell(Role::Instructor);
        let recent = samples::attempts();
        let news = samples::news();
        let page = InstructorPage {
            shell: shell.clone(),
            news,
            cohorts: vec![card],
            help,
            more_help: 3,
            due_lines: vec![samples::due_line()],
            recent,
            now: samples::NOW,
        };
        let html = samples::keep_page("instructor-home", &page);
        assert!(
            html.find("Who needs help") < html.find("Due soon") && html.find("Due soon") < html.find("Your cohorts")
        );
        assert!(html.contains("News") && html.contains("has answered a comment"));
        let empty = InstructorPage {
            shell,
            news: vec![],
            cohorts: vec![],
            help: vec![],
            more_help: 0,
            due_lines: vec![],
            recent: vec![],
            now: samples::NOW,
        };
        assert!(samples::keep_page("instructor-empty", &empty).contains("You do not teach a cohort yet"));
    }
}
