//! Configuration of the service.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use http::Uri;
use model::people::email::is_email;
use store::{AddressRefused, DatabaseAddress};

use crate::bucket_address::BucketAddress;
use crate::helper::Helper;
use crate::outgoing::OutgoingRules;
use crate::scanning::Scanner;
use crate::secret::PasswordCost;

/// Destination of outgoing mail.
#[derive(Clone, PartialEq, Eq)]
pub enum MailTo {
    /// Files in a folder.
    Folder(PathBuf),
    /// A server, as an `smtp:` or `smtps:` URL.
    Smtp(String),
}

impl MailTo {
    /// Returns the host of the mail server; `None` if letters are written to a folder.
    #[must_use]
    pub fn server(&self) -> Option<String> {
        match self {
            Self::Folder(_) => None,
            Self::Smtp(url) => Some(host_of(url)),
        }
    }
}

/// Returns the host in a URL, without the password that it may contain.
fn host_of(url: &str) -> String {
    let parsed = url.parse::<Uri>().ok();
    parsed.as_ref().and_then(Uri::host).unwrap_or("?").to_owned()
}

/// Variables of the OpenTelemetry specification that name a collector of metrics or traces.
const COLLECTORS: [&str; 3] =
    ["OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_METRICS_ENDPOINT"];

/// Returns the variables that name a collector, with their values.
#[must_use]
pub fn name_collectors() -> Vec<(&'static str, String)> {
    let value = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    COLLECTORS.into_iter().filter_map(|name| Some((name, value(name)?))).collect()
}

/// Returns the hosts of the collectors.
#[must_use]
pub fn list_collector_hosts() -> Vec<String> {
    let mut hosts: Vec<String> = name_collectors().iter().map(|(_, url)| host_of(url)).collect();
    hosts.sort();
    hosts.dedup();
    hosts
}

impl std::fmt::Debug for MailTo {
    /// Omits the URL, which may contain a password.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Folder(folder) => f.debug_tuple("Folder").field(folder).finish(),
            Self::Smtp(_) => f.write_str("Smtp(…)"),
        }
    }
}

/// A limit on the number and size of uploads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UploadQuota {
    /// Number of uploads.
    pub uploads: u64,
    /// Total size, in bytes.
    pub bytes: u64,
}

/// Configuration of the service.
#[derive(Clone, Debug)]
pub struct Config {
    /// Address to listen on.
    pub listen: SocketAddr,
    /// Data folder: everything that the service stores.
    pub data_dir: PathBuf,
    /// Key folder; several replicas may share one.
    pub keys_dir: PathBuf,
    /// Database.
    pub database: DatabaseAddress,
    /// Folder of the recordings; with a bucket, a staging area for files on their way to it.
    pub recordings_dir: PathBuf,
    /// Bucket of the recordings, if they are not stored in the folder.
    pub bucket: Option<BucketAddress>,
    /// A reverse proxy terminates TLS and sets `X-Forwarded-For`: cookies are `Secure`, and the
    /// header is trusted for the client's address.
    pub behind_tls: bool,
    /// Bearer token required by `/metrics`. Without one, `/metrics` is served only if no proxy is
    /// in front.
    pub metrics_token: Option<String>,
    /// Maximum size of an upload, in bytes.
    pub max_upload_bytes: u64,
    /// Maximum number of recordings scored concurrently, at least 1.
    pub judges: usize,
    /// Sandboxed process that scores recordings; `None` to score in this process.
    pub helper: Option<Helper>,
    /// Time limit for previewing a draft; applies only with a helper.
    pub preview_time: Duration,
    /// Malware scanner for uploads; `None` disables scanning.
    pub scanner: Option<Scanner>,
    /// Free space on the disk of the recordings, in bytes, below which uploads are rejected.
    pub reserve_bytes: u64,
    /// Free space on the disk of the data folder, in bytes, reserved for the database.
    pub database_reserve_bytes: u64,
    /// Limit on the unfinished resumable uploads of one owner, by number and announced size.
    pub owner_quota: UploadQuota,
    /// The same limit for all owners of a school together.
    pub school_quota: UploadQuota,
    /// Limit on the attempts accepted from one person within 24 hours, by number and size of their
    /// recordings.
    pub person_quota: UploadQuota,
    /// Maximum time without data before the reception of a request body is aborted.
    pub upload_silence: Duration,
    /// How long an unfinished resumable upload is kept after its last chunk, in s.
    pub upload_lifetime_s: i64,
    /// Cost parameters of password hashing.
    pub password_cost: PasswordCost,
    /// Destination of outgoing mail.
    pub mail: MailTo,
    /// Sender address of outgoing mail.
    pub mail_from: String,
    /// Address to which the daily audit checkpoint is mailed, if any.
    pub anchor_mail: Option<String>,
    /// Public URL of this service, without a trailing slash, if configured.
    pub public_url: Option<String>,
    /// Origins whose pages may upload with a token, as browsers write them in `Origin`.
    pub allowed_origins: Vec<String>,
    /// Permitted targets of outgoing requests.
    pub outgoing: OutgoingRules,
}

