//! The parts of the service that know no school: configuration, keys, files, the object store,
//! queues, locks, mail, outgoing requests, the relying party of WebAuthn and the client of OpenID
//! Connect.

pub mod bounded_queue;
pub mod bucket_address;
pub mod clock;
pub mod config;
pub mod fail_points;
pub mod fair_scheduler;
pub mod files;
pub mod helper;
pub mod keys;
pub mod locks;
pub mod mailer;
pub mod openid;
pub mod outgoing;
pub mod rate_limit_log;
pub mod recording_store;
pub mod relying_party;
pub mod replay_files;
pub mod request_pace;
pub mod scanning;
pub mod sealing;
pub mod secret;
pub mod upload_locks;

/// Sets the default TLS crypto provider, for dependencies that do not choose one.
#[cfg(feature = "replicas")]
pub fn settle_tls() {
    // Fails only if a provider has been set already, which is fine.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
