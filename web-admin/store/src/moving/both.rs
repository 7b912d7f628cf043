//! Both ends of a move.

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
use crate::sessions::{RECORDINGS, RecordingFile};
use crate::{Connection, Database, DatabaseAddress, DatabaseLock, Result};

/// Where rows go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MoveDirection {
    ToPostgres,
    ToSqlite,
}

/// The databases of a move, from which rows are carried and into which.
#[derive(Clone, Debug)]
pub struct DatabaseMove {
    file: PathBuf,
    server: DatabaseAddress,
    direction: MoveDirection,
}

/// One of both databases, held by this process until it is dropped.
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
    /// The databases that two addresses name: one of SQLite, as a `sqlite:` URL or a path, and one of PostgreSQL.
    ///
    /// # Errors
    /// When both are of one engine, or one is of neither.
    pub fn parse(from: &str, to: &str) -> std::result::Result<Self, MoveError> {
        let (file, server, direction) = match (EngineKind::of(from), EngineKind::of(to)) {
            (Some(EngineKind::Sqlite), Some(EngineKind::Postgres)) => (from, to, MoveDirection::ToPostgres),
            (Some(EngineKind::Postgres), Some(EngineKind::Sqlite)) => (to, from, MoveDirection::ToSqlite),
            _ => {
                let why = "allowed is one database of SQLite, a sqlite: URL or a path, and one of PostgreSQL, a postgres:// URL; between \
                           two of one engine `web-admin backup` and `restore` carry a school, or the server's own tools";
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

    /// In words for people: where rows come from.
    #[must_use]
    pub fn source(&self) -> String {
        match self.direction {
            MoveDirection::ToPostgres => self.file_name(),
            MoveDirection::ToSqlite => self.server.to_string(),
        }
    }

    /// In words for people: where they go.
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

    /// Keeps the source from every other process; `holder` tells them who has it.
    ///
    /// # Errors
    /// When another process has it, or it cannot be held.
    pub async fn hold_source(&self, holder: &str) -> std::result::Result<MoveLock, LockError> {
        self.hold(self.direction == MoveDirection::ToPostgres, holder).await
    }

    /// Keeps the target from every other process; `holder` tells them who has it.
    ///
    /// # Errors
    /// When another process has it, or it cannot be held.
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

    /// Makes the tables of the target where they are missing, and refuses what cannot be moved or moved into.
    ///
    /// # Errors
    /// When the source is none, or of another version than this program; when something is in the target; when one does not answer.
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
            None => Err(self.refuse_source("no database of the service is there")),
            newest if newest < own => Err(self.refuse_source(
                "an earlier program has kept this database; run `web-admin migrate` of one that is built for it and as new as this",
            )),
            newest if newest > own => Err(self.refuse_source("a newer program has kept this database; move it with that")),
            _ => Ok(()),
        }
    }

    fn refuse_rows(&self, holds_rows: bool) -> std::result::Result<(), MoveError> {
        let why = "a school is in it; allowed is a database that is empty, for a move never goes over data";
        if holds_rows { Err(MoveError::Refused { place: self.target(), why: why.to_owned() }) } else { Ok(()) }
    }

    /// Every recording that the source names. It may be served meanwhile.
    ///
    /// # Errors
    /// When the source does not answer.
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

    /// Carries every row and compares both tables. Nobody writes to either meanwhile, and nothing is kept before [`CarriedRows::keep`]:
    /// a move that is stopped before, however, has changed nothing.
    ///
    /// # Errors
    /// As [`Self::prepare`]; when a value is none that the other engine keeps, when a database does not answer, or has no room.
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

    /// Whoever writes waits until this connection ends, and what is read was there at one moment.
    async fn begin_on_server(&self, server: &mut PgConnection) -> Result<()> {
        // Before the transaction, whose moment is that of its first statement.
        sqlx::query("SELECT pg_advisory_lock($1)").bind(WRITING).execute(&mut *server).await?;
        let begin = match self.direction {
            MoveDirection::ToPostgres => "BEGIN",
            MoveDirection::ToSqlite => "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY",
        };
        postgres_end::execute(server, begin).await.map(drop)
    }

    /// Refuses databases that have not the same columns: what one lacks would be lost.
    fn compare_columns(&self, on_file: &[String], plans: &[TablePlan]) -> std::result::Result<(), MoveError> {
        let on_file: BTreeSet<String> = on_file.iter().cloned().collect();
        let own = |plan: &TablePlan| {
            let columns = plan.columns.iter().filter(|column| !(plan.counts_arrivals && column.name == ARRIVAL));
            columns.map(|column| format!("{}.{}", plan.name, column.name)).collect::<Vec<_>>()
        };
        let on_server: BTreeSet<String> = plans.iter().flat_map(own).collect();
        match on_file.symmetric_difference(&on_server).next() {
            None => Ok(()),
            Some(column) => Err(self.refuse_source(format!("{column}: only one of both databases has this column"))),
        }
    }
}

/// The column by which PostgreSQL counts rows as they arrive: SQLite does so unasked.
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

/// Tables that are not the same on both sides, each in words.
fn compare_tables(read: &[CarriedTable], written: &[CarriedTable]) -> Vec<String> {
    let differing = read.iter().zip(written).filter(|(read, written)| read != written);
    let words = |(read, written): (&CarriedTable, &CarriedTable)| {
        format!(
            "{}: {} rows of hash {} were read, {} of hash {} are there",
            read.name, read.rows, read.sha256, written.rows, written.sha256
        )
    };
    differing.map(words).collect()
}

/// Rows that are carried and compared, and not kept yet.
#[derive(Debug)]
pub struct CarriedRows {
    source: Connection,
    target: Connection,
    tables: Vec<CarriedTable>,
    findings: Vec<String>,
    forgotten_uploads: u64,
}

impl CarriedRows {
    /// What was carried, as both sides have it.
    #[must_use]
    pub fn tables(&self) -> &[CarriedTable] {
        &self.tables
    }

    /// Where both sides differ, and what the target's engine finds wrong with it.
    #[must_use]
    pub fn findings(&self) -> &[String] {
        &self.findings
    }

    /// Uploads that were not whole and are not in the target: their pieces stay where they are, and whoever sends them begins again.
    #[must_use]
    pub fn forgotten_uploads(&self) -> u64 {
        self.forgotten_uploads
    }

    /// The database that they were carried into.
    pub fn target(&mut self) -> &mut Connection {
        &mut self.target
    }

    async fn forget_uploads(&mut self) -> Result<u64> {
        let pieces = "DELETE FROM upload_pieces WHERE upload_id IN (SELECT id FROM uploads WHERE session_id IS NULL)";
        sqlx::query(pieces).execute(&mut self.target).await?;
        let uploads = "DELETE FROM uploads WHERE session_id IS NULL";
        Ok(sqlx::query(uploads).execute(&mut self.target).await?.rows_affected())
    }

    /// Keeps the rows in the target. Until this is called, and where it is not, nothing is in it.
    ///
    /// # Errors
    /// When the target does not answer, or has no room.
    pub async fn keep(mut self) -> Result<()> {
        // The source lets go when its connection ends: until the rows are kept, nobody writes to it.
        sqlx::raw_sql("COMMIT").execute(&mut self.target).await?;
        self.source.close().await?;
        self.target.close().await
    }
}
