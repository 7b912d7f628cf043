//! Address of a database, as given with `--database`.

use std::fmt;
use std::path::Path;

use super::sqlite;

/// The supported engines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineKind {
    /// SQLite: a file.
    Sqlite,
    /// PostgreSQL: a server.
    #[cfg(feature = "postgres")]
    Postgres,
}

impl EngineKind {
    /// Returns the engine for a URL, by its scheme, or for a path. Returns `None` if the engine is
    /// not supported.
    pub(crate) fn of(given: &str) -> Option<Self> {
        match given.split_once(':') {
            Some(("sqlite", _)) => Some(Self::Sqlite),
            #[cfg(feature = "postgres")]
            Some(("postgres" | "postgresql", rest)) if rest.starts_with("//") => Some(Self::Postgres),
            Some((_, rest)) if rest.starts_with("//") => None,
            _ => Some(Self::Sqlite),
        }
    }
}

/// Address of a database, as its engine parses it. `Display` and `Debug` leave out the password.
#[derive(Clone, PartialEq, Eq)]
pub struct DatabaseAddress(String);

impl DatabaseAddress {
    /// Parses an address: for SQLite a `sqlite:` URL or a path, for PostgreSQL a `postgres:` URL.
    ///
    /// # Errors
    /// If the address names an unsupported engine.
    pub fn parse(given: &str) -> Result<Self, AddressRefused> {
        if EngineKind::of(given).is_none() {
            return Err(AddressRefused { address: without_password(given) });
        }
        Ok(Self(if given.contains(':') { given.to_owned() } else { sqlite::address_of(Path::new(given)) }))
    }

    /// Returns the address of the default database of a data folder.
    #[must_use]
    pub fn in_folder(folder: &Path) -> Self {
        Self(sqlite::address_of(&folder.join("stylet.db")))
    }

    /// Returns the engine.
    #[must_use]
    pub fn kind(&self) -> EngineKind {
        EngineKind::of(&self.0).unwrap_or(EngineKind::Sqlite)
    }

    /// Returns the URL, including the password. Pass it to child processes in their environment;
    /// never log or show it.
    #[must_use]
    pub fn as_url(&self) -> &str {
        &self.0
    }

    /// Returns the address of another database on the same server, without the password, for the
    /// command line of PostgreSQL's tools, and the password, which is passed in the environment.
    /// Returns `None` if the password cannot be separated from the address.
    #[cfg(feature = "postgres")]
    pub(super) fn for_program(&self, database: &str) -> Option<(String, Option<String>)> {
        let (scheme, rest) = self.0.split_once("://")?;
        let (place, path) = rest.split_at(rest.find(['/', '?', '#']).unwrap_or(rest.len()));
        let query = path.split_once('?').map(|(_, query)| format!("?{query}")).unwrap_or_default();
        if path.contains('@') || query.contains("password") {
            return None;
        }
        let (who, host) = place.rsplit_once('@').map_or((None, place), |(who, host)| (Some(who), host));
        let (user, password) =
            who.map_or(("", None), |who| who.split_once(':').map_or((who, None), |(u, p)| (u, Some(p))));
        let at = if user.is_empty() { "" } else { "@" };
        let password =
            password.map(|password| percent_encoding::percent_decode_str(password).decode_utf8_lossy().into_owned());
        Some((format!("{scheme}://{user}{at}{host}/{database}{query}"), password))
    }

    /// Wraps a URL made by an engine's module.
    pub(super) fn of_url(url: String) -> Self {
        Self(url)
    }
}

impl fmt::Display for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&without_password(&self.0))
    }
}

impl fmt::Debug for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The address names an unsupported engine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AddressRefused {
    /// The address, without its password.
    pub address: String,
}

impl AddressRefused {
    /// Accepted addresses.
    #[cfg(feature = "postgres")]
    pub const ALLOWED: &str = "allowed: a sqlite: URL, a path, or a postgres:// URL";
    /// Accepted addresses, and how to build the program with support for PostgreSQL.
    #[cfg(not(feature = "postgres"))]
    pub const ALLOWED: &str = "this program is built for SQLite: allowed: a sqlite: URL or a path; for postgres:// URLs, build with `cargo build --release -p web-admin --features replicas`";
}

/// Returns an address that is safe to show: user, host and database, without the password and
/// without the query string, which may contain one. If the password may be in an unexpected place,
/// only the scheme is returned.
pub(crate) fn without_password(given: &str) -> String {
    let Some((scheme, rest)) = given.split_once("://").filter(|(scheme, _)| *scheme != "sqlite") else {
        return given.to_owned();
    };
    let (place, path) = rest.split_at(rest.find(['/', '?', '#']).unwrap_or(rest.len()));
    if path.contains('@') {
        return format!("{scheme}://…");
    }
    let path = path.split(['?', '#']).next().unwrap_or_default();
    match place.rsplit_once('@') {
        Some((who, host)) => format!("{scheme}://{}@{host}{path}", who.split(':').next().unwrap_or_default()),
        None => format!("{scheme}://{place}{path}"),
    }
}

#[cfg(test)]
mod tests {
    //! A password in an error message would end up in logs.

    use super::*;

    #[test]
    fn what_is_told_of_an_address_has_no_password() {
        for (given, told) in [
            ("postgres://ada:secret@host:5432/db", "postgres://ada@host:5432/db"),
            ("postgres://ada:se@cret@host/db?sslmode=require", "postgres://ada@host/db"),
            ("postgres://ada:se/cr?et@host/db", "postgres://…"),
            ("postgres:///db?user=ada&password=secret", "postgres:///db"),
            ("postgres:///db?user=ada&password=sec@ret", "postgres://…"),
            ("mysql://ada@host/db", "mysql://ada@host/db"),
            ("sqlite:///data/a@b.db?mode=ro", "sqlite:///data/a@b.db?mode=ro"),
            ("/data/x.db", "/data/x.db"),
        ] {
            assert_eq!(without_password(given), told);
        }
    }

    #[cfg(feature = "postgres")]
    #[test]
    fn what_a_program_is_told_on_its_command_line_has_no_password() {
        let told = |given: &str| DatabaseAddress::parse(given).unwrap().for_program("x");
        let with = |address: &str, password: Option<&str>| Some((address.to_owned(), password.map(str::to_owned)));
        assert_eq!(
            told("postgres://ada:s%40t@host:5/db?sslmode=require"),
            with("postgres://ada@host:5/x?sslmode=require", Some("s@t"))
        );
        assert_eq!(told("postgres://ada@%2Frun/db"), with("postgres://ada@%2Frun/x", None));
        assert_eq!(told("postgres:///db"), with("postgres:///x", None));
        for refused in ["postgres:///db?password=secret", "postgres://ada:se/cr@host/db"] {
            assert_eq!(told(refused), None);
        }
    }

    #[test]
    fn an_address_of_another_engine_is_refused() {
        assert_eq!(DatabaseAddress::parse("/data/x.db").unwrap().as_url(), "sqlite:///data/x.db");
        let given = "postgres://ada:secret@host/db";
        #[cfg(feature = "postgres")]
        assert!(!format!("{0} {0:?}", DatabaseAddress::parse(given).unwrap()).contains("secret"));
        #[cfg(not(feature = "postgres"))]
        assert_eq!(DatabaseAddress::parse(given).unwrap_err().address, "postgres://ada@host/db");
        assert_eq!(DatabaseAddress::parse("mysql://ada:secret@host/db").unwrap_err().address, "mysql://ada@host/db");
    }
}
