//! Whose passkeys they are: a passkey belongs to the name of a host, and answers to its pages alone.

use anyhow::Context;
use model::ids::PersonId;
use serde::de::DeserializeOwned;
use webauthn_rs::prelude::{
    AuthenticationResult, CredentialID, Passkey, PasskeyAuthentication, PasskeyRegistration, Url, WebauthnError,
};
use webauthn_rs::{Webauthn, WebauthnBuilder};

use crate::config::Config;

/// What browsers are told of us.
const NAME: &str = "Stylet";

/// Where this service has passkeys.
#[derive(Clone, Debug)]
pub struct Site {
    webauthn: Webauthn,
    origin: String,
}

/// Where this service has passkeys, if it does.
#[derive(Debug)]
pub struct Passkeys {
    site: Option<Site>,
}

impl Passkeys {
    /// Of a service as it was told to run.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self { site: Site::of(config) }
    }

    /// The site, where browsers have passkeys for it.
    #[must_use]
    pub const fn site(&self) -> Option<&Site> {
        self.site.as_ref()
    }
}

/// Why an answer was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerRefused {
    /// It is no answer to what was asked: of another origin, challenge or key, or of no form.
    Wrong,
    /// The passkey has counted fewer signatures than before: there may be a copy of it.
    Copied,
}

/// Whom a passkey is made for.
#[derive(Clone, Copy, Debug)]
pub struct PasskeyOwner<'a> {
    /// Id, which the authenticator keeps.
    pub id: PersonId,
    /// Address, by which they tell their accounts apart.
    pub email: &'a str,
    /// Name.
    pub name: &'a str,
}

impl Site {
    /// The site of a service by where people find it. None where its host is no name, or browsers do not trust the way to it: then
    /// they have no passkeys for it.
    #[must_use]
    pub fn of(config: &Config) -> Option<Self> {
        let trial = config.public_url.is_none() && config.listen.ip().is_loopback();
        let address = if trial { format!("http://localhost:{}", config.listen.port()) } else { config.address() };
        let url = Url::parse(&address).ok()?;
        let host = url.domain()?;
        if url.scheme() != "https" && host != "localhost" {
            return None;
        }
        let origin = url.origin().ascii_serialization();
        let plain = Url::parse(&origin).ok()?;
        // On trial the system may have chosen the port.
        let builder = WebauthnBuilder::new(host, &plain).ok()?.rp_name(NAME).allow_any_port(trial);
        Some(Self { webauthn: builder.build().ok()?, origin })
    }

    /// The origin that passkeys answer to, as a browser names it.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Asks for a new passkey, of an authenticator that has none of these: what the browser is told, in JSON, and what its answer is
    /// held to.
    ///
    /// # Errors
    /// When the question cannot be made.
    pub fn ask_to_make(
        &self,
        owner: PasskeyOwner<'_>,
        known: Vec<CredentialID>,
    ) -> anyhow::Result<(String, PasskeyRegistration)> {
        let started = self.webauthn.start_passkey_registration(owner.id.uuid(), owner.email, owner.name, Some(known));
        let (options, state) = started.context("a passkey cannot be asked for")?;
        Ok((serde_json::to_string(&options)?, state))
    }

    /// The new passkey of an answer.
    ///
    /// # Errors
    /// When it is no answer to what was asked.
    pub fn made(&self, answer: &str, state: &PasskeyRegistration) -> Result<Passkey, AnswerRefused> {
        self.webauthn.finish_passkey_registration(&read(answer)?, state).map_err(refused)
    }

    /// Asks one of these passkeys to sign: what the browser is told, in JSON, and what its answer is held to.
    ///
    /// # Errors
    /// When the question cannot be made.
    pub fn ask_to_sign(&self, known: &[Passkey]) -> anyhow::Result<(String, PasskeyAuthentication)> {
        let started = self.webauthn.start_passkey_authentication(known);
        let (options, state) = started.context("a passkey cannot be asked to sign")?;
        Ok((serde_json::to_string(&options)?, state))
    }

    /// Which passkey has signed, and its counter.
    ///
    /// # Errors
    /// When it is no answer to what was asked, or the counter went backwards.
    pub fn signed(&self, answer: &str, state: &PasskeyAuthentication) -> Result<AuthenticationResult, AnswerRefused> {
        self.webauthn.finish_passkey_authentication(&read(answer)?, state).map_err(refused)
    }
}

fn read<T: DeserializeOwned>(answer: &str) -> Result<T, AnswerRefused> {
    serde_json::from_str(answer).map_err(|why| {
        tracing::warn!(%why, "the answer of a passkey cannot be read");
        AnswerRefused::Wrong
    })
}

fn refused(why: WebauthnError) -> AnswerRefused {
    tracing::warn!(%why, "the answer of a passkey is refused");
    match why {
        WebauthnError::CredentialPossibleCompromise => AnswerRefused::Copied,
        _ => AnswerRefused::Wrong,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    //! A site of a wrong name or origin would take answers that were made for another.

    use std::path::Path;

    use super::*;

    fn site(public_url: Option<&str>, listen: &str) -> Option<Site> {
        let public_url = public_url.map(str::to_owned);
        Site::of(&Config { public_url, listen: listen.parse().unwrap(), ..Config::in_folder(Path::new("x")) })
    }

    /// A passkey to be made.
    pub(crate) fn asked_to_make() -> PasskeyRegistration {
        let owner = PasskeyOwner { id: PersonId::from_u128(1), email: "ada@example.org", name: "Ada" };
        site(None, "127.0.0.1:8080").unwrap().ask_to_make(owner, Vec::new()).unwrap().1
    }

    #[test]
    fn passkeys_belong_to_a_name_that_browsers_trust() {
        for (public_url, listen, expected) in [
            (Some("https://training.example.org"), "127.0.0.1:8080", Some("https://training.example.org")),
            (Some("https://training.example.org:8443/stylet"), "0.0.0.0:80", Some("https://training.example.org:8443")),
            (Some("http://localhost:9000"), "127.0.0.1:8080", Some("http://localhost:9000")),
            (None, "127.0.0.1:8080", Some("http://localhost:8080")),
            (None, "[::1]:8080", Some("http://localhost:8080")),
            (None, "10.0.0.1:8080", None),
            (Some("http://training.example.org"), "127.0.0.1:8080", None),
            (Some("https://10.0.0.1"), "127.0.0.1:8080", None),
            (Some("training.example.org"), "127.0.0.1:8080", None),
        ] {
            let found = site(public_url, listen);
            assert_eq!(found.as_ref().map(Site::origin), expected, "{public_url:?} {listen}");
        }
    }

    #[test]
    fn nonsense_is_no_answer() {
        let state = asked_to_make();
        let site = site(None, "127.0.0.1:8080").unwrap();
        for answer in ["", "{}", "null", "{\"id\": 1}", "\u{0}"] {
            assert_eq!(site.made(answer, &state).err(), Some(AnswerRefused::Wrong), "{answer}");
        }
    }
}
