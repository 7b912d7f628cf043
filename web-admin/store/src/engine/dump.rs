//! Restores a dump made by `pg_dump` into a temporary database on the same server, for
//! verification.

use std::path::Path;
use std::process::{Command, Stdio};

use sqlx::{AssertSqlSafe, ConnectOptions};
use uuid::Uuid;

use super::address::{DatabaseAddress, EngineKind};
use super::{DumpRefused, postgres};
use crate::{Database, Result};

/// Prefix of the names of temporary databases.
const PREFIX: &str = "stylet_dump_";

/// A dump restored into a temporary database, which [`Self::remove`] drops. A database left over
/// after a crash is recognizable by the prefix of its name.
#[derive(Debug)]
pub struct DumpedDatabase {
    database: Database,
    name: String,
    beside: DatabaseAddress,
}

impl DumpedDatabase {
    /// Restores a dump with `pg_restore` into a new database on the server of `beside`, and
    /// migrates it.
    ///
    /// # Errors
    /// If `beside` is not on a server, no database can be created there, or the file is not a
    /// complete dump.
    pub async fn restore(file: &Path, beside: &DatabaseAddress) -> std::result::Result<Self, DumpRefused> {
        if beside.kind() == EngineKind::Sqlite {
            return Err(DumpRefused::on_sqlite(file));
        }
        let refused = |why: String| DumpRefused { file: file.to_owned(), why };
        let name = format!("{PREFIX}{}", Uuid::new_v4().simple());
        let program = beside.for_program(&name).ok_or_else(|| {
            refused(format!("{beside}: the password cannot be passed to pg_restore; set PGPASSWORD or use ~/.pgpass"))
        })?;
        let made = async { beside.sibling(&name)?.make_anew().await };
        made.await.map_err(|error| refused(format!("{beside}: cannot create a temporary database: {error}")))?;
        let opened = async {
            let file = file.to_owned();
            let put = tokio::task::spawn_blocking(move || put_dump(&file, &program.0, program.1.as_deref()));
            put.await.map_err(|error| error.to_string())??;
            let opened = async { Database::open(&beside.sibling(&name)?).await };
            let database = opened.await.map_err(|error| error.to_string())?;
            database
                .migrate()
                .await
                .map_err(|error| format!("it does not contain a database of the service: {error}"))?;
            Ok::<_, String>(database)
        };
        match opened.await {
            Ok(database) => Ok(Self { database, name, beside: beside.clone() }),
            Err(why) => {
                // The first error is returned; an error of the clean-up is ignored.
                let _ = drop_database(beside, &name).await;
                Err(refused(why))
            }
        }
    }

    /// Returns the restored database.
    #[must_use]
    pub const fn database(&self) -> &Database {
        &self.database
    }

    /// Drops the temporary database.
    ///
    /// # Errors
    /// If the server does not respond.
    pub async fn remove(self) -> Result<()> {
        self.database.close().await;
        drop_database(&self.beside, &self.name).await
    }
}

async fn drop_database(beside: &DatabaseAddress, name: &str) -> Result<()> {
    let mut connection = postgres::options(beside)?.connect().await?;
    let statement = format!("DROP DATABASE IF EXISTS {name} WITH (FORCE)");
    sqlx::raw_sql(AssertSqlSafe(statement)).execute(&mut connection).await.map(drop)
}

/// Runs `pg_restore` in a single transaction. On failure the error contains its output. Blocks the
/// thread.
fn put_dump(file: &Path, address: &str, password: Option<&str>) -> std::result::Result<(), String> {
    let mut command = Command::new("pg_restore");
    command.args(["--exit-on-error", "--single-transaction", "--no-owner", "--no-privileges", "--dbname", address]);
    command.arg(file).stdin(Stdio::null()).stdout(Stdio::null());
    if let Some(password) = password {
        command.env("PGPASSWORD", password);
    }
    let done = command.output().map_err(|error| format!("pg_restore cannot be run: {error}"))?;
    let words = String::from_utf8_lossy(&done.stderr);
    if done.status.success() { Ok(()) } else { Err(words.lines().collect::<Vec<_>>().join("; ")) }
}
