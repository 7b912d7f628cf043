//! Time-based one-time passwords (RFC 6238: SHA-1, six digits, 30 s), and the schools' rules on who
//! needs them.

use data_encoding::BASE32_NOPAD;
use percent_encoding::{AsciiSet, CONTROLS, utf8_percent_encode};
use totp_rs::{Algorithm, Builder, Totp};

use crate::{Moment, Role};

/// Number of digits of a code.
pub const CODE_DIGITS: u8 = 6;
/// Length of a time step, in s.
pub const STEP_S: i64 = 30;
/// Accepted clock deviation in time steps, in either direction.
const SKEW: u16 = 1;
/// Characters with a special meaning in a URL.
const MEANINGFUL: &AsciiSet = &CONTROLS
    .add(b' ')
    .add(b'"')
    .add(b'#')
    .add(b'%')
    .add(b'&')
    .add(b'+')
    .add(b'/')
    .add(b':')
    .add(b'<')
    .add(b'>')
    .add(b'?');
/// Length of a secret, in bytes, as recommended by RFC 4226.
const SECRET_BYTES: usize = 20;

/// A secret shared by an authenticator app and this service.
#[derive(Clone, PartialEq, Eq)]
pub struct TotpSecret([u8; SECRET_BYTES]);

impl std::fmt::Debug for TotpSecret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("TotpSecret(…)")
    }
}

impl TotpSecret {
    /// Makes a secret from random bytes.
    #[must_use]
    pub const fn new(bytes: [u8; SECRET_BYTES]) -> Self {
        Self(bytes)
    }

    /// Makes a secret from stored bytes. `None` if the length is wrong.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        bytes.try_into().ok().map(Self)
    }

    /// Returns the bytes.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; SECRET_BYTES] {
        &self.0
    }

    /// Returns the secret in base32, for manual entry in an app.
    #[must_use]
    pub fn text(&self) -> String {
        BASE32_NOPAD.encode(&self.0)
    }

    /// Returns the URL for the QR code, with issuer and account. Hash, digits and period are the
    /// apps' defaults and left out, because a shorter text gives a simpler QR code.
    #[must_use]
    pub fn address(&self, issuer: &str, account: &str) -> String {
        let encoded = |text: &str| utf8_percent_encode(text, MEANINGFUL).to_string();
        let (issuer, account, secret) = (encoded(issuer), encoded(account), self.text());
        format!("otpauth://totp/{issuer}:{account}?secret={secret}&issuer={issuer}")
    }

    /// Returns the time step of a code, in units of 30 s since 1970 UTC. It differs from the
    /// current step by at most one. `None` if the code is not valid now.
    #[must_use]
    pub fn step_of(&self, code: &str, now: Moment) -> Option<i64> {
        let now_s = u64::try_from(now.micros() / 1_000_000).ok()?;
        // Reject malformed codes before parsing them.
        let shaped = code.len() == usize::from(CODE_DIGITS) && code.bytes().all(|byte| byte.is_ascii_digit());
        let step = shaped.then(|| self.totp()?.check(code, now_s)).flatten()?;
        i64::try_from(step).ok()
    }

    fn totp(&self) -> Option<Totp> {
        let builder = Builder::new().with_algorithm(Algorithm::SHA1).with_digits(CODE_DIGITS).with_skew(SKEW);
        builder.with_step_duration(STEP_S.unsigned_abs()).with_secret(self.0.to_vec()).build().ok()
    }

    /// Returns the code that an app shows at a moment.
    #[must_use]
    pub fn code_at(&self, now: Moment) -> Option<String> {
        let now_s = u64::try_from(now.micros() / 1_000_000).ok()?;
        Some(self.totp()?.generate(now_s).to_string())
    }
}

/// A school's rule on who needs a second factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum FactorRule {
    /// No one needs one; everyone may have one.
    Nobody,
    /// Instructors and administrators need one.
    Teachers,
    /// Everyone needs one, including trainees.
    Everybody,
}

impl FactorRule {
    /// All rules, least strict first.
    pub const ALL: [Self; 3] = [Self::Nobody, Self::Teachers, Self::Everybody];

    /// Returns the word used in forms.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Teachers => "teachers",
            Self::Everybody => "everybody",
        }
    }

    /// Returns whether people with a role need a second factor.
    #[must_use]
    pub const fn asks(self, role: Role) -> bool {
        match self {
            Self::Nobody => false,
            Self::Teachers => !matches!(role, Role::Trainee),
            Self::Everybody => true,
        }
    }

    /// Returns the rule for a word used in forms.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rule| rule.word() == word)
    }
}

#[cfg(test)]
mod tests {
    //! Checks that the codes match those of common apps, and expire when they should.

    use super::*;

    const fn at(seconds: i64) -> Moment {
        Moment::from_micros(seconds * 1_000_000)
    }

    #[test]
    fn the_codes_are_those_of_the_standard() {
        // RFC 6238, appendix B, SHA-1: the last six of its eight digits.
        let secret = TotpSecret::new(*b"12345678901234567890");
        for (seconds, code) in [
            (59, "287082"),
            (1_111_111_109, "081804"),
            (1_111_111_111, "050471"),
            (1_234_567_890, "005924"),
            (2_000_000_000, "279037"),
            (20_000_000_000, "353130"),
        ] {
            assert_eq!(secret.code_at(at(seconds)).as_deref(), Some(code), "{seconds}");
            assert_eq!(secret.step_of(code, at(seconds)), Some(seconds / STEP_S));
        }
    }

    #[test]
    fn a_code_is_good_one_step_early_and_late_and_no_longer() {
        let secret = TotpSecret::new([7; SECRET_BYTES]);
        let code = secret.code_at(at(3000)).expect("a code");
        let found = |seconds| secret.step_of(&code, at(seconds));
        assert_eq!([found(2970), found(3000), found(3059)], [Some(100); 3]);
        assert_eq!([found(2969), found(3060), found(4000)], [None; 3]);
        for nonsense in ["", "12345", "1234567", "12345x", "１２３４５６", "-12345"] {
            assert_eq!(secret.step_of(nonsense, at(3000)), None, "{nonsense}");
        }
    }

    #[test]
    fn an_app_is_told_all_it_needs() {
        let secret = TotpSecret::new(*b"12345678901234567890");
        let address = secret.address("Stylet, North & South", "ada@example.org");
        let expected = "otpauth://totp/Stylet,%20North%20%26%20South:ada@example.org\
                        ?secret=GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ&issuer=Stylet,%20North%20%26%20South";
        assert_eq!(address, expected);
        assert_eq!(format!("{secret:?}"), "TotpSecret(…)", "it is in no log");
    }
}
