//! Address and credentials of an S3 bucket.

use std::collections::BTreeMap;

/// Error message of a program built without the feature `replicas`, with the command that builds
/// it.
#[cfg(not(feature = "replicas"))]
pub const UNBUILT: &str = "this program is built without bucket support: allowed: a path or a file:// URL; for s3:// URLs, build with `cargo build --release -p web-admin --features replicas`";

/// Prefix of the environment variables that configure access.
const VARIABLES: &str = "AWS_";

/// A bucket of an S3-compatible store, and the prefix under which this service stores its objects.
#[derive(Clone, PartialEq, Eq)]
pub struct BucketAddress {
    /// Name of the bucket.
    pub bucket: String,
    /// Prefix of all object names of this service; empty if the whole bucket belongs to it.
    pub prefix: String,
    /// Endpoint, region, credentials and other settings, by the name of their variable
    /// (`AWS_REGION`).
    pub settings: BTreeMap<String, String>,
}

impl BucketAddress {
    /// Parses the part after `s3://` and takes the relevant environment variables. Returns `None`
    /// if it is not a valid address.
    #[must_use]
    pub fn parse(given: &str, environment: impl IntoIterator<Item = (String, String)>) -> Option<Self> {
        let given = given.strip_suffix('/').unwrap_or(given);
        let (bucket, prefix) = given.split_once('/').unwrap_or((given, ""));
        let plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte));
        let is_part = |part: &str| plain(part) && !matches!(part, "" | "." | "..");
        let fits = is_part(bucket) && (prefix.is_empty() || prefix.split('/').all(is_part));
        let settings = environment.into_iter().filter(|(name, _)| name.starts_with(VARIABLES)).collect();
        fits.then(|| Self { bucket: bucket.to_owned(), prefix: prefix.to_owned(), settings })
    }

    /// Returns the full object name, with the prefix.
    #[must_use]
    pub fn name_within(&self, name: &str) -> String {
        if self.prefix.is_empty() { name.to_owned() } else { format!("{}/{name}", self.prefix) }
    }

    /// Returns whether an environment variable configures access. Such variables must not reach
    /// child processes.
    #[must_use]
    pub fn is_variable(name: &str) -> bool {
        name.starts_with(VARIABLES)
    }
}

impl std::fmt::Display for BucketAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "s3://{}", self.bucket)?;
        if self.prefix.is_empty() { Ok(()) } else { write!(f, "/{}", self.prefix) }
    }
}

impl std::fmt::Debug for BucketAddress {
    /// Omits the settings, which contain credentials.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BucketAddress({self})")
    }
}

#[cfg(test)]
mod tests {
    //! Credentials must never be printed, and an address that names another object than it appears
    //! to must be rejected.

    use super::*;

    fn parse(given: &str) -> Option<BucketAddress> {
        let environment = [("AWS_SECRET_ACCESS_KEY", "hidden"), ("PATH", "/bin")];
        BucketAddress::parse(given, environment.map(|(name, value)| (name.to_owned(), value.to_owned())))
    }

    #[test]
    fn bucket_address_is_a_bucket_and_a_prefix_and_hides_its_key() {
        let whole = parse("school").unwrap();
        assert_eq!((whole.to_string(), whole.name_within("a/b")), ("s3://school".to_owned(), "a/b".to_owned()));
        let part = parse("school/north/1/").unwrap();
        assert_eq!(part.to_string(), "s3://school/north/1");
        assert_eq!(part.name_within("a"), "north/1/a");
        assert_eq!(part.settings.len(), 1, "what is not of use is not kept");
        assert!(!format!("{part:?} {part}").contains("hidden"));
        for nonsense in ["", "/", "a//b", "a/../b", "a b", "a/%2F", "a/ä", "a?x=1", "user:key@bucket"] {
            assert_eq!(parse(nonsense), None, "{nonsense}");
        }
    }
}
