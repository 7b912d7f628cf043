//! The database of a test's folder: a file in it, or where `STYLET_TEST_ENGINE` is `postgres` one of its own on a server that all tests
//! share, a copy of one that was migrated once.

use std::path::{Path, PathBuf};
use std::process::Command;

use platform::config::Config;
use sqlx::{AssertSqlSafe, Connection as _};
use store::{Connection, Database, DatabaseAddress, EngineKind};

/// The engine that the tests are run on.
pub fn engine() -> EngineKind {
    match std::env::var("STYLET_TEST_ENGINE").as_deref() {
        Err(_) | Ok("sqlite") => EngineKind::Sqlite,
        Ok("postgres") => EngineKind::Postgres,
        Ok(other) => panic!("STYLET_TEST_ENGINE={other}; allowed are sqlite and postgres"),
    }
}

/// Has that engine's own module do something.
macro_rules! chosen {
    ($does:ident($($given:expr),*) $(.$wait:tt)?) => {
        match engine() {
            EngineKind::Sqlite => on_sqlite::$does($($given),*)$(.$wait)?,
            EngineKind::Postgres => on_postgres::$does($($given),*)$(.$wait)?,
        }
    };
}

/// A service's configuration in a folder.
pub fn config_in(folder: &Path) -> Config {
    Config { database: address_of(folder), ..Config::in_folder(folder) }
}

/// The program on a data folder; arguments are to follow.
pub fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_web-admin"));
    command.env("STYLET_DATA_DIR", folder);
    chosen!(tell(&mut command, folder));
    command
}

/// Gives a service that has no database yet one with its schema: a copy of a file, where the engine has files. A server's database is a
/// copy already.
pub async fn place_schema(address: &DatabaseAddress) {
    if let Ok(file) = address.file()
        && !file.exists()
        && file.parent().is_some_and(Path::exists)
    {
        std::fs::copy(migrated_file().await, file).unwrap();
    }
}

/// A database that has been migrated from nothing, by the first process of this very program.
async fn migrated_file() -> PathBuf {
    let (program, folder) = (std::env::current_exe().unwrap(), Path::new(env!("CARGO_TARGET_TMPDIR")));
    let migrated = folder.join(program.file_name().unwrap()).with_extension("db");
    let modified = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified());
    let built = modified(&program).unwrap();
    if !modified(&migrated).is_ok_and(|made| made >= built) {
        let own = tempfile::tempdir_in(folder).unwrap();
        let db = Database::open(&DatabaseAddress::in_folder(own.path())).await.unwrap();
        db.migrate().await.unwrap();
        db.close().await;
        std::fs::rename(own.path().join("stylet.db"), &migrated).unwrap();
    }
    migrated
}

/// Where the database of a folder is.
pub fn address_of(folder: &Path) -> DatabaseAddress {
    chosen!(address_of(folder))
}

/// As a command is told of it.
pub fn url_of(folder: &Path) -> String {
    chosen!(url_of(folder))
}

/// Another text whenever another connection has changed the database.
pub async fn version(watch: &mut Connection) -> String {
    chosen!(version(watch).await)
}

/// Has a trigger of a table keep its promise no more.
pub fn drop_trigger(trigger: &str, table: &str) -> AssertSqlSafe<String> {
    AssertSqlSafe(chosen!(drop_trigger(trigger, table)))
}

/// Does what a trigger of the audit log forbids, which is as it was afterwards.
pub async fn shrink_audit_log(connection: &mut Connection, statement: &str) {
    sqlx::raw_sql(AssertSqlSafe(chosen!(shrinking(statement)))).execute(connection).await.unwrap();
}

/// Every row of a table, as text, in order.
pub async fn rows_of(db: &Database, table: &str) -> Vec<String> {
    chosen!(rows_of(db, table).await)
}

/// Gives a folder the database of another, which nobody has open.
pub fn copy_database(from: &Path, to: &Path) {
    chosen!(copy_database(from, to));
}

/// A connection to the database of a folder that writes whatever it is told.
pub async fn connect(folder: &Path) -> Connection {
    Connection::connect(&chosen!(url_of(folder))).await.unwrap()
}

mod on_sqlite {
    use super::{AssertSqlSafe, Command, Connection, Database, DatabaseAddress, Path};

    pub fn url_of(folder: &Path) -> String {
        format!("sqlite://{}", folder.join("stylet.db").display())
    }

    pub fn address_of(folder: &Path) -> DatabaseAddress {
        DatabaseAddress::in_folder(folder)
    }

    pub fn tell(_: &mut Command, _: &Path) {}

    pub async fn version(watch: &mut Connection) -> String {
        let version: i64 = sqlx::query_scalar("PRAGMA data_version").fetch_one(watch).await.unwrap();
        version.to_string()
    }

    pub fn drop_trigger(trigger: &str, _: &str) -> String {
        format!("DROP TRIGGER {trigger}")
    }

