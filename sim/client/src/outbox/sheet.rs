//! Answers to a survey after an attempt: saved while they are entered, then kept until the service
//! has stored them.
//!
//! While the survey is open, the file is a draft that only its window changes. When the answers are
//! sent or the window is left, the file is renamed and never changes again: the file that is
//! deleted is the one that was sent.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use assessment::questionnaire::Answer;
use data_encoding::HEXLOWER;
use serde::{Deserialize, Serialize};
use serde_json::json;
use sha2::{Digest, Sha256};
use tempfile::Builder;
use uuid::Uuid;

use super::{Entry, ID_DIGITS, Outbox};
use crate::exit::Failure;
use crate::new_file;
use crate::service::{Outlook, Service, Trouble, ask_service};

/// File extension of pending answers.
pub(super) const ANSWERS: &str = "answers";
/// File extension of answers that are being entered.
const DRAFT: &str = "draft";

/// Answers of one person to one survey.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AnswerSheet {
    /// Session of the attempt after which they were given.
    pub session: Uuid,
    /// The survey.
    pub survey: Uuid,
    /// Identifies the response, so that sending it twice stores it once, and gives access to it
    /// later: 64 hexadecimal digits.
    pub secret: String,
    /// Language code.
    pub language: String,
    /// Answers by item id.
    pub answers: BTreeMap<String, Answer>,
    /// Whether they are final.
    pub sent: bool,
}

impl AnswerSheet {
    /// Creates an empty sheet with a new secret.
    pub fn new(session: Uuid, survey: Uuid, language: &str) -> Self {
        let secret = format!("{}{}", Uuid::new_v4().simple(), Uuid::new_v4().simple());
        Self { session, survey, secret, language: language.to_owned(), answers: BTreeMap::new(), sent: false }
    }

    /// Returns the path of its file in a folder. The name is a hash and does not reveal the secret.
    fn place(&self, folder: &Path, extension: &str) -> PathBuf {
        let mut id = HEXLOWER.encode(&Sha256::digest(self.secret.as_bytes()));
        id.truncate(ID_DIGITS);
        folder.join(id).with_extension(extension)
    }
}

impl Outbox {
    /// Saves answers that are being entered.
    ///
    /// # Errors
    /// If writing fails; the last saved draft is unchanged.
    pub fn save_draft(&self, sheet: &AnswerSheet) -> Result<(), Failure> {
        let write = || -> io::Result<()> {
            let mut new = Builder::new().prefix(".answers-").tempfile_in(&self.folder)?;
            new.write_all(serde_json::to_string(sheet)?.as_bytes())?;
            new_file::persist(new, &sheet.place(&self.folder, DRAFT))
        };
        write().map_err(|error| self.refuses(&error))
    }

    /// Deletes answers that were not sent.
    ///
    /// # Errors
    /// If the file cannot be deleted.
    pub fn forget_draft(&self, sheet: &AnswerSheet) -> Result<(), Failure> {
        match fs::remove_file(sheet.place(&self.folder, DRAFT)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(self.refuses(&error)),
            _ => Ok(()),
        }
    }

    /// Adds answers that do not change any more to the outbox, to be sent to a service.
    ///
    /// # Errors
    /// If writing fails.
    pub fn keep_answers(&self, sheet: &AnswerSheet, server: &str) -> Result<Entry, Failure> {
        self.save_draft(sheet)?;
        let place = sheet.place(&self.folder, ANSWERS);
        let keep = || -> io::Result<Entry> {
            fs::rename(sheet.place(&self.folder, DRAFT), &place)?;
            new_file::sync_folder(&self.folder)?;
            Entry::kept(place.clone(), format!("answers after {}", sheet.session), Some(server))
        };
        keep().map_err(|error| self.refuses(&error))
    }

    /// Adds drafts that a killed process has left to the outbox.
    ///
    /// # Errors
    /// If a file cannot be renamed.
    pub fn take_up_drafts(&self) -> Result<(), Failure> {
        let take_up = || -> io::Result<()> {
            for found in fs::read_dir(&self.folder)? {
                let draft = found?.path();
                if draft.extension().is_some_and(|extension| extension == DRAFT) {
                    fs::rename(&draft, draft.with_extension(ANSWERS))?;
                }
            }
            Ok(())
        };
        take_up().map_err(|error| self.refuses(&error))
    }

    fn refuses(&self, error: &io::Error) -> Failure {
        Failure::work(format_args!("{}: {error}", self.folder.display()))
    }
}

/// Sends answers once; returns the session that they are about.
pub(super) fn deliver(service: &Service, file: &Path) -> Result<String, Trouble> {
    let sheet = fs::read(file).map_err(|error| Trouble::new(Outlook::Later, format_args!("the outbox: {error}")))?;
    let spoilt = |error| Trouble::new(Outlook::Never, format_args!("the answers are damaged: {error}"));
    let sheet: AnswerSheet = serde_json::from_slice(&sheet).map_err(spoilt)?;
    let address = format!("{}/api/v1/sessions/{}/survey/{}", service.address, sheet.session, sheet.survey);
    // The first question is shown only after the consent.
    let given = json!({
        "secret": sheet.secret,
        "language": sheet.language,
        "consent": true,
        "answers": sheet.answers,
        "sent": sheet.sent,
    });
    let request = service.agent.put(&address).header("Authorization", &service.token);
    let reply = ask_service(&address, request.content_type("application/json").send(given.to_string()))?;
    let taken = reply.status == 200 && reply.json().is_some_and(|said| said.get("state").is_some());
    match (taken, reply.status) {
        (true, _) => Ok(sheet.session.to_string()),
        // The survey was closed before the attempt and never opens for it again.
        (false, 410) => Err(Trouble { outlook: Outlook::Never, ..reply.trouble() }),
        (false, _) => Err(reply.trouble()),
    }
}
