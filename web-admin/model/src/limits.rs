//! Limits that pages tell and acts keep.

/// How long an invitation is good, in s.
pub const INVITATION_LIFETIME_S: i64 = 14 * 86_400;

/// How long a link to another password is good, in s.
pub const RESET_LIFETIME_S: i64 = 86_400;

/// Longest name, in characters.
pub const LONGEST_NAME: usize = 60;

/// How long a token may be asked to last, in days.
pub const TOKEN_LIFETIMES_DAYS: [i64; 3] = [30, 90, 365];

/// Shortest password taken, in characters.
pub const MIN_PASSWORD: usize = 10;

/// Most letters with links that a school sends within an hour: who signs in by a stolen password is no mailer.
pub const LETTERS_AN_HOUR: usize = 300;
