//! `/admin/settings`: a school's own settings.

use acts::error::Error;
use acts::operations::schools as settling;
use axum::extract::{Query, State};
use axum::response::Redirect;
use model::Needed;
use model::ids::LetterId;
use pages::form::FilledForm;
use pages::letters::MailWay;
use pages::operations::settings::{SettingsForm, SettingsPage};
use pages::{NavPlace, Shell, letters};
use platform::config::MailTo;
use platform::mailer::Letter;
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, language};
use serde::Deserialize;
use store::auth::second_factors;
use store::operations::schools;
use store::operations::schools::SchoolSettings;
use store::people::directory;
use words::Language;

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct SavedQuery {
    #[serde(default)]
    saved: bool,
}

pub(super) async fn show_settings(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    Query(SavedQuery { saved }): Query<SavedQuery>,
) -> Result<SettingsPage, PageError> {
    let page = make_settings_page(&state, Visit::new(&person, &csrf), None).await?;
    Ok(SettingsPage { done: saved.then(|| tr!("Changed.").to_owned()), ..page })
}

pub(super) async fn make_settings_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    sent: Option<FilledForm<SettingsForm>>,
) -> Result<SettingsPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let settled = schools::find_school_settings(reader, school).await?;
    let own = directory::find_directory_entry(reader, school, person.id).await?.ok_or(Error::NotFound)?;
    Ok(SettingsPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        zones: model::training::due::list_zones(&settled.time_zone),
        form: sent.unwrap_or_else(|| FilledForm::new(form_of_settings(settled))),
        done: None,
        mail_way: find_mail_way(state),
        own_email: own.email,
        needed: schools::certificate_needs(reader, school).await?,
        factor_rule: second_factors::find_factor_rule(reader, school).await?,
    })
}

/// Where the service's letters go.
pub(crate) fn find_mail_way(state: &AppState) -> MailWay {
    match state.config.mail {
        MailTo::Smtp(_) => MailWay::Server,
        MailTo::Folder(_) => MailWay::Folder,
    }
}

fn form_of_settings(settled: SchoolSettings) -> SettingsForm {
    let SchoolSettings {
        name,
        time_zone,
        letter_language,
        mails_reminders,
        mails_news,
        shows_others,
        replaced_grace_days,
        data_notice,
        signatory_name,
        signatory_function,
    } = settled;
    let letter_language = letter_language.unwrap_or_else(|| Language::ENGLISH.code().to_owned());
    let replaced_grace_days = replaced_grace_days.to_string();
    SettingsForm {
        name,
        time_zone,
        letter_language,
        mails_reminders,
        mails_news,
        shows_others,
        replaced_grace_days,
        data_notice,
        signatory_name,
        signatory_function,
    }
}

/// Sets the school's name, time zone and mail settings.
pub(super) async fn put_settings(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<SettingsForm>,
) -> Result<FormAnswer<SettingsPage>, PageError> {
    let code = form.letter_language.as_str();
    let spoken = Language::named(code).ok_or_else(|| language::refuse_language(code))?;
    let Ok(replaced_grace_days) = form.replaced_grace_days.parse() else {
        let why = settling::refuse_grace(&form.replaced_grace_days);
        let sent = Some(FilledForm::refused(form, why));
        return Ok(FormAnswer::Refused(make_settings_page(&state, Visit::new(&person, &csrf), sent).await?));
    };
    let settings = SchoolSettings {
        name: form.name.clone(),
        time_zone: form.time_zone.clone(),
        letter_language: Some(spoken.code().to_owned()),
        mails_reminders: form.mails_reminders,
        mails_news: form.mails_news,
        shows_others: form.shows_others,
        replaced_grace_days,
        data_notice: form.data_notice.clone(),
        signatory_name: form.signatory_name.clone(),
        signatory_function: form.signatory_function.clone(),
    };
    match split_refusal(settling::settle_school(&state, &person, &settings).await)? {
        Ok(()) => Ok(FormAnswer::lead_to("/admin/settings?saved=true")),
        Err(why) => {
            let sent = Some(FilledForm::refused(form, why));
            Ok(FormAnswer::Refused(make_settings_page(&state, Visit::new(&person, &csrf), sent).await?))
        }
    }
}

/// Sends a test mail to the administrator, and reports the result.
pub(super) async fn send_test_letter(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<SettingsPage, PageError> {
    let page = make_settings_page(&state, Visit::new(&person, &csrf), None).await?;
    let (subject, body) = letters::write_test_letter(&person.display_name, &page.form.typed.name);
    let letter = Letter {
        id: LetterId::made_at(state.clock.now()),
        name: person.display_name.clone(),
        email: page.own_email.clone(),
        subject,
        body,
    };
    Ok(match settling::send_test_letter(&state, &person, letter).await? {
        Ok(()) => {
            let done = Some(tr!("A test email was sent to {email}.", email = page.own_email));
            SettingsPage { done, ..page }
        }
        Err(why) => {
            let why = tr!("the test email was not sent: {why}", why = why);
            let form = FilledForm::refused(page.form.typed, why);
            SettingsPage { form, ..page }
        }
    })
}

#[derive(Deserialize)]
pub(super) struct NeededForm {
    needed: String,
}

/// Sets the evidence that an attempt needs to count towards a certificate.
pub(super) async fn set_certificate_needs(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(form): CsrfForm<NeededForm>,
) -> Result<Redirect, PageError> {
    let needed = Needed::of_word(&form.needed).ok_or_else(|| {
        let allowed = Needed::ALL.map(Needed::word).join(", ");
        Error::BadRequest(format!("needed: \"{}\"; allowed: {allowed}", form.needed))
    })?;
    settling::set_certificate_needs(&state, &person, needed).await?;
    Ok(Redirect::to("/admin/settings?saved=true#certificates"))
}
