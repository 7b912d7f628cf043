//! How the service was told to run.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use http::Uri;
use model::email::is_email;
use store::{AddressRefused, DatabaseAddress};

use crate::bucket_address::BucketAddress;
use crate::helper::Helper;
use crate::scanning::Scanner;
use crate::secret::PasswordCost;

/// Where mail goes.
#[derive(Clone, PartialEq, Eq)]
pub enum MailTo {
    /// Files in a folder.
    Folder(PathBuf),
    /// A server, as a `smtp:` or `smtps:` URL.
    Smtp(String),
}

impl std::fmt::Debug for MailTo {
    /// Without the URL, which may hold a password.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Folder(folder) => f.debug_tuple("Folder").field(folder).finish(),
            Self::Smtp(_) => f.write_str("Smtp(…)"),
        }
    }
}

/// How many uploads, and how many bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UploadQuota {
    /// Uploads.
    pub uploads: u64,
    /// Bytes in all.
    pub bytes: u64,
}

/// How the service runs.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where to listen.
    pub listen: SocketAddr,
    /// Folder for everything the service keeps.
    pub data_dir: PathBuf,
    /// Folder of the keys, which several services may share.
    pub keys_dir: PathBuf,
    /// Database.
    pub database: DatabaseAddress,
    /// Folder for recordings; where they lie in a bucket, for what is on its way there.
    pub recordings_dir: PathBuf,
    /// The bucket that recordings lie in, where they do not lie in the folder.
    pub bucket: Option<BucketAddress>,
    /// A proxy in front speaks TLS and sets `X-Forwarded-For`: cookies are `Secure`, and its word for the client's
    /// address is believed.
    pub behind_tls: bool,
    /// What `/metrics` asks for as a bearer token. Without one it is answered only where no proxy is in front.
    pub metrics_token: Option<String>,
    /// Largest upload, in bytes.
    pub max_upload_bytes: u64,
    /// How many recordings are judged at once, 1 or more.
    pub judges: usize,
    /// Who judges recordings in a process of its own; none where this process does.
    pub helper: Option<Helper>,
    /// Longest that looking what a draft comes to may take, where a helper looks.
    pub preview_time: Duration,
    /// Who scans what arrives for malware; none where nobody does.
    pub scanner: Option<Scanner>,
    /// Free room on the disk of the recordings, in bytes, below which no upload is taken.
    pub reserve_bytes: u64,
    /// Free room on the disk of the data folder, in bytes, that nothing but the database may take.
    pub database_reserve_bytes: u64,
    /// Uploads in pieces that an owner may have begun and not ended, and their announced bytes.
    pub owner_quota: UploadQuota,
    /// As many of all owners of a school together.
    pub school_quota: UploadQuota,
    /// Attempts of a person that are taken within 24 hours, and the bytes of all their recordings.
    pub person_quota: UploadQuota,
    /// Longest silence within a body before it is given up.
    pub upload_silence: Duration,
    /// How long an upload in pieces is kept after its last piece, in s.
    pub upload_lifetime_s: i64,
    /// What it costs to hash a password.
    pub password_cost: PasswordCost,
    /// Where mail goes.
    pub mail: MailTo,
    /// Whom mail is from.
    pub mail_from: String,
    /// Who is mailed each day by which hash the audit log ends.
    pub anchor_mail: Option<String>,
    /// Where people find this service, without a slash at its end, where it was told.
    pub public_url: Option<String>,
    /// Origins whose pages may upload with a token, as a browser names them.
    pub allowed_origins: Vec<String>,
}

/// An option whose value cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{option}: \"{value}\"; {allowed}")]
pub struct ConfigError {
    /// The option.
    pub option: &'static str,
    /// Its value.
    pub value: String,
    /// What is allowed.
    pub allowed: &'static str,
}

