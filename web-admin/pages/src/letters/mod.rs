//! Text of emails. Templates render the subject in the first line, then an empty line, then the
//! body.

pub mod news;

use askama::Template;
use model::Moment;
use model::letters::mail::{Mail, RetentionLetter, SurveyLetter};
use model::limits::{INVITATION_LIFETIME_S, RESET_LIFETIME_S};
use model::single_line_text::on_one_line;
use model::surveys::Survey;
use model::training::assignment::AssignmentStage;
use model::training::due::{Local, local};
use model::training::support_note::SupportNote;

use crate::format;
use crate::letters::news::NewsItem;

const DAY_S: i64 = 86_400;

#[derive(Template)]
#[template(path = "letters/invitation.txt")]
struct Invitation<'a> {
    name: &'a str,
    school: &'a str,
    link: &'a str,
    days: i64,
}

#[derive(Template)]
#[template(path = "letters/test_letter.txt")]
struct TestLetter<'a> {
    name: &'a str,
    school: &'a str,
}

#[derive(Template)]
#[template(path = "letters/reset.txt")]
struct Reset<'a> {
    name: &'a str,
    school: &'a str,
    link: &'a str,
    days: i64,
}

#[derive(Template)]
#[template(path = "letters/second_factor_off.txt")]
struct SecondFactorOff<'a> {
    name: &'a str,
    school: &'a str,
    link: &'a str,
}

#[derive(Template)]
#[template(path = "letters/identity_joined.txt")]
struct IdentityJoined<'a> {
    name: &'a str,
    school: &'a str,
    link: &'a str,
}

#[derive(Template)]
#[template(path = "letters/message.txt")]
struct Message<'a> {
    name: &'a str,
    school: &'a str,
    subject: String,
    note: &'a SupportNote,
}

/// Returns subject and body of a teacher's message.
#[must_use]
pub fn write_message(mail: &Mail, note: &SupportNote) -> (String, String) {
    let subject = on_one_line(note.subject.as_deref().unwrap_or_default());
    subject_and_body(&Message { name: &mail.name, school: &mail.school, subject, note })
}

#[derive(Template)]
#[template(path = "letters/reminder.txt")]
struct Reminder<'a> {
    subject: String,
    name: &'a str,
    items: Vec<ReminderLine<'a>>,
}

/// A line of a reminder.
struct ReminderLine<'a> {
    title: String,
    asks: ReminderAsks,
    stage: &'a AssignmentStage,
    link: &'a str,
}

/// The request of a line.
enum ReminderAsks {
    Finish(Local),
    Rate,
    AnswerInvitation,
}

impl<'a> ReminderLine<'a> {
    fn of(item: &'a RemindedItem) -> Self {
        Self {
            title: on_one_line(&item.title),
            asks: match &item.request {
                ReminderRequest::Finish { due_at, time_zone } => ReminderAsks::Finish(local(*due_at, time_zone)),
                ReminderRequest::Rate => ReminderAsks::Rate,
                ReminderRequest::AnswerInvitation => ReminderAsks::AnswerInvitation,
            },
            stage: &item.stage,
            link: &item.link,
        }
    }
}

/// The way letters are delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MailWay {
    /// Sent through a mail server.
    Server,
    /// Written to a folder on the server, and not delivered.
    Folder,
}

/// Something of which a person is reminded.
#[derive(Clone, Debug)]
pub struct RemindedItem {
    /// Title.
    pub title: String,
    /// The request.
    pub request: ReminderRequest,
    /// Progress of the recipient.
    pub stage: AssignmentStage,
    /// Address of its page.
    pub link: String,
}

/// The request of a reminder.
#[derive(Clone, Debug)]
pub enum ReminderRequest {
    /// Finish it before a date.
    Finish {
        /// Due time.
        due_at: Moment,
        /// Time zone of the due time.
        time_zone: String,
    },
    /// Rate attempts.
    Rate,
    /// Join a study or decline.
    AnswerInvitation,
}

/// Returns subject and body of a letter with reminders.
#[must_use]
pub fn write_reminder(mail: &Mail, items: &[RemindedItem]) -> (String, String) {
    let items: Vec<_> = items.iter().map(ReminderLine::of).collect();
    let subject = match &items[..] {
        [ReminderLine { title, asks, .. }] => match asks {
            ReminderAsks::Finish(due) => tr!("Due {date}: {title}", date = due.words, title = title),
            ReminderAsks::Rate => tr!("Waiting for your ratings: {title}", title = title),
            ReminderAsks::AnswerInvitation => tr!("Waiting for your answer: {title}", title = title),
        },
        several => trn!("{n} thing to do", "{n} things to do", several.len()),
    };
    subject_and_body(&Reminder { subject, name: &mail.name, items })
}

