//! Moves a database between SQLite and PostgreSQL.

use std::collections::BTreeSet;
use std::path::PathBuf;

use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnection;
use sqlx::{ConnectOptions, Connection as _, Postgres, Sqlite, SqliteConnection};

use super::columns::{TablePlan, list_tables};
use super::postgres_end::TableSender;
use super::sqlite_end::TableWriter;
use super::{CarriedTable, MoveError, postgres_end, sqlite_end};
use crate::engine::{AddressRefused, EngineKind, WRITING, migrations, postgres_options, without_password};
use crate::locks::{FileLock, LockError};
use crate::recordings::sessions::{RECORDINGS, RecordingFile};
use crate::{Connection, Database, DatabaseAddress, DatabaseLock, Result};

/// Direction of the move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MoveDirection {
    ToPostgres,
    ToSqlite,
}

/// Source and target of a move.
#[derive(Clone, Debug)]
pub struct DatabaseMove {
    file: PathBuf,
    server: DatabaseAddress,
    direction: MoveDirection,
}

/// A lock on one of the databases, held until dropped.
#[derive(Debug)]
pub struct MoveLock {
    _held: HeldEnd,
}

#[derive(Debug)]
#[expect(dead_code, reason = "they are held, not read")]
enum HeldEnd {
    File(FileLock),
    Server(DatabaseLock),
}

impl DatabaseMove {
    /// Parses two addresses: one of SQLite, as a `sqlite:` URL or a path, and one of PostgreSQL.
    ///
    /// # Errors
    /// If both name the same engine, or one names an unsupported engine.
    pub fn parse(from: &str, to: &str) -> std::result::Result<Self, MoveError> {
        let (file, server, direction) = match (EngineKind::of(from), EngineKind::of(to)) {
            (Some(EngineKind::Sqlite), Some(EngineKind::Postgres)) => (from, to, MoveDirection::ToPostgres),
            (Some(EngineKind::Postgres), Some(EngineKind::Sqlite)) => (to, from, MoveDirection::ToSqlite),
            _ => {
                let why = "allowed: one SQLite database, a sqlite: URL or a path, and one PostgreSQL database, a postgres:// URL; between two databases of one engine, use `web-admin backup` and `restore`, or the server's own tools";
                let place = format!("--from {} --to {}", without_password(from), without_password(to));
                return Err(MoveError::Refused { place, why: why.to_owned() });
            }
        };
        let server = DatabaseAddress::parse(server).map_err(|refused| MoveError::Refused {
            place: refused.address,
            why: AddressRefused::ALLOWED.to_owned(),
        })?;
        let file = sqlite_end::parse_file(file).map_err(|why| MoveError::Failed { place: file.to_owned(), why })?;
        Ok(Self { file, server, direction })
    }

    /// Returns the source, in a form suitable for messages.
    #[must_use]
    pub fn source(&self) -> String {
        match self.direction {
            MoveDirection::ToPostgres => self.file_name(),
            MoveDirection::ToSqlite => self.server.to_string(),
        }
    }

    /// Returns the target, in a form suitable for messages.
    #[must_use]
    pub fn target(&self) -> String {
        match self.direction {
            MoveDirection::ToPostgres => self.server.to_string(),
            MoveDirection::ToSqlite => self.file_name(),
        }
    }

    fn file_name(&self) -> String {
        self.file.display().to_string()
    }

    /// Takes the exclusive lock on the source. `holder` names this process in the error messages of
    /// others.
    ///
    /// # Errors
    /// If another process holds the lock, or it cannot be taken.
    pub async fn hold_source(&self, holder: &str) -> std::result::Result<MoveLock, LockError> {
        self.hold(self.direction == MoveDirection::ToPostgres, holder).await
    }

    /// Takes the exclusive lock on the target. `holder` names this process in the error messages of
    /// others.
    ///
    /// # Errors
    /// If another process holds the lock, or it cannot be taken.
    pub async fn hold_target(&self, holder: &str) -> std::result::Result<MoveLock, LockError> {
        self.hold(self.direction == MoveDirection::ToSqlite, holder).await
    }

    async fn hold(&self, file: bool, holder: &str) -> std::result::Result<MoveLock, LockError> {
        let held = if file {
            HeldEnd::File(FileLock::take_beside(&self.file, holder)?)
        } else {
            HeldEnd::Server(Database::hold(&self.server, holder).await?)
        };
        Ok(MoveLock { _held: held })
    }

    async fn open_file(&self) -> std::result::Result<SqliteConnection, MoveError> {
        let opened = sqlite_end::open_file(&self.file, self.direction == MoveDirection::ToSqlite).await;
        opened.map_err(|why| MoveError::Failed { place: self.file_name(), why })
    }

    async fn connect(&self) -> std::result::Result<PgConnection, MoveError> {
        let connect = async { postgres_options(&self.server)?.connect().await };
        connect.await.map_err(|why| MoveError::Failed { place: self.server.to_string(), why })
    }

    fn refuse_source(&self, why: impl Into<String>) -> MoveError {
        MoveError::Refused { place: self.source(), why: why.into() }
    }

