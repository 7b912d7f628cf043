//! Access tokens of learning platforms (RFC 6749, section 4.4; 1EdTech Security Framework 1.0,
//! section 4.1), kept in memory.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use model::Moment;
use model::ids::PlatformId;
use serde::Deserialize;

/// How long before its end a token is no longer used, in s.
const MARGIN_S: i64 = 60;

/// What an access token is valid for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TokenUse {
    /// Learning platform.
    pub platform: PlatformId,
    /// Scopes, separated by spaces.
    pub scopes: String,
}

struct KeptToken {
    token: String,
    ends_at: Moment,
}

/// Access tokens that are still valid.
#[derive(Default)]
pub struct AccessTokens(Mutex<BTreeMap<TokenUse, KeptToken>>);

impl fmt::Debug for AccessTokens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AccessTokens").finish_non_exhaustive()
    }
}

/// Answer of a token endpoint.
#[derive(Deserialize)]
struct TokenAnswer {
    access_token: String,
    #[serde(default)]
    expires_in: i64,
}

impl AccessTokens {
    /// Returns the kept token, unless it is the `refused` one.
    #[must_use]
    pub fn find(&self, for_use: &TokenUse, refused: Option<&str>, now: Moment) -> Option<String> {
        let tokens = self.lock();
        let kept = tokens.get(for_use).filter(|kept| kept.ends_at > now && Some(kept.token.as_str()) != refused)?;
        Some(kept.token.clone())
    }

    /// Reads the answer of a token endpoint, and keeps the token until shortly before it expires.
    ///
    /// # Errors
    /// Fails if the answer is malformed; the error does not contain the token.
    pub fn keep(&self, for_use: TokenUse, answer: &[u8], now: Moment) -> anyhow::Result<String> {
        let answer: TokenAnswer = serde_json::from_slice(answer)?;
        let lifetime_s = answer.expires_in.clamp(0, 24 * 3600) - MARGIN_S;
        let token = answer.access_token;
        let mut tokens = self.lock();
        tokens.retain(|_, kept| kept.ends_at > now);
        tokens.insert(for_use, KeptToken { token: token.clone(), ends_at: now.plus_s(lifetime_s) });
        Ok(token)
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<TokenUse, KeptToken>> {
        // A poisoned lock is harmless: each operation leaves the map valid.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_kept_until_a_minute_before_its_end() {
        let tokens = AccessTokens::default();
        let now = Moment::from_micros(0);
        let of = |scopes: &str| TokenUse { platform: PlatformId::made_at(now), scopes: scopes.to_owned() };
        let (scores, items) = (of("score"), of("lineitem"));
        let answer = br#"{"access_token":"a1","token_type":"Bearer","expires_in":3600}"#;
        assert_eq!(tokens.keep(scores.clone(), answer, now).unwrap(), "a1");
        assert_eq!(tokens.find(&scores, None, now.plus_s(3539)).as_deref(), Some("a1"));
        assert_eq!(tokens.find(&scores, None, now.plus_s(3540)), None);
        assert_eq!(tokens.find(&scores, Some("a1"), now), None, "a refused token");
        assert_eq!(tokens.find(&items, None, now), None, "other scopes");
        assert_eq!(tokens.keep(items.clone(), br#"{"access_token":"a2"}"#, now).unwrap(), "a2");
        assert_eq!(tokens.find(&items, None, now), None, "an unknown end");
        assert!(!format!("{tokens:?}").contains("a1"));
        let error = tokens.keep(items, br#"{"access_token":7,"secret":"a3"}"#, now).unwrap_err();
        assert!(!error.to_string().contains("a3"), "{error}");
    }
}
