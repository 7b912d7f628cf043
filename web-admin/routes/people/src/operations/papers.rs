//! `/admin/papers`: the papers that data protection asks for, with the settings in force.

use std::collections::BTreeMap;

use acts::error::Error;
use axum::extract::State;
use model::Moment;
use model::auth::federation::LocalPasswords;
use model::ids::SchoolId;
use model::privacy::recipient::Recipient;
use pages::operations::papers::{PapersPage, ProcessingRecord, SchoolFacts};
use pages::{NavPlace, Shell};
use platform::config::list_collector_hosts;
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf};
use routes_base::error::PageError;
use store::EngineKind;
use store::auth::federation::providers;
use store::auth::lti::platforms;
use store::auth::second_factors;
use store::operations::schools::SchoolSettings;
use store::operations::{backups, origins, schools};
use store::people::provisioning;
use store::privacy::retention;
use store::training::learning_records;

pub(super) async fn show_papers(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<PapersPage, PageError> {
    let mut recipients = BTreeMap::new();
    for recipient in Recipient::ALL {
        let systems = list_systems(&state, person.school_id, recipient).await?;
        if !systems.is_empty() {
            recipients.insert(recipient, systems);
        }
    }
    Ok(PapersPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        at: state.clock.now().to_utc(),
        facts: find_facts(&state, person.school_id).await?,
        recipients,
        record: ProcessingRecord::in_language(words::current()),
    })
}

async fn find_facts(state: &AppState, school: SchoolId) -> Result<SchoolFacts, Error> {
    let reader = state.db.reader();
    let SchoolSettings { name, data_notice, mails_reminders, mails_news, shows_others, .. } =
        schools::find_school_settings(reader, school).await?;
    let rule = retention::find_retention_rule(reader, school).await?;
    let passwords = providers::find_local_passwords(reader, school).await?;
    let now = state.clock.now();
    let tokens = provisioning::list_tokens(reader, school).await?.into_iter();
    let mut allowed = state.config.allowed_origins.clone();
    allowed.extend(origins::list_school_origins(reader, school).await?);
    Ok(SchoolFacts {
        school: name,
        data_notice,
        erased_after: rule.months.map(|months| (months, rule.warn_days)),
        erases_texts: rule.texts,
        erases_recordings: rule.recordings,
        passwords_of_administrators_only: passwords == LocalPasswords::Administrators,
        factor_rule: second_factors::find_factor_rule(reader, school).await?,
        directories: tokens.filter(|token| token.expires_at > now).map(|token| token.name).collect(),
        mails: [mails_reminders, mails_news],
        shows_others,
        needed: schools::certificate_needs(reader, school).await?,
        origins: allowed,
        backup_at: backups::find_last_backup(reader).await?.map(|last| Moment::to_utc(last.made_at)),
    })
}

/// Returns the systems of a kind that receive data from this school, by name or address.
async fn list_systems(state: &AppState, school: SchoolId, recipient: Recipient) -> Result<Vec<String>, Error> {
    let (reader, config) = (state.db.reader(), &state.config);
    Ok(match recipient {
        Recipient::MailServer => config.mail.server().into_iter().collect(),
        Recipient::IdentityProvider => {
            let all = providers::list_providers(reader, school).await?.into_iter();
            let used = all.filter(|provider| provider.disabled_at.is_none());
            used.map(|provider| name_system(&provider.settings.name, &provider.settings.issuer)).collect()
        }
        Recipient::LearningPlatform => {
            let all = platforms::list_platforms(reader, school).await?.into_iter();
            let used = all.filter(|platform| platform.disabled_at.is_none());
            used.map(|platform| name_system(&platform.settings.name, &platform.settings.issuer)).collect()
        }
        Recipient::RecordStore => {
            let used = learning_records::find_record_store(reader, school).await?;
            used.into_iter().map(|store| store.settings.endpoint).collect()
        }
        Recipient::ObjectStore => config.bucket.iter().map(ToString::to_string).collect(),
        Recipient::DatabaseServer if config.database.kind() == EngineKind::Sqlite => Vec::new(),
        Recipient::DatabaseServer => vec![config.database.to_string()],
        Recipient::VirusScanner => config.scanner.iter().map(|scanner| scanner.socket.display().to_string()).collect(),
        Recipient::Collector => list_collector_hosts(),
    })
}

fn name_system(name: &str, address: &str) -> String {
    format!("{name} ({address})")
}