#[derive(Template)]
#[template(path = "letters/news.txt")]
struct NewsLetter<'a> {
    name: &'a str,
    school: &'a str,
    address: &'a str,
    home: String,
    account: String,
    items: &'a [NewsItem],
}

/// Returns subject and body of an email with news; `address` is the address of the service.
#[must_use]
pub fn write_news_letter(mail: &Mail, items: &[NewsItem], address: &str) -> (String, String) {
    let (home, account) = (format!("{address}/"), format!("{address}/account"));
    subject_and_body(&NewsLetter { name: &mail.name, school: &mail.school, address, home, account, items })
}

#[derive(Template)]
#[template(path = "letters/survey.txt")]
struct SurveyInvitation<'a> {
    letter: &'a SurveyLetter,
    title: String,
    link: &'a str,
    minutes: f64,
    until: String,
}

/// Returns subject and body of an email with a survey link: `minutes` is the duration of the survey
/// in min, `until` the expiry of the link.
#[must_use]
pub fn write_survey_letter(
    letter: &SurveyLetter,
    survey: &Survey,
    link: &str,
    minutes: f64,
    until: Moment,
) -> (String, String) {
    subject_and_body(&SurveyInvitation {
        letter,
        title: on_one_line(&survey.title),
        link,
        minutes,
        until: format::format_date(until.to_utc()),
    })
}

/// Returns subject and body of an invitation.
#[must_use]
pub fn write_invitation(mail: &Mail, link: &str) -> (String, String) {
    subject_and_body(&Invitation { name: &mail.name, school: &mail.school, link, days: INVITATION_LIFETIME_S / DAY_S })
}

/// Returns subject and body of an email with a password reset link.
#[must_use]
pub fn write_reset_letter(mail: &Mail, link: &str) -> (String, String) {
    subject_and_body(&Reset { name: &mail.name, school: &mail.school, link, days: RESET_LIFETIME_S / DAY_S })
}

/// Returns subject and body of a test email, requested by an administrator.
#[must_use]
pub fn write_test_letter(name: &str, school: &str) -> (String, String) {
    subject_and_body(&TestLetter { name, school })
}

/// Returns subject and body of an email that reports that a second factor was turned off; `link`
/// leads to the page that sets one up.
#[must_use]
pub fn write_factor_off_letter(mail: &Mail, link: &str) -> (String, String) {
    subject_and_body(&SecondFactorOff { name: &mail.name, school: &mail.school, link })
}

/// Returns subject and body of an email that reports that an account of another system was joined;
/// `link` leads to the page that lists and removes such accounts.
#[must_use]
pub fn write_identity_letter(mail: &Mail, link: &str) -> (String, String) {
    subject_and_body(&IdentityJoined { name: &mail.name, school: &mail.school, link })
}

#[derive(Template)]
#[template(path = "letters/retention.txt")]
struct Retention<'a> {
    letter: &'a RetentionLetter,
    months: u32,
    link: &'a str,
}

/// Returns subject and body of a warning to a person who will be erased after so many months
/// without activity.
#[must_use]
pub fn write_retention_letter(letter: &RetentionLetter, months: u32, link: &str) -> (String, String) {
    subject_and_body(&Retention { letter, months, link })
}

fn subject_and_body(letter: &impl Template) -> (String, String) {
    // Rendering these templates into a `String` cannot fail.
    let text = letter.render().unwrap_or_default();
    let (subject, body) = text.split_once("\n\n").unwrap_or((&text, ""));
    (subject.to_owned(), body.to_owned())
}

#[cfg(test)]
mod tests {
    use model::ids::{LetterId, PersonId, SchoolId};
    use model::letters::mail::MailKind;

    use super::*;

    #[test]
    fn a_letter_has_a_subject_a_name_and_the_whole_link() {
        let mail = Mail {
            id: LetterId::nil(),
            school_id: SchoolId::nil(),
            person_id: PersonId::nil(),
            kind: MailKind::Invitation,
            assignment_id: None,
            note_id: None,
            tries: 0,
            name: "Ana <Ek>".to_owned(),
            email: "ana@example.org".to_owned(),
            school: "North & South".to_owned(),
            time_zone: "UTC".to_owned(),
            language: None,
            enabled: true,
        };
        let link = "https://a.example/join/1";
        for (subject, body) in
            [write_invitation(&mail, link), write_reset_letter(&mail, link), write_factor_off_letter(&mail, link)]
        {
            assert!(subject.ends_with("at North & South") && !subject.contains('\n'), "{subject}");
            assert!(body.starts_with("Dear Ana <Ek>,") && body.contains("\nhttps://a.example/join/1\n"), "{body}");
        }
    }
}
