//! A dump that `pg_dump` has made, put into a database of its own beside the one that is served, to be looked at.

use std::path::Path;
use std::process::{Command, Stdio};

use sqlx::{AssertSqlSafe, ConnectOptions};
use uuid::Uuid;

use super::address::{DatabaseAddress, EngineKind};
use super::{DumpRefused, postgres};
use crate::{Database, Result};

/// What the names of such databases begin with.
const PREFIX: &str = "stylet_dump_";

/// A dump in a database of its own, which goes by [`Self::remove`]: one that is left over by a death has a name that tells.
#[derive(Debug)]
pub struct DumpedDatabase {
    database: Database,
    name: String,
    beside: DatabaseAddress,
}

impl DumpedDatabase {
    /// Puts a dump into a new database of a server, as `pg_restore` reads it, and brings that up to date.
    ///
    /// # Errors
    /// When it is no server, no database can be made there, or what is in the file is no dump, or not whole.
    pub async fn restore(file: &Path, beside: &DatabaseAddress) -> std::result::Result<Self, DumpRefused> {
        if beside.kind() == EngineKind::Sqlite {
            return Err(DumpRefused::on_sqlite(file));
        }
        let refused = |why: String| DumpRefused { file: file.to_owned(), why };
        let name = format!("{PREFIX}{}", Uuid::new_v4().simple());
        let program = beside.for_program(&name).ok_or_else(|| {
            refused(format!("{beside}: its password cannot be told to pg_restore; put it into PGPASSWORD or ~/.pgpass"))
        })?;
        let made = async { beside.sibling(&name)?.make_anew().await };
        made.await.map_err(|error| refused(format!("{beside}: no database can be made to look at it in: {error}")))?;
        let opened = async {
            let file = file.to_owned();
            let put = tokio::task::spawn_blocking(move || put_dump(&file, &program.0, program.1.as_deref()));
            put.await.map_err(|error| error.to_string())??;
            let opened = async { Database::open(&beside.sibling(&name)?).await };
            let database = opened.await.map_err(|error| error.to_string())?;
            database
                .migrate()
                .await
                .map_err(|error| format!("what is in it is no database of the service: {error}"))?;
            Ok::<_, String>(database)
        };
        match opened.await {
            Ok(database) => Ok(Self { database, name, beside: beside.clone() }),
            Err(why) => {
                // The first failure is told.
                let _ = drop_database(beside, &name).await;
                Err(refused(why))
            }
        }
    }

    /// What the dump holds.
    #[must_use]
    pub const fn database(&self) -> &Database {
        &self.database
    }

    /// Removes the database that was made for it.
    ///
    /// # Errors
    /// When the server does not answer.
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

/// Has `pg_restore` do it, in one transaction; what it says where it does not. Blocks.
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