    /// Checks source and target, and creates the missing tables of the target.
    ///
    /// # Errors
    /// If the source is not a database of the service or has another schema version than this
    /// program, if the target is not empty, or if one of them does not respond.
    pub async fn prepare(&self) -> std::result::Result<(), MoveError> {
        let (mut file, mut server) = (self.open_file().await?, self.connect().await?);
        let failed_source = |why| MoveError::Failed { place: self.source(), why };
        let failed_target = |why| MoveError::Failed { place: self.target(), why };
        match self.direction {
            MoveDirection::ToPostgres => {
                let newest = sqlite_end::newest_migration(&mut file).await.map_err(failed_source)?;
                self.check_version(newest, migrations(EngineKind::Sqlite))?;
                self.refuse_rows(postgres_end::holds_rows(&mut server).await.map_err(failed_target)?)?;
                migrations(EngineKind::Postgres).run(&mut server).await.map_err(|why| failed_target(why.into()))
            }
            MoveDirection::ToSqlite => {
                let newest = postgres_end::newest_migration(&mut server).await.map_err(failed_source)?;
                self.check_version(newest, migrations(EngineKind::Postgres))?;
                self.refuse_rows(sqlite_end::holds_rows(&mut file).await.map_err(failed_target)?)?;
                migrations(EngineKind::Sqlite).run(&mut file).await.map_err(|why| failed_target(why.into()))
            }
        }
    }

    fn check_version(&self, newest: Option<i64>, known: &Migrator) -> std::result::Result<(), MoveError> {
        let own = known.iter().map(|migration| migration.version).max();
        match newest {
            None => Err(self.refuse_source("it contains no database of the service")),
            newest if newest < own => Err(self.refuse_source(
                "this database is of an earlier version; run `web-admin migrate` of a program of this version that is built for it",
            )),
            newest if newest > own => Err(self.refuse_source("this database is of a newer version; move it with the newer program")),
            _ => Ok(()),
        }
    }

    fn refuse_rows(&self, holds_rows: bool) -> std::result::Result<(), MoveError> {
        let why = "it contains a school; allowed: an empty database, because a move never overwrites data";
        if holds_rows { Err(MoveError::Refused { place: self.target(), why: why.to_owned() }) } else { Ok(()) }
    }

    /// Returns all recordings in the source, which may be in use meanwhile.
    ///
    /// # Errors
    /// If the source does not respond.
    pub async fn list_recordings(&self) -> std::result::Result<Vec<RecordingFile>, MoveError> {
        let listed = match self.direction {
            MoveDirection::ToPostgres => {
                sqlx::query_as::<Sqlite, _>(RECORDINGS).fetch_all(&mut self.open_file().await?).await
            }
            MoveDirection::ToSqlite => {
                sqlx::query_as::<Postgres, _>(RECORDINGS).fetch_all(&mut self.connect().await?).await
            }
        };
        listed.map_err(|why| MoveError::Failed { place: self.source(), why })
    }

    /// Copies all rows and compares the tables of both databases. Both are locked for writing
    /// meanwhile, and nothing is committed before [`CarriedRows::keep`]: a move that is interrupted
    /// earlier changes nothing.
    ///
    /// # Errors
    /// Same as [`Self::prepare`]; also if the other engine cannot store a value, a database does
    /// not respond, or the disk is full.
    pub async fn carry(&self) -> std::result::Result<CarriedRows, MoveError> {
        self.prepare().await?;
        let (mut file, mut server) = (self.open_file().await?, self.connect().await?);
        let failed_file = |why| MoveError::Failed { place: self.file_name(), why };
        let failed = |why| MoveError::Failed { place: format!("{} to {}", self.source(), self.target()), why };
        sqlite_end::execute(&mut file, "BEGIN IMMEDIATE").await.map_err(failed_file)?;
        self.begin_on_server(&mut server).await.map_err(failed)?;
        let plans = list_tables(&mut server).await.map_err(failed)?.map_err(|why| self.refuse_source(why))?;
        self.compare_columns(&sqlite_end::list_columns(&mut file).await.map_err(failed_file)?, &plans)?;
        let carried = match self.direction {
            MoveDirection::ToPostgres => carry_to_postgres(&mut file, &mut server, &plans).await,
            MoveDirection::ToSqlite => carry_to_sqlite(&mut file, &mut server, &plans).await,
        };
        let (tables, findings) = carried.map_err(failed)?;
        let (file, server) = (Connection::Sqlite(file), Connection::Postgres(server));
        let (source, target) = match self.direction {
            MoveDirection::ToPostgres => (file, server),
            MoveDirection::ToSqlite => (server, file),
        };
        let mut carried = CarriedRows { source, target, tables, findings, forgotten_uploads: 0 };
        carried.forgotten_uploads = carried.forget_uploads().await.map_err(failed)?;
        Ok(carried)
    }

    /// Locks the server's database for writing until the connection ends, and begins a transaction
    /// that reads a consistent snapshot.
    async fn begin_on_server(&self, server: &mut PgConnection) -> Result<()> {
        // The lock comes before the transaction, whose snapshot is taken at its first statement.
        sqlx::query("SELECT pg_advisory_lock($1)").bind(WRITING).execute(&mut *server).await?;
        let begin = match self.direction {
            MoveDirection::ToPostgres => "BEGIN",
            MoveDirection::ToSqlite => "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY",
        };
        postgres_end::execute(server, begin).await.map(drop)
    }

