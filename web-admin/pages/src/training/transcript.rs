//! The transcript: a trainee's results in all courses, as a page and as a PDF.

use askama::Template;
use askama_web::WebTemplate;
use model::training::progress::{Course, Progress, StepState};
use model::training::signatory::Signatory;
use time::OffsetDateTime;

use crate::training::certificate::{number_words, scope_words, sign_block};
use crate::training::paper::{Block, Logo, Paper, PaperColumn, PaperTable, Style};
use crate::training::trainee::rule_in_words;
use crate::{Shell, format};

/// The page of a transcript.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/transcript.html")]
pub struct TranscriptPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the trainee and address of their page.
    pub trainee: (String, String),
    /// Address of the PDF.
    pub pdf_href: String,
    /// Name of the school.
    pub school: String,
    /// Number from the registrar's office.
    pub registrar_id: Option<String>,
    /// Courses, most recently practised first.
    pub courses: Vec<TranscriptCourse>,
    /// Outcomes with a level in force, by code.
    pub outcomes: Vec<TranscriptOutcome>,
    /// Time of creation.
    pub made_at: OffsetDateTime,
}

impl TranscriptPage {
    /// States that a transcript proves nothing by itself.
    fn unsigned_note(&self) -> &'static str {
        tr!("This page is not signed. For a signed statement, use a certificate.")
    }

    /// Returns the transcript as a paper: the same sentences as the page.
    #[must_use]
    pub fn paper(&self, logo: Option<Logo>, signatory: Option<&Signatory>) -> Paper {
        let mut blocks = vec![
            Block::text(Style::School, &self.school),
            Block::Heading(1, tr!("Transcript").to_owned()),
            Block::text(Style::Name, &self.trainee.0),
        ];
        blocks.extend(self.registrar_id.as_deref().map(|number| Block::text(Style::Body, number_words(number))));
        blocks.push(Block::text(Style::Body, format!("{} {}", tr!("As of"), format::format_date(self.made_at))));
        if self.courses.is_empty() {
            blocks.push(Block::text(Style::Body, tr!("This school has no courses yet.")));
        }
        blocks.extend(self.courses.iter().flat_map(TranscriptCourse::blocks));
        if !self.outcomes.is_empty() {
            blocks.push(Block::Heading(2, tr!("Outcomes").to_owned()));
            let column = |title: &str, percent| PaperColumn { title: title.to_owned(), percent };
            let columns = vec![column(tr!("Outcome"), 40), column(tr!("Level"), 30), column(tr!("Decided"), 30)];
            let rows = self.outcomes.iter().map(TranscriptOutcome::cells).collect();
            blocks.push(Block::Table(PaperTable { columns, rows }));
        }
        blocks.push(Block::text(Style::Strong, scope_words()));
        blocks.push(Block::text(Style::Small, self.unsigned_note()));
        blocks.extend(signatory.map(sign_block));
        Paper {
            title: tr!("Transcript of {trainee}", trainee = self.trainee.0),
            language: words::current().code(),
            made_at: self.made_at,
            logo,
            blocks,
            attachment: None,
        }
    }
}

/// An outcome with a level in force.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TranscriptOutcome {
    /// Code and title.
    pub title: String,
    /// Number and name of the level.
    pub level: String,
    /// Name of who decided.
    pub by: String,
    /// Time of the decision.
    pub at: OffsetDateTime,
}

impl TranscriptOutcome {
    fn cells(&self) -> Vec<String> {
        vec![self.title.clone(), self.level.clone(), self.decided_words()]
    }

    fn decided_words(&self) -> String {
        tr!("{name}, {date}", name = self.by, date = format::format_date(self.at))
    }
}

/// A course.
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptCourse {
    /// Its title.
    pub title: String,
    /// The mastery rule as text.
    pub rule: String,
    /// Since when it is mastered.
    pub mastered_on: Option<OffsetDateTime>,
    /// SHA-256 of the revision to which this refers.
    pub sha256: String,
    /// Its exercises.
    pub lines: Vec<TranscriptLine>,
}

/// An exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptLine {
    /// Its title.
    pub title: String,
    /// When it was mastered, even if mastery has been lost since.
    pub mastered_on: Option<OffsetDateTime>,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Number of passed attempts.
    pub passes: usize,
    /// Number of scored attempts.
    pub attempts: usize,
}