impl Config {
    /// Everything in one folder, listening on this machine only.
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
        }
    }

    /// Has recordings lie elsewhere.
    pub fn keep_recordings_in(&mut self, place: RecordingsPlace) {
        match place {
            RecordingsPlace::Folder(folder) => self.recordings_dir = folder,
            RecordingsPlace::Bucket(address) => {
                self.recordings_dir = self.data_dir.join("passing");
                self.bucket = Some(address);
            }
        }
    }

    /// What links begin with that leave the service: where people find it, or else where it listens.
    #[must_use]
    pub fn address(&self) -> String {
        self.public_url.clone().unwrap_or_else(|| format!("http://{}", self.listen))
    }

    /// Folder for uploads that are not acknowledged yet.
    #[must_use]
    pub fn uploads_dir(&self) -> PathBuf {
        // Beside the recordings, so that a finished upload is moved by a rename within one file system.
        self.recordings_dir.join(".uploads")
    }

    /// Where a backup is unpacked before its parts are moved to their places: beside the recordings, so that moving them is a
    /// rename within one file system.
    #[must_use]
    pub fn restoring_dir(&self) -> PathBuf {
        self.recordings_dir.with_extension("restoring")
    }

    /// Folder for what was made of recordings to replay them: it may be deleted at any time, and is made again.
    #[must_use]
    pub fn replays_dir(&self) -> PathBuf {
        self.data_dir.join("replays")
    }
}

/// A database as given: its address.
///
/// # Errors
/// When it is one of an engine that this program is not built for.
pub fn database_address(given: &str) -> Result<DatabaseAddress, ConfigError> {
    DatabaseAddress::parse(given).map_err(|AddressRefused { address }| ConfigError {
        option: "--database",
        value: address,
        allowed: AddressRefused::ALLOWED,
    })
}

/// Where mail goes, as given: a `smtp:` or `smtps:` URL, or a folder.
///
/// # Errors
/// When it is a URL of something else.
pub fn mail_to(given: &str) -> Result<MailTo, ConfigError> {
    match given.split_once("://") {
        Some(("smtp" | "smtps", _)) => Ok(MailTo::Smtp(given.to_owned())),
        Some((scheme, _)) => Err(ConfigError {
            option: "--mail",
            value: format!("{scheme}://…"),
            allowed: "allowed is a smtp:// or smtps:// URL, or a folder",
        }),
        None => Ok(MailTo::Folder(PathBuf::from(given))),
    }
}

/// Who is mailed the end of the audit log, as given: an address.
///
/// # Errors
/// When it is none.
pub fn anchor_mail(given: &str) -> Result<String, ConfigError> {
    let refused = || ConfigError {
        option: "--anchor-mail",
        value: given.to_owned(),
        allowed: "allowed is an address, as audit@example.org",
    };
    if is_email(given) { Ok(given.to_owned()) } else { Err(refused()) }
}

/// An origin as given, in the words of a browser: `https://lab.example.org`, with a port where it is not the scheme's own.
///
/// # Errors
/// When it is none, or stands for more than one.
pub fn origin(given: &str) -> Result<String, ConfigError> {
    let refused = || ConfigError {
        option: "--allow-origin",
        value: given.to_owned(),
        allowed: "allowed is a scheme and a host, as https://lab.example.org or http://localhost:3000, without a path",
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

/// Where recordings lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingsPlace {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket.
    Bucket(BucketAddress),
}

/// Where recordings lie, as given: a path, a `file://` URL, or a `s3://` URL of a bucket, to which the environment has the keys.
///
/// # Errors
/// When it is a URL of something else.
pub fn recordings_place(
    given: &str,
    environment: impl IntoIterator<Item = (String, String)>,
) -> Result<RecordingsPlace, ConfigError> {
    #[cfg(feature = "replicas")]
    const ALLOWED: &str =
        "allowed is a path, a file:// URL, or s3://BUCKET/PREFIX of letters, digits, \"-\", \"_\", \".\" and \"/\"";
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
    fn mail_goes_to_a_server_or_a_folder_and_its_password_is_never_shown() {
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
