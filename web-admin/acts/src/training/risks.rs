//! People at risk: who they are, the school's rules, and the support records.

use std::ops::RangeInclusive;

use model::ids::PersonId;
use model::letters::notice::NoticeKind;
use model::training::risk::{PersonAtRisk, RiskRules, RuleSetting, TraineeAddress, WEIGHTS, rank_people};
use model::training::support_note::{MOST_PEOPLE, SupportKind, SupportText};
use model::{CurrentPerson, Moment, PersonKey};
use serde_json::{Map, json};
use store::Connection;
use store::audit::AuditEntry;
use store::letters::notices::NewNotice;
use store::letters::{mails, notices};
use store::training::risks::RiskScope;
use store::training::support_notes::NewSupportNote;
use store::training::{risks, support_notes};

use crate::error::Error;
use crate::service::Service;

/// Returns the trainees of a scope who are at risk by the school's rules, ranked.
pub async fn list_people_at_risk(
    state: &Service,
    by: &CurrentPerson,
    scope: RiskScope,
) -> Result<Vec<PersonAtRisk>, Error> {
    let rules = risks::find_rules(state.db.reader(), by.school_id).await?;
    let now = state.clock.now();
    let found = risks::list_concerns(state.db.reader(), by.school_id, scope, &rules, now).await?;
    Ok(rank_people(&rules, found))
}

/// Changes the rules of a school.
///
/// # Errors
/// [`Error::Unprocessable`] if a number or weight is outside its limits.
pub async fn set_rules(state: &Service, by: &CurrentPerson, rules: [RuleSetting; 4]) -> Result<(), Error> {
    for of in rules {
        check_number(of.number, of.rule.limits())?;
        check_number(of.weight, WEIGHTS)?;
    }
    let told: Map<_, _> = rules.iter().map(|of| (of.rule.name().to_owned(), describe_setting(*of).into())).collect();
    let mut tx = state.db.write().await?;
    risks::put_rules(&mut tx, by.school_id, &RiskRules::of(&rules)).await?;
    let entry = AuditEntry::by(by, "school.risk_rules_set", by.school_id).with(told.into());
    entry.append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

fn describe_setting(of: RuleSetting) -> String {
    if of.applies { format!("{}, weight {}", of.number, of.weight) } else { "off".to_owned() }
}

fn check_number(number: u32, limits: RangeInclusive<u32>) -> Result<(), Error> {
    match limits.contains(&number) {
        true => Ok(()),
        false => Err(Error::Unprocessable(refuse_number(&number.to_string(), &limits))),
    }
}

/// Returns the error message for a number outside its limits.
#[must_use]
pub fn refuse_number(typed: &str, limits: &RangeInclusive<u32>) -> String {
    let (least, most) = (limits.start(), limits.end());
    tr!(
        "“{typed}” is not allowed; enter a whole number from {least} to {most}",
        typed = typed,
        least = least,
        most = most
    )
}

/// Result of a record for several people.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SupportOutcome {
    /// Number of people.
    pub people: usize,
    /// Number of people who are mailed.
    pub mailed: usize,
}

/// Adds a support record for people, and sends a message to them: as a notice, and as a mail to
/// those who have an address.
///
/// # Errors
/// [`Error::Unprocessable`] for nobody or too many people, [`Error::NotFound`] if the author does not
/// teach one of them.
pub async fn record_support(
    state: &Service,
    by: &CurrentPerson,
    people: &[PersonId],
    text: &SupportText,
) -> Result<SupportOutcome, Error> {
    if people.is_empty() || people.len() > MOST_PEOPLE {
        return Err(Error::Unprocessable(tr!(
            "{count} people are selected; allowed: 1 to {most}",
            count = people.len(),
            most = MOST_PEOPLE
        )));
    }
    let mut trainees = Vec::with_capacity(people.len());
    for id in people {
        let found = support_notes::find_supported_trainee(state.db.reader(), by, *id).await?;
        trainees.push(found.ok_or(Error::NotFound)?);
    }
    let (now, mut tx) = (state.clock.now(), state.db.write().await?);
    let mut outcome = SupportOutcome { people: trainees.len(), mailed: 0 };
    for trainee in &trainees {
        outcome.mailed += usize::from(record_for(&mut tx, by, trainee, text, now).await?);
    }
    tx.commit().await?;
    state.mails.notify_one();
    Ok(outcome)
}

/// Records a text for one trainee. Returns whether it is mailed.
async fn record_for(
    tx: &mut Connection,
    by: &CurrentPerson,
    trainee: &TraineeAddress,
    text: &SupportText,
    now: Moment,
) -> Result<bool, Error> {
    let is_message = text.kind == SupportKind::Message;
    let mailed = is_message && trainee.has_address;
    let new = NewSupportNote { person_id: trainee.id, text, mailed };
    let note = support_notes::add_support_note(tx, by, new, now).await?;
    let whom = PersonKey { school_id: by.school_id, person_id: trainee.id };
    if is_message {
        let notice = NewNotice {
            whom,
            kind: NoticeKind::Message,
            by: by.id,
            session_id: None,
            comment_id: None,
            assignment_id: None,
            round_id: None,
            note_id: Some(note),
        };
        notices::add_notice(tx, notice, now).await?;
    }
    if mailed {
        mails::queue_message(tx, whom, note, now).await?;
        notices::mark_message_mailed(tx, whom, note, now).await?;
    }
    let told = json!({ "kind": text.kind.name(), "mailed": mailed });
    AuditEntry::by(by, "support.recorded", trainee.id).with(told).append(tx, now).await?;
    Ok(mailed)
}
