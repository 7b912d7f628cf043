//! Validation studies: the list, a new one, one of them with its participants, and a guest's code.

pub mod results;

use askama::Template;
use askama_web::WebTemplate;
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::{Shell, StatusWord, format};

/// `/studies`.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/list.html")]
pub struct StudiesPage {
    /// Frame.
    pub shell: Shell,
    /// Studies that the visitor may see, newest first.
    pub studies: Vec<StudyRow>,
}

/// A study in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRow {
    /// Its page.
    pub href: String,
    /// Its title.
    pub title: String,
    /// Who runs it.
    pub owner: String,
    /// It has not ended.
    pub open: bool,
    /// The participants are a program's.
    pub generated: bool,
    /// When it was made.
    pub created_at: OffsetDateTime,
}

/// `/account/studies`: the studies that the visitor is asked for, and those that they take part in.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/own.html")]
pub struct OwnStudiesPage {
    /// Frame.
    pub shell: Shell,
    /// Those that they are asked for.
    pub asked: Vec<OwnStudyCard>,
    /// Those that they take part in.
    pub joined: Vec<OwnStudyCard>,
}

/// A study as those see it who take part or are asked to.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnStudyCard {
    /// Where the answer goes.
    pub href: String,
    /// Title.
    pub title: String,
    /// Who runs it.
    pub owner: String,
    /// Attempts asked at each of its exercises.
    pub attempts: u32,
    /// What participants agree to.
    pub consent: String,
    /// Who answers for the data, whom to ask, and how long they are kept.
    pub terms: Vec<(&'static str, String)>,
    /// The revision of these terms.
    pub revision: String,
}

/// The form of a new study.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/new.html")]
pub struct NewStudyPage {
    /// Frame.
    pub shell: Shell,
    /// Exercises that the school gives: id and title.
    pub exercises: Vec<(String, String)>,
    /// Instruments: id and title.
    pub instruments: Vec<(String, String)>,
    /// What is typed.
    pub form: FilledForm<NewStudyForm>,
}

/// The fields of a new study.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewStudyForm {
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// Ids of exercises.
    #[serde(rename = "exercise")]
    pub exercises: Vec<String>,
    /// Attempts of each participant at each exercise.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub attempts: String,
    /// Groups, one a line.
    pub groups: String,
    /// What is asked of each participant, one a line.
    pub questions: String,
    /// Ids of instruments asked after each attempt.
    pub after: Vec<String>,
    /// Ids of instruments asked after the last.
    pub end: Vec<String>,
    /// What participants agree to.
    pub consent: String,
    /// Who answers for the data.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub controller: String,
    /// Whom to ask.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub contact: String,
    /// How long data are kept, in months.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub kept: String,
}

/// A study that is to be changed.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/change.html")]
pub struct StudyChangePage {
    /// Frame.
    pub shell: Shell,
    /// The study's page.
    pub href: String,
    /// Its title.
    pub title: String,
    /// Somebody takes part: what they agreed to stays.
    pub is_agreed: bool,
    /// Months for which data are kept as it stands.
    pub most_kept: u32,
    /// What participants agree to.
    pub consent: String,
    /// What is typed.
    pub form: FilledForm<NewStudyForm>,
}

/// What was just done to a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StudyDone {
    /// Changed.
    Changed,
    /// Ended.
    Ended,
    /// Opened again.
    Opened,
    /// Somebody was added.
    Added,
    /// Somebody has left.
    Left,
}

/// When the data of a study go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyDataEnd {
    /// Not soon.
    Far,
    /// In so many days.
    InDays(i64),
    /// They are gone since.
    Erased(OffsetDateTime),
}

/// A study, with whoever takes part.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/one.html")]
pub struct StudyPage {
    /// Frame.
    pub shell: Shell,
    /// Title.
    pub title: String,
    /// Its address.
    pub href: String,
    /// It has not ended.
    pub open: bool,
    /// When its data go.
    pub ends: StudyDataEnd,
    /// What was just done.
    pub done: Option<StudyDone>,
    /// The participants are a program's.
    pub generated: bool,
    /// What is known of it: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// What participants agree to.
    pub consent: String,
    /// Names of the groups.
    pub groups: Vec<String>,
    /// What is asked of each participant.
    pub questions: Vec<String>,
    /// Attempts asked of each participant in all.
    pub asked: u32,
    /// Whoever takes part, or has left.
    pub participants: Vec<ParticipantRow>,
    /// Somebody who is to be added.
    pub form: FilledForm<ParticipantForm>,
}

