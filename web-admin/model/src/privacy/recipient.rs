//! Systems outside the service that receive data if the school or the operator sets them up.

/// A kind of recipient, as the record of processing activities lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Recipient {
    /// A mail server.
    MailServer,
    /// An identity provider.
    IdentityProvider,
    /// A learning platform.
    LearningPlatform,
    /// A learning record store.
    RecordStore,
    /// An object store.
    ObjectStore,
    /// A database server.
    DatabaseServer,
    /// A virus scanner.
    VirusScanner,
    /// A collector of metrics.
    Collector,
}

impl Recipient {
    /// All kinds, in the order of the record.
    pub const ALL: [Self; 8] = [
        Self::MailServer,
        Self::IdentityProvider,
        Self::LearningPlatform,
        Self::RecordStore,
        Self::ObjectStore,
        Self::DatabaseServer,
        Self::VirusScanner,
        Self::Collector,
    ];

    /// Returns words of its row in the record: English and German.
    #[must_use]
    pub const fn words(self) -> [&'static str; 2] {
        match self {
            Self::MailServer => ["mail server", "Mailserver"],
            Self::IdentityProvider => ["(OpenID Connect)", "(OpenID Connect)"],
            Self::LearningPlatform => ["(LTI)", "(LTI)"],
            Self::RecordStore => ["(xAPI)", "(xAPI)"],
            Self::ObjectStore => ["object store", "Objektspeicher"],
            Self::DatabaseServer => ["(PostgreSQL)", "(PostgreSQL)"],
            Self::VirusScanner => ["virus scanner", "Virenscanner"],
            Self::Collector => ["(OTLP)", "(OTLP)"],
        }
    }

    /// Returns the recipient that a row of the record describes.
    #[must_use]
    pub fn of_row(first_cell: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|recipient| recipient.words().iter().any(|words| first_cell.contains(words)))
    }
}
