//! Settings of a learning record store.

use crate::single_line_text::is_strange;

/// Maximum length of a user name, in characters.
const LONGEST_NAME: usize = 200;
/// Maximum length of a legal ground, in characters.
const LONGEST_GROUND: usize = 2000;
/// Versions of xAPI that are supported.
pub const VERSIONS: [&str; 2] = ["1.0.3", "2.0.0"];

/// Settings of a learning record store, without its password.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordStoreSettings {
    /// Address to which `/statements` is appended.
    pub endpoint: String,
    /// User name of this service.
    pub user_name: String,
    /// Version of xAPI.
    pub version: String,
    /// Legal ground for sending statements without consent; `None` if each person is asked.
    pub ground: Option<String>,
    /// Statements contain names beside pseudonyms.
    pub names: bool,
}

impl RecordStoreSettings {
    /// Checks the settings, except whether the address is permitted.
    ///
    /// # Errors
    /// Returns what is wrong: the field, the value, and what is allowed.
    pub fn check(&self) -> Result<(), String> {
        let Self { user_name, version, ground, .. } = self;
        let length = user_name.chars().count();
        if length == 0 || length > LONGEST_NAME || user_name.contains(|c: char| c == ':' || is_strange(c)) {
            // RFC 7617, section 2: a user name with a colon cannot be sent.
            return Err(tr!(
                "user name: {length} characters; allowed: 1 to {most}, without colons and control characters",
                length = length,
                most = LONGEST_NAME
            ));
        }
        if !VERSIONS.contains(&version.as_str()) {
            let allowed = VERSIONS.join(", ");
            return Err(tr!("version: “{version}”; allowed: {allowed}", version = version, allowed = allowed));
        }
        let length = ground.as_ref().map_or(0, |ground| ground.chars().count());
        if length > LONGEST_GROUND {
            return Err(tr!(
                "legal ground: {length} characters; at most {most}",
                length = length,
                most = LONGEST_GROUND
            ));
        }
        Ok(())
    }

    /// Returns whether other data go to somebody else than with `before`: then consents to `before`
    /// do not hold.
    #[must_use]
    pub fn asks_for_more(&self, before: &Self) -> bool {
        self.endpoint != before.endpoint || (self.names && !before.names)
    }
}