/// Somebody who takes part.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticipantRow {
    /// Their address below the study's.
    pub href: String,
    /// What files say of them.
    pub pseudonym: String,
    /// The name of somebody of the school.
    pub name: Option<String>,
    /// Their group.
    pub group: String,
    /// What they told, in short.
    pub facts: String,
    /// Attempts made.
    pub attempts: u32,
    /// Answers sent.
    pub answers: u32,
    /// When they agreed; absent while they are asked.
    pub agreed_at: Option<OffsetDateTime>,
    /// When they left or declined.
    pub withdrawn_at: Option<OffsetDateTime>,
    /// A code that was not used yet.
    pub has_code: bool,
}

/// The fields of somebody who is to take part.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct ParticipantForm {
    /// The address of somebody of the school; empty for a guest.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub email: String,
    /// The place of their group.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub group: String,
    /// What they told, in the order of the questions.
    #[serde(rename = "fact")]
    pub facts: Vec<String>,
    /// A guest has read what they agree to, and agrees.
    #[serde(deserialize_with = "read_ticked_box")]
    pub consent: bool,
}

/// A guest's code, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/code.html")]
pub struct GuestCodePage {
    /// Frame.
    pub shell: Shell,
    /// The study's title, and its page.
    pub study: (String, String),
    /// Who, by the pseudonym alone.
    pub pseudonym: String,
    /// The code.
    pub code: String,
    /// Titles of the exercises.
    pub exercises: Vec<String>,
    /// Attempts at each.
    pub attempts: usize,
    /// What they have agreed to.
    pub consent: String,
    /// Who answers for the data, whom to ask, and how long they are kept.
    pub terms: Vec<(&'static str, String)>,
}

/// How long data are kept, in words.
#[must_use]
pub fn kept_in_words(months: usize) -> String {
    trn!("{n} month after the study has ended", "{n} months after the study has ended", months)
}

impl StudyPage {
    fn is_erased(&self) -> bool {
        matches!(self.ends, StudyDataEnd::Erased(_))
    }

    fn is_group(&self, at: &usize) -> bool {
        self.form.typed.group == at.to_string()
    }

    fn fact(&self, at: &usize) -> &str {
        self.form.typed.facts.get(*at).map_or("", String::as_str)
    }