impl TranscriptCourse {
    /// Summarizes a trainee's progress in a course, whose current revision has this SHA-256.
    #[must_use]
    pub fn new(title: &str, course: &Course, sha256: &str, progress: &Progress) -> Self {
        let lines = course.steps.iter().zip(&progress.steps).map(|(step, done)| TranscriptLine {
            title: step.title.clone(),
            mastered_on: match done.state {
                StepState::Mastered { on } | StepState::Regressing { on, .. } => Some(on),
                StepState::Open { .. } | StepState::Locked { .. } => None,
            },
            best: done.attempts.iter().map(|attempt| attempt.score).reduce(f64::max),
            passes: done.attempts.iter().filter(|attempt| attempt.passed).count(),
            attempts: done.attempts.len(),
        });
        Self {
            title: title.to_owned(),
            rule: rule_in_words(&course.rule),
            mastered_on: progress.completed_on(),
            sha256: progress.earlier_in(course).map_or(sha256, |(earlier, _)| &earlier.sha256).to_owned(),
            lines: lines.collect(),
        }
    }

    /// Returns the date of mastery as a sentence.
    fn mastered_words(&self) -> Option<String> {
        let revision = format::shorten_hash(&self.sha256);
        self.mastered_on.map(|on| {
            tr!(
                "Course mastered on {date}, by its revision {revision}.",
                date = format::format_date(on),
                revision = revision
            )
        })
    }

    fn figures(&self) -> String {
        let mastered = trn!(
            "{mastered} of {n} exercise mastered.",
            "{mastered} of {n} exercises mastered.",
            self.lines.len(),
            mastered = self.mastered()
        );
        format!("{mastered} {}", tr!("An exercise is {rule}.", rule = self.rule))
    }

    fn blocks(&self) -> Vec<Block> {
        let mut blocks = vec![Block::Heading(2, self.title.clone())];
        blocks.extend(self.mastered_words().map(|words| Block::text(Style::Strong, words)));
        blocks.push(Block::text(Style::Body, self.figures()));
        let column = |title: &str, percent| PaperColumn { title: title.to_owned(), percent };
        let columns = vec![
            column(tr!("Exercise"), 46),
            column(tr!("Mastered on"), 21),
            column(tr!("Best score"), 20),
            column(tr!("Passed"), 13),
        ];
        let rows = self.lines.iter().map(TranscriptLine::cells).collect();
        blocks.push(Block::Table(PaperTable { columns, rows }));
        blocks
    }

    fn mastered(&self) -> usize {
        self.lines.iter().filter(|line| line.mastered_on.is_some()).count()
    }
}

impl TranscriptLine {
    fn cells(&self) -> Vec<String> {
        vec![self.title.clone(), self.mastered_words(), self.best_words(), self.passed_words()]
    }

    fn mastered_words(&self) -> String {
        self.mastered_on.map_or_else(|| "–".to_owned(), format::format_date)
    }

    fn best_words(&self) -> String {
        self.best.map_or_else(|| "–".to_owned(), format::format_points)
    }

    fn passed_words(&self) -> String {
        tr!("{passes} of {attempts}", passes = self.passes, attempts = self.attempts)
    }
}

#[cfg(test)]
mod tests {
    //! The page must agree with the trainee's own page.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn every_exercise_has_its_state_and_its_best() {
        let (course, progress) = (samples::course(), samples::progress());
        let told = TranscriptCourse::new("Lower back", &course, "5f1c0a9be2d45f1c0a9b", &progress);
        assert_eq!(told.lines.len(), course.steps.len());
        assert_eq!(told.mastered(), progress.mastered());
        let page = TranscriptPage {
            shell: samples::shell(Role::Trainee),
            trainee: ("Ada <Okafor>".to_owned(), "/".to_owned()),
            pdf_href: "/trainees/1/transcript.pdf".to_owned(),
            school: "Nordklinik".to_owned(),
            registrar_id: Some("4711".to_owned()),
            courses: vec![told],
            outcomes: vec![TranscriptOutcome {
                title: "EPA 3 Lumbar puncture".to_owned(),
                level: "4 – Acts without supervision".to_owned(),
                by: "Dr Ek".to_owned(),
                at: samples::NOW,
            }],
            made_at: samples::NOW,
        };
        let html = samples::keep_page("transcript", &page);
        let dean = Signatory { name: "Prof. Ada".to_owned(), function: "Dean".to_owned() };
        let paper = page.paper(None, Some(&dean));
        let names_of_facts =
            ["Name", "School", "Transcript as PDF", "Ada <Okafor>", "Exercises in order", "Levels in force"];
        paper
            .assert_says_the_same(&html, &[&names_of_facts[..], &["As of", "Registrar", "Prof. Ada", "Dean"]].concat());
        assert!(paper.to_pdf().is_ok() && paper.texts().contains(&"Ada <Okafor>"));
        for wanted in ["Ada &#60;Okafor&#62;", "4711", "Nordklinik", "Lower back", "An exercise is mastered"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