    pub fn shrinking(statement: &str) -> String {
        format!(
            "DROP TRIGGER audit_log_never_shrinks; {statement}; CREATE TRIGGER audit_log_never_shrinks BEFORE DELETE ON audit_log\n\
             BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END"
        )
    }

    pub async fn rows_of(db: &Database, table: &str) -> Vec<String> {
        let columns =
            format!("SELECT group_concat('quote(\"' || name || '\")', ' || ') FROM pragma_table_info('{table}')");
        let columns: String = sqlx::query_scalar(AssertSqlSafe(columns)).fetch_one(db.reader()).await.unwrap();
        let rows = format!("SELECT '{table} ' || {columns} FROM {table} ORDER BY 1");
        sqlx::query_scalar(AssertSqlSafe(rows)).fetch_all(db.reader()).await.unwrap()
    }

    /// The file is in the folder.
    pub fn copy_database(from: &Path, to: &Path) {
        std::fs::copy(from.join("stylet.db"), to.join("stylet.db")).unwrap();
    }
}

mod on_postgres {
    use std::collections::BTreeMap;
    use std::sync::{LazyLock, Mutex};

    use super::{AssertSqlSafe, Command, Connection, Database, DatabaseAddress, Path, PathBuf};
    use crate::support::postgres::PostgresServer;

    /// The server of all tests, and which folder each of its databases is for.
    static SERVER: LazyLock<SharedServer> = LazyLock::new(SharedServer::start);

    struct SharedServer {
        server: PostgresServer,
        folders: Mutex<BTreeMap<PathBuf, String>>,
    }

    impl SharedServer {
        /// With a database that is migrated, for others to be copies of.
        fn start() -> Self {
            let start = async {
                let server = PostgresServer::start().await.expect("the tests need PostgreSQL");
                let _alone = server.lock();
                if !server.databases().iter().any(|name| name == "template") {
                    let made = server.make_database("template0");
                    let db = Database::open(&DatabaseAddress::parse(&server.url(&made)).unwrap()).await.unwrap();
                    db.migrate().await.unwrap();
                    db.close().await;
                    server.execute(&format!("ALTER DATABASE {made} RENAME TO template"));
                }
                server
            };
            let run = || tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(start);
            // A test has a runtime of its own already.
            let server = std::thread::scope(|scope| scope.spawn(run).join().unwrap());
            Self { server, folders: Mutex::default() }
        }

        /// The database of a folder; those whose folders are gone go, too.
        fn database_of(&self, folder: &Path) -> String {
            let mut folders = self.folders.lock().unwrap();
            let gone = folders.extract_if(.., |folder, _| is_gone(folder)).map(|(_, name)| name);
            for name in gone {
                self.server.drop_database(&name);
            }
            folders.entry(folder.to_owned()).or_insert_with(|| self.server.make_database("template")).clone()
        }
    }

    /// Whether a folder is gone with all that a test had around it: one that is yet to be made is not.
    fn is_gone(folder: &Path) -> bool {
        let temporary = std::env::temp_dir();
        !folder.ancestors().take_while(|place| *place != temporary).any(Path::exists)
    }

    pub fn address_of(folder: &Path) -> DatabaseAddress {
        DatabaseAddress::parse(&url_of(folder)).unwrap()
    }

    pub fn url_of(folder: &Path) -> String {
        SERVER.server.url(&SERVER.database_of(folder))
    }

    pub fn tell(command: &mut Command, folder: &Path) {
        command.env("STYLET_DATABASE", url_of(folder));
    }

    /// How many rows there are, and the latest transaction that has written one.
    pub async fn version(watch: &mut Connection) -> String {
        let rows: String = sqlx::query_scalar(
            "SELECT string_agg('SELECT max(xmin::text::bigint) AS latest, count(*) AS many FROM ' || tablename, ' UNION ALL ')
             FROM pg_tables WHERE schemaname = 'public'",
        )
        .fetch_one(&mut *watch)
        .await
        .unwrap();
        let version = format!("SELECT concat(max(latest), ' ', sum(many)) FROM ({rows}) t");
        sqlx::query_scalar(AssertSqlSafe(version)).fetch_one(watch).await.unwrap()
    }

    pub fn drop_trigger(trigger: &str, table: &str) -> String {
        format!("DROP TRIGGER {trigger} ON {table}")
    }

    pub fn shrinking(statement: &str) -> String {
        let trigger = |does| format!("ALTER TABLE audit_log {does} TRIGGER audit_log_never_shrinks");
        format!("{}; {statement}; {}", trigger("DISABLE"), trigger("ENABLE"))
    }

    pub async fn rows_of(db: &Database, table: &str) -> Vec<String> {
        let rows = format!("SELECT '{table} ' || CAST(t AS TEXT) FROM {table} t ORDER BY 1");
        sqlx::query_scalar(AssertSqlSafe(rows)).fetch_all(db.reader()).await.unwrap()
    }

    pub fn copy_database(from: &Path, to: &Path) {
        let copy = SERVER.server.make_database(&SERVER.database_of(from));
        SERVER.folders.lock().unwrap().insert(to.to_owned(), copy);
    }
}
