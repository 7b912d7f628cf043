//! Reminders: all that are due for a person in one letter, at most one letter a day.

use acts::error::Error;
use acts::letters::mailing;
use acts::training::assignments;
use acts::training::calendar_feeds::{self, DueItem, DueKind};
use model::PersonKey;
use model::letters::mail::Mail;
use model::training::assignment::{AssignmentStage, AssignmentStanding};
use pages::letters::{self, RemindedItem, ReminderRequest};
use platform::mailer::Letter;
use routes_base::AppState;
use store::letters::mails;
use store::scoring::ratings;
use store::studies::{self, Study};
use words::Language;

use super::until_database_answers;

/// Progress with something that has neither prerequisites nor a limit.
const UNLIMITED: AssignmentStage = AssignmentStage::Open { left: None, mastered: None };
/// Interval between two letters with reminders to one person, in s.
const INTERVAL_S: i64 = 24 * 3600;

/// Sends a letter with all reminders of a person that are due, or postpones them if one was sent
/// within a day. What was done meanwhile is left out.
pub(super) async fn deliver_reminders(state: &AppState, one: &Mail) -> Result<(), Error> {
    let (reader, now) = (state.db.reader(), state.clock.now());
    let whom = PersonKey { school_id: one.school_id, person_id: one.person_id };
    if let Some(next) = mails::find_last_reminder(reader, whom).await?.map(|last| last.plus_s(INTERVAL_S))
        && next > now
    {
        return mailing::postpone_reminders(state, whom, next).await;
    }
    let language = one.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    words::speaking(language, send_reminders(state, whom)).await
}

async fn send_reminders(state: &AppState, whom: PersonKey) -> Result<(), Error> {
    let due = mails::list_due_reminders(state.db.reader(), whom, state.clock.now()).await?;
    let open = OpenItems::read(state, whom).await?;
    let _in_hand = state.letter_in_hand.lock().await;
    let (mut claimed, mut items) = (Vec::new(), Vec::new());
    for mail in due {
        match open.find(state, whom, &mail).await? {
            None => mailing::withdraw_mail(state, &mail).await?,
            Some(item) if mailing::claim_mail(state, &mail).await? => {
                claimed.push(mail);
                items.push(item);
            }
            // Another replica sends it.
            Some(_) => {}
        }
    }
    let Some(first) = claimed.first() else { return Ok(()) };
    let (subject, body) = letters::write_reminder(first, &items);
    let letter = Letter { id: first.id, name: first.name.clone(), email: first.email.clone(), subject, body };
    let sent = state.mailer.send(letter, state.clock.now()).await.map_err(|error| format!("{error:#}"));
    for mail in &claimed {
        until_database_answers(state, || mailing::note_mail(state, mail, &sent)).await?;
    }
    Ok(())
}

/// What a person still has to do.
struct OpenItems {
    address: String,
    standings: Vec<AssignmentStanding>,
    due: Vec<DueItem>,
    invitations: Vec<Study>,
}

impl OpenItems {
    async fn read(state: &AppState, whom: PersonKey) -> Result<Self, Error> {
        Ok(Self {
            address: state.config.address(),
            standings: assignments::standings(state, whom.school_id, whom.person_id).await?,
            due: calendar_feeds::list_due_items(state, whom).await?,
            invitations: studies::list_study_requests(state.db.reader(), whom).await?,
        })
    }

    /// Returns the item of a reminder, unless it is done.
    async fn find(&self, state: &AppState, whom: PersonKey, mail: &Mail) -> Result<Option<RemindedItem>, Error> {
        let Some(id) = mail.assignment_id else { return Ok(None) };
        if let Some(item) = self.due.iter().find(|item| item.id == id.to_string()) {
            return Ok(Some(self.describe(item, mail)));
        }
        if let Some(study) = self.invitations.iter().find(|study| id == study.id.into()) {
            let (title, link) = (study.title.clone(), format!("{}/account/studies", self.address));
            return Ok(Some(RemindedItem {
                title,
                request: ReminderRequest::AnswerInvitation,
                stage: UNLIMITED,
                link,
            }));
        }
        let round = ratings::find_open_round(state.db.reader(), whom, id).await?;
        let link = format!("{}/ratings/{id}", self.address);
        Ok(round.map(|title| RemindedItem { title, request: ReminderRequest::Rate, stage: UNLIMITED, link }))
    }

    fn describe(&self, item: &DueItem, mail: &Mail) -> RemindedItem {
        let standing = self.standings.iter().find(|standing| standing.assigned.id.to_string() == item.id);
        let zone = standing.map_or(&mail.time_zone, |standing| &standing.assigned.time_zone);
        let path = match item.kind {
            DueKind::Assignment => "assignments".to_owned(),
            DueKind::Marking => format!("segments/{}", item.id),
            DueKind::Survey => format!("surveys/{}", item.id),
        };
        RemindedItem {
            title: item.title.clone(),
            request: ReminderRequest::Finish { due_at: item.due_at, time_zone: zone.clone() },
            stage: standing.map_or(UNLIMITED, |standing| standing.stage.clone()),
            link: format!("{}/{path}", self.address),
        }
    }
}