    /// Returns an error if the columns of the databases differ: values would be lost.
    fn compare_columns(&self, on_file: &[String], plans: &[TablePlan]) -> std::result::Result<(), MoveError> {
        let on_file: BTreeSet<String> = on_file.iter().cloned().collect();
        let own = |plan: &TablePlan| {
            let columns = plan.columns.iter().filter(|column| !(plan.counts_arrivals && column.name == ARRIVAL));
            columns.map(|column| format!("{}.{}", plan.name, column.name)).collect::<Vec<_>>()
        };
        let on_server: BTreeSet<String> = plans.iter().flat_map(own).collect();
        match on_file.symmetric_difference(&on_server).next() {
            None => Ok(()),
            Some(column) => Err(self.refuse_source(format!("{column}: only one of the two databases has this column"))),
        }
    }
}

/// The column that PostgreSQL needs for the order of insertion, which SQLite provides implicitly.
const ARRIVAL: &str = "rowid";

async fn carry_to_postgres(
    file: &mut SqliteConnection,
    server: &mut PgConnection,
    plans: &[TablePlan],
) -> Result<(Vec<CarriedTable>, Vec<String>)> {
    let references = postgres_end::make_room(server, plans).await?;
    let mut read = Vec::new();
    for plan in plans {
        let mut sender = TableSender::begin(server, plan).await?;
        read.push(sqlite_end::read_table(file, plan, async |row| sender.write(row).await).await?);
        sender.finish().await?;
    }
    postgres_end::settle(server, plans, references).await?;
    let mut written = Vec::new();
    for plan in plans {
        written.push(postgres_end::read_table(server, plan, async |_| Ok(())).await?);
    }
    let findings = compare_tables(&read, &written);
    Ok((read, findings))
}

async fn carry_to_sqlite(
    file: &mut SqliteConnection,
    server: &mut PgConnection,
    plans: &[TablePlan],
) -> Result<(Vec<CarriedTable>, Vec<String>)> {
    let triggers = sqlite_end::make_room(file, plans).await?;
    let mut read = Vec::new();
    for plan in plans {
        let mut writer = TableWriter::new(file, plan);
        read.push(postgres_end::read_table(server, plan, async |row| writer.write(row).await).await?);
        writer.flush().await?;
    }
    let mut written = Vec::new();
    for plan in plans {
        written.push(sqlite_end::read_table(file, plan, async |_| Ok(())).await?);
    }
    let findings = [compare_tables(&read, &written), sqlite_end::settle(file, triggers).await?].concat();
    Ok((read, findings))
}

/// Returns a finding for each table that differs between the databases.
fn compare_tables(read: &[CarriedTable], written: &[CarriedTable]) -> Vec<String> {
    let differing = read.iter().zip(written).filter(|(read, written)| read != written);
    let words = |(read, written): (&CarriedTable, &CarriedTable)| {
        format!(
            "{}: read {} rows with hash {}, found {} with hash {}",
            read.name, read.rows, read.sha256, written.rows, written.sha256
        )
    };
    differing.map(words).collect()
}

/// Copied and compared rows in an uncommitted transaction.
#[derive(Debug)]
pub struct CarriedRows {
    source: Connection,
    target: Connection,
    tables: Vec<CarriedTable>,
    findings: Vec<String>,
    forgotten_uploads: u64,
}

impl CarriedRows {
    /// Returns the copied tables, as read from the source.
    #[must_use]
    pub fn tables(&self) -> &[CarriedTable] {
        &self.tables
    }

    /// Returns differences between the databases, and findings of the target's integrity check.
    #[must_use]
    pub fn findings(&self) -> &[String] {
        &self.findings
    }

    /// Returns the number of incomplete uploads, which are not copied. Their files stay in place;
    /// clients have to start these uploads again.
    #[must_use]
    pub fn forgotten_uploads(&self) -> u64 {
        self.forgotten_uploads
    }

    /// Returns the connection to the target.
    pub fn target(&mut self) -> &mut Connection {
        &mut self.target
    }

    async fn forget_uploads(&mut self) -> Result<u64> {
        let pieces = "DELETE FROM upload_pieces WHERE upload_id IN (SELECT id FROM uploads WHERE session_id IS NULL)";
        sqlx::query(pieces).execute(&mut self.target).await?;
        let uploads = "DELETE FROM uploads WHERE session_id IS NULL";
        Ok(sqlx::query(uploads).execute(&mut self.target).await?.rows_affected())
    }

    /// Commits the rows in the target. Without this call the target stays empty.
    ///
    /// # Errors
    /// If the target does not respond, or the disk is full.
    pub async fn keep(mut self) -> Result<()> {
        // The source stays locked until its connection ends, that is, until the rows are committed.
        sqlx::raw_sql("COMMIT").execute(&mut self.target).await?;
        self.source.close().await?;
        self.target.close().await
    }
}
