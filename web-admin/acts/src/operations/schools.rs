//! Settings of a school. Each change is made by an administrator and recorded in the audit log.

use data_encoding::HEXLOWER;
use model::training::due;
use model::training::due::DueRefused;
use model::training::signatory::Signatory;
use model::{CurrentPerson, FactorRule, Needed, single_line_text};
use platform::mailer::Letter;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use store::Write;
use store::audit::AuditEntry;
use store::auth::second_factors;
use store::operations::logos::SchoolLogo;
use store::operations::schools::SchoolSettings;
use store::operations::{logos, origins, schools};
use store::privacy::retention;
use store::privacy::retention::Settings;

use crate::authoring::image_copies::copy_picture;
use crate::error::Error;
use crate::letters::mailing::LetterResult;
use crate::recordings::quotas::ensure_database_room;
use crate::service::Service;

/// Records a change in the audit log and commits the transaction.
async fn settle(
    service: &Service,
    mut tx: Write,
    by: &CurrentPerson,
    action: &str,
    settled: Value,
) -> Result<(), Error> {
    AuditEntry::by(by, action, by.school_id).with(settled).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// The longest text before every survey, in characters.
const LONGEST_NOTICE: usize = 2000;
/// Longest name of a school, in characters.
const LONGEST_NAME: usize = 120;

/// Maximum grace period during which an attempt at a replaced revision still counts, in days.
const MOST_GRACE_DAYS: u32 = 365;

/// Returns the error message for an invalid grace period.
#[must_use]
pub fn refuse_grace(typed: &str) -> String {
    tr!("days: “{days}”; allowed: 0 to {most}", days = typed, most = MOST_GRACE_DAYS)
}

/// Changes name, time zone, mail settings and other preferences of a school. Deadlines of existing
/// assignments keep the time zone in which they were entered.
///
/// # Errors
/// Returns [`Error::Unprocessable`] for an invalid value: an empty name or that of another school,
/// an unknown time zone, or too long a grace period.
pub async fn settle_school(service: &Service, by: &CurrentPerson, settings: &SchoolSettings) -> Result<(), Error> {
    let length = settings.name.chars().count();
    if length == 0 || length > LONGEST_NAME {
        return Err(Error::Unprocessable(tr!(
            "the name has {n} characters; 1 to {most} are allowed",
            n = length,
            most = LONGEST_NAME
        )));
    }
    if let Some(why) = single_line_text::refusal("name", &settings.name) {
        return Err(Error::Unprocessable(why));
    }
    if !due::is_zone(&settings.time_zone) {
        return Err(Error::Unprocessable(DueRefused::NoZone(settings.time_zone.clone()).to_string()));
    }
    if settings.replaced_grace_days > MOST_GRACE_DAYS {
        return Err(Error::Unprocessable(refuse_grace(&settings.replaced_grace_days.to_string())));
    }
    let length = settings.data_notice.chars().count();
    if length > LONGEST_NOTICE {
        return Err(Error::Unprocessable(tr!(
            "the introduction to surveys has {n} characters; at most {most} are allowed",
            n = length,
            most = LONGEST_NOTICE
        )));
    }
    Signatory::from_form(&settings.signatory_name, &settings.signatory_function).map_err(Error::Unprocessable)?;
    let mut tx = service.db.write().await?;
    if !schools::put_school_settings(&mut tx, by.school_id, settings).await? {
        let why = tr!("the name: another school here is called “{name}”", name = settings.name);
        return Err(Error::Unprocessable(why));
    }
    let told = json!({
        "name": settings.name,
        "time_zone": settings.time_zone,
        "letter_language": settings.letter_language,
        "mails_reminders": settings.mails_reminders,
        "mails_news": settings.mails_news,
        "shows_others": settings.shows_others,
        "replaced_grace_days": settings.replaced_grace_days,
        "data_notice": settings.data_notice,
        "signatory": [settings.signatory_name, settings.signatory_function],
    });
    settle(service, tx, by, "school.settled", told).await
}

/// Sets the logo of a school: a copy of the image's pixels without metadata.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if the image is not accepted.
pub async fn put_logo(service: &Service, by: &CurrentPerson, sent: Vec<u8>) -> Result<(), Error> {
    ensure_database_room(service)?;
    let copied = copy_picture(service, by.school_id, &sent, true).await?;
    let copy = copied.map_err(|why| Error::Unprocessable(tr!("the logo: {why}", why = why)))?;
    let [width, height] = copy.size;
    let sha256 = HEXLOWER.encode(&Sha256::digest(&copy.bytes));
    let logo = SchoolLogo {
        media_type: copy.kind.media_type().to_owned(),
        width,
        height,
        bytes: copy.bytes,
        version: sha256.chars().take(32).collect(),
    };
    let mut tx = service.db.write().await?;
    logos::put_logo(&mut tx, by.school_id, &logo).await?;
    settle(service, tx, by, "school.logo_settled", json!({ "version": logo.version })).await
}

/// Removes a school's logo.
///
/// # Errors
/// Returns [`Error::NotFound`] if it has none.
pub async fn remove_logo(service: &Service, by: &CurrentPerson) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    if !logos::remove_logo(&mut tx, by.school_id).await? {
        return Err(Error::NotFound);
    }
    settle(service, tx, by, "school.logo_removed", json!({})).await
}

/// Sends a test mail to the caller and returns the result.
pub async fn send_test_letter(service: &Service, by: &CurrentPerson, letter: Letter) -> Result<LetterResult, Error> {
    let sent = service.mailer.send(letter, service.clock.now()).await.map_err(|error| format!("{error:#}"));
    let told = json!({ "error": sent.as_ref().err() });
    settle(service, service.db.write().await?, by, "school.mail_tested", told).await?;
    Ok(sent)
}

/// Sets the origins from which browsers may read the school's published data.
pub async fn set_origins(service: &Service, by: &CurrentPerson, allowed: &[String]) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    origins::replace_origins(&mut tx, by.school_id, allowed).await?;
    settle(service, tx, by, "school.origins_set", json!({ "origins": allowed })).await
}

/// Sets which roles must have a second factor.
pub async fn set_second_factor_rule(service: &Service, by: &CurrentPerson, rule: FactorRule) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    second_factors::set_factor_rule(&mut tx, by.school_id, rule).await?;
    settle(service, tx, by, "school.second_factor_set", json!({ "asked_of": rule.word() })).await
}

/// Sets which evidence an attempt needs to count towards a certificate.
pub async fn set_certificate_needs(service: &Service, by: &CurrentPerson, needed: Needed) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    schools::set_certificate_needs(&mut tx, by.school_id, needed).await?;
    settle(service, tx, by, "school.certificate_needs_set", json!({ "needed": needed.word() })).await
}

/// Sets the retention policy.
pub async fn set_retention(service: &Service, by: &CurrentPerson, settings: Settings) -> Result<(), Error> {
    let told = json!({
        "months": settings.months,
        "warn_days": settings.warn_days,
        "texts": settings.texts,
        "recordings": settings.recordings,
    });
    let mut tx = service.db.write().await?;
    retention::set_retention_rule(&mut tx, by.school_id, settings).await?;
    settle(service, tx, by, "retention.set", told).await
}