/// An option with an invalid value.
#[derive(Debug, thiserror::Error)]
#[error("{option}: \"{value}\"; {allowed}")]
pub struct ConfigError {
    /// The option.
    pub option: &'static str,
    /// Its value.
    pub value: String,
    /// Description of the allowed values.
    pub allowed: &'static str,
}

impl Config {
    /// Returns the defaults: everything in one folder, listening on the loopback interface only.
    #[must_use]
    pub fn in_folder(data_dir: &Path) -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            data_dir: data_dir.to_owned(),
            keys_dir: data_dir.to_owned(),
            database: DatabaseAddress::in_folder(data_dir),
            recordings_dir: data_dir.join("recordings"),
            bucket: None,
            behind_tls: false,
            metrics_token: None,
            max_upload_bytes: 512 * 1024 * 1024,
            owner_quota: UploadQuota { uploads: 32, bytes: 4_000_000_000 },
            school_quota: UploadQuota { uploads: 2000, bytes: 100_000_000_000 },
            person_quota: UploadQuota { uploads: 500, bytes: 20_000_000_000 },
            judges: 1,
            helper: None,
            preview_time: Duration::from_secs(10),
            scanner: None,
            reserve_bytes: 1_000_000_000,
            database_reserve_bytes: 200_000_000,
            upload_silence: Duration::from_secs(30),
            upload_lifetime_s: 48 * 3600,
            password_cost: PasswordCost::RECOMMENDED,
            mail: MailTo::Folder(data_dir.join("mail")),
            mail_from: "Stylet <stylet@localhost>".to_owned(),
            anchor_mail: None,
            public_url: None,
            allowed_origins: Vec::new(),
            outgoing: OutgoingRules::default(),
        }
    }

    /// Sets where recordings are stored.
    pub fn keep_recordings_in(&mut self, place: RecordingsPlace) {
        match place {
            RecordingsPlace::Folder(folder) => self.recordings_dir = folder,
            RecordingsPlace::Bucket(address) => {
                self.recordings_dir = self.data_dir.join("passing");
                self.bucket = Some(address);
            }
        }
    }

    /// Returns the base URL of links in mails: the public URL if configured, else the listening
    /// address.
    #[must_use]
    pub fn address(&self) -> String {
        self.public_url.clone().unwrap_or_else(|| format!("http://{}", self.listen))
    }

    /// Returns the folder of uploads that have not been acknowledged yet.
    #[must_use]
    pub fn uploads_dir(&self) -> PathBuf {
        // On the same file system as the recordings, so that a finished upload is moved by a
        // rename.
        self.recordings_dir.join(".uploads")
    }

    /// Returns the folder into which a backup is unpacked. It is next to the recordings, so that
    /// they are moved by a rename within one file system.
    #[must_use]
    pub fn restoring_dir(&self) -> PathBuf {
        self.recordings_dir.with_extension("restoring")
    }

    /// Returns the folder of derived replay files. It is a cache and may be deleted at any time.
    #[must_use]
    pub fn replays_dir(&self) -> PathBuf {
        self.data_dir.join("replays")
    }
}

/// Parses a database address.
///
/// # Errors
/// Fails if it names an engine that this program was not built with.
pub fn database_address(given: &str) -> Result<DatabaseAddress, ConfigError> {
    DatabaseAddress::parse(given).map_err(|AddressRefused { address }| ConfigError {
        option: "--database",
        value: address,
        allowed: AddressRefused::ALLOWED,
    })
}

/// Parses a mail destination: an `smtp:` or `smtps:` URL, or a folder.
///
/// # Errors
/// Fails for any other URL scheme.
pub fn mail_to(given: &str) -> Result<MailTo, ConfigError> {
    match given.split_once("://") {
        Some(("smtp" | "smtps", _)) => Ok(MailTo::Smtp(given.to_owned())),
        Some((scheme, _)) => Err(ConfigError {
            option: "--mail",
            value: format!("{scheme}://…"),
            allowed: "allowed: an smtp:// or smtps:// URL, or a folder",
        }),
        None => Ok(MailTo::Folder(PathBuf::from(given))),
    }
}

/// Parses the address to which audit checkpoints are mailed.
///
/// # Errors
/// Fails if it is not a mail address.
pub fn anchor_mail(given: &str) -> Result<String, ConfigError> {
    let refused = || ConfigError {
        option: "--anchor-mail",
        value: given.to_owned(),
        allowed: "allowed: an email address such as audit@example.org",
    };
    if is_email(given) { Ok(given.to_owned()) } else { Err(refused()) }
}