    /// Those who have agreed and not left.
    fn taking_part(&self) -> usize {
        self.participants.iter().filter(|row| row.agreed_at.is_some() && row.withdrawn_at.is_none()).count()
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a code is shown without what it is for, or somebody who has left can be given another.

    use model::Role;

    use super::*;
    use crate::samples;

    fn row(name: Option<&str>, withdrawn_at: Option<OffsetDateTime>) -> ParticipantRow {
        ParticipantRow {
            href: "/studies/1/participants/2".to_owned(),
            pseudonym: "g-1".to_owned(),
            name: name.map(str::to_owned),
            group: "Experts".to_owned(),
            facts: "surgeon, 12".to_owned(),
            attempts: 2,
            answers: 1,
            agreed_at: withdrawn_at.is_none().then_some(samples::NOW),
            withdrawn_at,
            has_code: name.is_none(),
        }
    }

    fn study(participants: Vec<ParticipantRow>, open: bool) -> StudyPage {
        StudyPage {
            shell: samples::shell(Role::Instructor),
            title: "Is it like a patient?".to_owned(),
            href: "/studies/1".to_owned(),
            open,
            ends: StudyDataEnd::InDays(3),
            done: Some(StudyDone::Changed),
            generated: true,
            facts: vec![("Contact", "ethics@example.org".to_owned())],
            consent: "I take part.\nI can leave.".to_owned(),
            groups: vec!["Novices".to_owned(), "Experts".to_owned()],
            questions: vec!["Role".to_owned()],
            asked: 3,
            participants,
            form: FilledForm::refused(ParticipantForm::default(), "no consent".to_owned()),
        }
    }

    #[test]
    fn a_study_shows_who_takes_part_and_how_far_they_are() {
        let all = vec![row(None, None), row(Some("Ana Ek"), None), row(None, Some(samples::NOW))];
        let html = samples::keep_page("study", &study(all, true));
        assert!(html.contains("2 of 3") && html.contains("no consent"), "{html}");
        assert_eq!(html.matches("/participants/2/withdraw").count(), 2, "who has left cannot leave: {html}");
        let html = samples::keep_page("study-ended", &study(vec![], false));
        assert!(!html.contains("Add a participant") && html.contains("erased in 3 days"), "{html}");
        let erased = StudyPage { ends: StudyDataEnd::Erased(samples::NOW), ..study(vec![], false) };
        let html = samples::keep_page("study-erased", &erased);
        assert!(!html.contains("/change") && !html.contains("/close"), "{html}");
    }

    #[test]
    fn who_is_asked_has_not_agreed_and_gets_no_links() {
        let asked = ParticipantRow { agreed_at: None, ..row(Some("Ana Ek"), None) };
        let html = samples::keep_page("study-asked", &study(vec![asked], true));
        assert!(html.contains("0 participants") && html.contains("asked"), "{html}");
        assert!(!html.contains("/participants/2/links"), "{html}");
        let guest = samples::keep_page("study-guest", &study(vec![row(None, None)], true));
        assert!(guest.contains("/participants/2/links"), "{guest}");
    }

    #[test]
    fn somebody_answers_for_themselves_to_the_terms_that_are_shown() {
        let card = OwnStudyCard {
            href: "/account/studies/1".to_owned(),
            title: "Is it like a patient?".to_owned(),
            owner: "Ana Ek".to_owned(),
            attempts: 3,
            consent: "I take part.\nI can leave.".to_owned(),
            terms: vec![("Contact", "ethics@example.org".to_owned())],
            revision: "abc".to_owned(),
        };
        let shell = samples::shell(Role::Trainee);
        let page = OwnStudiesPage { shell: shell.clone(), asked: vec![card.clone()], joined: vec![card] };
        let html = samples::keep_page("own-studies", &page);
        assert!(html.contains("value=\"abc\"") && html.contains("I can leave.") && html.contains("ethics@"), "{html}");
        assert_eq!(html.matches("/account/studies/1/leave").count(), 2, "declined, or left: {html}");
        assert_eq!(html.matches("/account/studies/1/join").count(), 1, "{html}");
        samples::keep_page("own-studies-none", &OwnStudiesPage { shell, asked: vec![], joined: vec![] });
    }

    #[test]
    fn what_somebody_has_agreed_to_has_no_field() {
        for is_agreed in [true, false] {
            let page = StudyChangePage {
                shell: samples::shell(Role::Instructor),
                href: "/studies/1".to_owned(),
                title: "Is it like a patient?".to_owned(),
                is_agreed,
                most_kept: 12,
                consent: "I take part.".to_owned(),
                form: FilledForm::refused(NewStudyForm::default(), "title: 0 characters".to_owned()),
            };
            let html = samples::keep_page(if is_agreed { "study-change-agreed" } else { "study-change" }, &page);
            assert_eq!(html.contains("name=\"consent\""), !is_agreed, "{html}");
        }
    }

    #[test]
    fn a_new_study_keeps_what_was_typed_and_a_code_says_what_it_is_for() {
        let typed =
            NewStudyForm { exercises: vec!["a".to_owned()], end: vec!["tlx".to_owned()], ..NewStudyForm::default() };
        let page = NewStudyPage {
            shell: samples::shell(Role::Instructor),
            exercises: vec![("a".to_owned(), "A".to_owned()), ("b".to_owned(), "B".to_owned())],
            instruments: vec![("tlx".to_owned(), "Workload".to_owned())],
            form: FilledForm::refused(typed, "title: 0 characters".to_owned()),
        };
        let html = samples::keep_page("study-new", &page);
        assert!(html.matches("checked").count() == 2 && html.contains("0 characters"), "{html}");
        let rows = vec![StudyRow {
            href: "/studies/1".to_owned(),
            title: "Is it like a patient?".to_owned(),
            owner: "Ana Ek".to_owned(),
            open: true,
            generated: true,
            created_at: samples::NOW,
        }];
        let shell = samples::shell(Role::Instructor);
        samples::keep_page("studies", &StudiesPage { shell: shell.clone(), studies: rows });
        samples::keep_page("studies-none", &StudiesPage { shell: shell.clone(), studies: vec![] });
        let page = GuestCodePage {
            shell,
            study: ("Is it like a patient?".to_owned(), "/studies/1".to_owned()),
            pseudonym: "g-1".to_owned(),
            code: "ABC-DEF".to_owned(),
            exercises: vec!["Feel the layers".to_owned()],
            attempts: 3,
            consent: "I take part.".to_owned(),
            terms: vec![("Contact", "ethics@example.org".to_owned())],
        };
        let html = samples::keep_page("study-code", &page);
        assert!(html.contains("ABC-DEF") && html.contains("Feel the layers") && html.contains("ethics@"), "{html}");
    }
}
