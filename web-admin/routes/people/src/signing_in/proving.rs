//! A second factor shown in a form: a code that was typed, or the answer of a passkey to what the page has asked. What is waited for
//! stays in the session, by its id alone.

use std::net::IpAddr;

use acts::error::Error;
use acts::passkeys::{PasskeyAnswer, PasskeyCheck};
use acts::relying_party::AnswerRefused;
use acts::second_factor::{SignInProof, TypedCode};
use acts::{passkeys, second_factor};
use model::PersonKey;
use model::ids::CeremonyId;
use model::passkey::PasskeyQuestion;
use pages::proving::FactorRefused;
use routes_base::AppState;
use serde::Deserialize;
use tower_sessions::Session;

const KEY: &str = "passkey";

/// The fields of a form in which a second factor is shown: one of the two is filled in.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct ShownFactor {
    #[serde(default)]
    code: String,
    #[serde(default)]
    answer: String,
}

/// Who is asked, and where.
#[derive(Clone, Copy)]
pub(crate) struct FactorQuestion<'a> {
    /// The service.
    pub state: &'a AppState,
    /// The browser's session.
    pub session: &'a Session,
    /// Who.
    pub key: PersonKey,
}

impl FactorQuestion<'_> {
    /// Asks their passkeys, in place of what this session has asked before. None where there are none.
    ///
    /// # Errors
    /// When the question cannot be made, or the database fails.
    pub(crate) async fn question(self) -> Result<Option<PasskeyQuestion>, Error> {
        let question = passkeys::ask(self.state, self.key).await?;
        if let Some(question) = &question {
            hold_question(self.session, question).await?;
        }
        Ok(question)
    }

    /// What is proved by what was shown, from a network address.
    ///
    /// # Errors
    /// When there were too many tries, or the database fails.
    pub(crate) async fn prove(
        self,
        shown: &ShownFactor,
        from: IpAddr,
    ) -> Result<Result<SignInProof, FactorRefused>, Error> {
        let Self { state, session, key } = self;
        if shown.answer.is_empty() {
            let proof = second_factor::check(state, key, TypedCode { code: &shown.code, from }).await?;
            return Ok(proof.ok_or(FactorRefused::Code));
        }
        let answer = PasskeyAnswer { question: take_held_question(session).await?, json: &shown.answer, from };
        Ok(match passkeys::check(state, key, answer).await? {
            PasskeyCheck::Proved(proof) => Ok(proof),
            PasskeyCheck::Late => Err(FactorRefused::Late),
            PasskeyCheck::Refused(AnswerRefused::Wrong) => Err(FactorRefused::Answer),
            PasskeyCheck::Refused(AnswerRefused::Copied) => Err(FactorRefused::Copied),
        })
    }
}

/// Keeps in a session what its browser was asked last.
///
/// # Errors
/// When the session cannot be written.
pub(crate) async fn hold_question(session: &Session, question: &PasskeyQuestion) -> Result<(), Error> {
    Ok(session.insert(KEY, question.id).await?)
}

/// What the browser of a session was asked last, this once.
///
/// # Errors
/// When the session cannot be read or written.
pub(crate) async fn take_held_question(session: &Session) -> Result<Option<CeremonyId>, Error> {
    Ok(session.remove(KEY).await?)
}