/// Parses an origin and normalizes it as browsers do: `https://lab.example.org`, with a port only
/// if it is not the default of the scheme.
///
/// # Errors
/// Fails if it is not an origin, or contains a wildcard.
pub fn origin(given: &str) -> Result<String, ConfigError> {
    let refused = || ConfigError {
        option: "--allow-origin",
        value: given.to_owned(),
        allowed: "allowed: a scheme and a host, such as https://lab.example.org or http://localhost:3000, without a path",
    };
    let text = given.to_ascii_lowercase();
    let uri: Uri = text.parse().map_err(|_| refused())?;
    let (scheme, host) = uri.scheme_str().zip(uri.host()).ok_or_else(refused)?;
    let own_port = match scheme {
        "http" => 80,
        "https" => 443,
        _ => return Err(refused()),
    };
    let port = uri.port_u16().map(|port| format!(":{port}")).unwrap_or_default();
    if text != format!("{scheme}://{host}{port}") || host.contains('*') {
        return Err(refused());
    }
    Ok(if uri.port_u16() == Some(own_port) { format!("{scheme}://{host}") } else { text })
}

/// Where recordings are stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingsPlace {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket.
    Bucket(BucketAddress),
}

/// Parses where recordings are stored: a path, a `file://` URL, or an `s3://` URL of a bucket whose
/// credentials are in the environment.
///
/// # Errors
/// Fails for any other URL scheme, or if this program was built without buckets.
pub fn recordings_place(
    given: &str,
    environment: impl IntoIterator<Item = (String, String)>,
) -> Result<RecordingsPlace, ConfigError> {
    #[cfg(feature = "replicas")]
    const ALLOWED: &str =
        "allowed: a path, a file:// URL, or s3://BUCKET/PREFIX of letters, digits, \"-\", \"_\", \".\" and \"/\"";
    #[cfg(not(feature = "replicas"))]
    const ALLOWED: &str = crate::bucket_address::UNBUILT;
    let refused = |scheme| ConfigError { option: "--recordings", value: format!("{scheme}://…"), allowed: ALLOWED };
    match given.split_once("://") {
        Some(("file", path)) => Ok(RecordingsPlace::Folder(PathBuf::from(path))),
        Some(("s3", address)) if cfg!(feature = "replicas") => {
            let address = BucketAddress::parse(address, environment);
            address.map(RecordingsPlace::Bucket).ok_or_else(|| refused("s3"))
        }
        Some((scheme, _)) => Err(refused(scheme)),
        None => Ok(RecordingsPlace::Folder(PathBuf::from(given))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_database_is_refused_without_repeating_its_password() {
        let refused = database_address("mysql://user:secret@host/db").unwrap_err().to_string();
        assert!(refused.contains("--database") && !refused.contains("secret"), "{refused}");
    }

    #[test]
    fn mail_target_is_a_server_or_folder_and_hides_its_password() {
        let smtp = mail_to("smtps://user:secret@mail.example").unwrap();
        assert!(!format!("{smtp:?}").contains("secret"), "{smtp:?}");
        assert_eq!(mail_to("out").unwrap(), MailTo::Folder(PathBuf::from("out")));
        let refused = mail_to("https://user:secret@mail.example").unwrap_err().to_string();
        assert!(refused.contains("--mail") && !refused.contains("secret"), "{refused}");
    }

    #[test]
    fn an_origin_is_one_place_and_written_as_browsers_do() {
        let written = |given: &str| origin(given).unwrap();
        assert_eq!(written("https://Lab.Example.org:443"), "https://lab.example.org");
        assert_eq!(
            [written("http://localhost:3000"), written("http://[::1]:80")],
            ["http://localhost:3000", "http://[::1]"]
        );
        for nonsense in [
            "*",
            "null",
            "",
            "lab.example.org",
            "https://lab.example.org/",
            "https://a@b.c",
            "ftp://b.c",
            "https://*.b.c",
        ] {
            let refused = origin(nonsense).unwrap_err().to_string();
            assert!(refused.contains("--allow-origin") && refused.contains(nonsense), "{refused}");
        }
    }

    #[test]
    fn recordings_lie_in_a_folder_or_a_bucket() {
        let place = |given| recordings_place(given, []);
        assert_eq!(place("file:///r").unwrap(), RecordingsPlace::Folder(PathBuf::from("/r")));
        assert_eq!(place("r").unwrap(), RecordingsPlace::Folder(PathBuf::from("r")));
        #[cfg(feature = "replicas")]
        assert!(
            matches!(place("s3://bucket/north"), Ok(RecordingsPlace::Bucket(at)) if at.to_string() == "s3://bucket/north")
        );
        #[cfg(not(feature = "replicas"))]
        assert!(place("s3://bucket/north").unwrap_err().to_string().contains("--features replicas"));
        for refused in ["s3://", "s3://user:secret@bucket", "https://user:secret@host/bucket"] {
            let said = place(refused).unwrap_err().to_string();
            assert!(said.contains("--recordings") && !said.contains("secret"), "{said}");
        }
    }
}
