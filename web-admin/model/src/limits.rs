//! Limits that are shown on pages and enforced by the service.

/// Validity of an invitation, in s.
pub const INVITATION_LIFETIME_S: i64 = 14 * 86_400;

/// Validity of a link for resetting a password, in s.
pub const RESET_LIFETIME_S: i64 = 86_400;

/// Maximum length of a name, in characters.
pub const LONGEST_NAME: usize = 60;

/// Available lifetimes of a token, in days.
pub const TOKEN_LIFETIMES_DAYS: [i64; 3] = [30, 90, 365];

/// Minimum length of a password, in characters.
pub const MIN_PASSWORD: usize = 10;

/// Maximum number of letters with links that a school can send per hour, so that a stolen account
/// cannot be used for mass mail.
pub const LETTERS_AN_HOUR: usize = 300;
