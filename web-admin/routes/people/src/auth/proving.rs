//! A second factor presented in a form: a code, or the response of a passkey to the page's
//! challenge. The session stores only the id of the pending challenge.

use std::net::IpAddr;

use acts::auth::passkeys::{PasskeyAnswer, PasskeyCheck};
use acts::auth::second_factor::{SignInProof, TypedCode};
use acts::auth::{passkeys, second_factor};
use acts::error::Error;
use acts::people::accounts;
use model::auth::federation::FRESH_S;
use model::auth::passkey::PasskeyQuestion;
use model::ids::CeremonyId;
use model::{CurrentPerson, Moment, PersonKey};
use pages::auth::reauthentication::{FactorRefused, OwnPassword};
use platform::relying_party::AnswerRefused;
use routes_base::AppState;
use serde::Deserialize;
use tower_sessions::Session;

const KEY: &str = "passkey";

/// Form fields of a second factor; one of the two is filled in.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct ShownFactor {
    #[serde(default)]
    code: String,
    #[serde(default)]
    answer: String,
}

/// The person to challenge, and their session.
#[derive(Clone, Copy)]
pub(crate) struct FactorQuestion<'a> {
    /// The service.
    pub state: &'a AppState,
    /// The browser's session.
    pub session: &'a Session,
    /// The person.
    pub key: PersonKey,
}

impl FactorQuestion<'_> {
    /// Starts a passkey challenge, which replaces the previous one of this session. `None` if the
    /// person has no passkey.
    ///
    /// # Errors
    /// When the challenge cannot be created, or the database fails.
    pub(crate) async fn question(self) -> Result<Option<PasskeyQuestion>, Error> {
        let question = passkeys::ask(self.state, self.key).await?;
        if let Some(question) = &question {
            hold_question(self.session, question).await?;
        }
        Ok(question)
    }

    /// Verifies the presented factor, from a network address.
    ///
    /// # Errors
    /// When there were too many attempts, or the database fails.
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

/// Stores the id of the latest challenge in a session.
///
/// # Errors
/// When the session cannot be written.
pub(crate) async fn hold_question(session: &Session, question: &PasskeyQuestion) -> Result<(), Error> {
    Ok(session.insert(KEY, question.id).await?)
}

/// Returns the id of the latest challenge of a session, and removes it.
///
/// # Errors
/// When the session cannot be read or written.
pub(crate) async fn take_held_question(session: &Session) -> Result<Option<CeremonyId>, Error> {
    Ok(session.remove(KEY).await?)
}

const PROOF_KEY: &str = "proved_until";

/// Records in a session that its person has signed in at their provider just now.
///
/// # Errors
/// When the session cannot be written.
pub(crate) async fn hold_proof(state: &AppState, session: &Session) -> Result<(), Error> {
    Ok(session.insert(PROOF_KEY, state.clock.now().plus_s(FRESH_S)).await?)
}

/// Whether the person of a session has signed in at their provider within the last five minutes.
async fn has_proof(state: &AppState, session: &Session) -> Result<bool, Error> {
    let until = session.get::<Moment>(PROOF_KEY).await?;
    Ok(until.is_some_and(|until| until > state.clock.now()))
}

/// How a person proves who they are before a change.
///
/// # Errors
/// When the session cannot be read, or the database fails.
pub(crate) async fn find_own_password(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<OwnPassword, Error> {
    if accounts::has_password(state, person.id).await? {
        return Ok(OwnPassword::Known);
    }
    Ok(if has_proof(state, session).await? { OwnPassword::Proved } else { OwnPassword::Unproved })
}

/// Why a person has not proved who they are.
pub(crate) fn explain_missing_proof(own: OwnPassword) -> String {
    match own {
        OwnPassword::Known => tr!("This is not your current password.").to_owned(),
        OwnPassword::Proved | OwnPassword::Unproved => {
            tr!("You have no password here.").to_owned()
                + " "
                + tr!("First confirm who you are at your school’s sign-in")
        }
    }
}

/// Checks that a person has entered their password or, without one, has just signed in at their
/// provider. The inner error names the proof that is required.
///
/// # Errors
/// When the session cannot be read, or the database fails.
pub(crate) async fn check_proof(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
    typed: &str,
) -> Result<Result<(), OwnPassword>, Error> {
    let own = find_own_password(state, person, session).await?;
    let is_proved = match own {
        OwnPassword::Known => accounts::is_own_password(state, person, typed).await?,
        OwnPassword::Proved => true,
        OwnPassword::Unproved => false,
    };
    Ok(if is_proved { Ok(()) } else { Err(own) })
}
