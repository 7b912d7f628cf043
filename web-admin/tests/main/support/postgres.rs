//! A PostgreSQL for tests: a folder, a socket in it, and no port; gone with the process, or shared by the processes of all tests, which
//! `deploy/test-servers` has started. The server refuses to be run by root, so that there it is given to `nobody`.

use std::fs::File;
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use rustix::process::getuid;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;

/// Who runs the server where the test is root's.
const NOBODY: u32 = 65534;

/// Runs a program and shuts it down fast when nothing is to be read any more: when the test drops it, or when the tests are over. A server
/// that is killed leaves its memory behind.
const UNTIL_ITS_INPUT_ENDS: &str =
    r#""$0" "$@" 2> log & cat > /dev/null; kill -INT $!; wait $!; folder=$PWD; cd /; rm -rf "$folder""#;

/// The server, while it runs: this process's own, or one that other processes share.
pub struct PostgresServer {
    own: Option<(Child, TempDir)>,
    /// The folder of its socket.
    folder: PathBuf,
    programs: PathBuf,
    made: AtomicUsize,
}

impl PostgresServer {
    /// Starts one where no other is shared; logs it and returns none where PostgreSQL is not installed.
    #[expect(clippy::print_stderr, reason = "whoever runs the tests is told what was not tried")]
    pub async fn start() -> Option<Self> {
        let Some(programs) = programs() else {
            eprintln!("not tried: PostgreSQL is not installed; deploy/test installs it");
            return None;
        };
        let shared = std::env::var_os("STYLET_TEST_POSTGRES").map(PathBuf::from);
        let own = if shared.is_none() { Some(start_own(&programs)) } else { None };
        let folder = shared.or_else(|| own.as_ref().map(|(_, folder)| folder.path().to_owned())).unwrap();
        let server = Self { own, folder, programs, made: AtomicUsize::default() };
        server.wait().await;
        Some(server)
    }

    fn options(&self, database: &str) -> PgConnectOptions {
        PgConnectOptions::new_without_pgpass().socket(&self.folder).username("postgres").database(database)
    }

    /// The address of one of its databases.
    pub fn url(&self, database: &str) -> String {
        let folder = self.folder.to_str().unwrap().replace('/', "%2F");
        format!("postgres://postgres:secret@{folder}/{database}")
    }

    /// Executes what no transaction can; the answer, a line for each row.
    pub fn execute(&self, statement: &str) -> String {
        let done = self.psql(statement);
        assert!(done.status.success(), "{statement}: {}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap()
    }

    fn psql(&self, statement: &str) -> Output {
        let mut psql = Command::new(self.programs.join("psql"));
        let psql = psql.args(["-X", "-q", "-A", "-t", "-U", "postgres", "-d", "postgres", "-h"]).arg(&self.folder);
        psql.args(["-c", statement]).output().unwrap()
    }

    /// Makes a database of this process's own, a copy of another. Those of processes that have ended go.
    pub fn make_database(&self, copy_of: &str) -> String {
        let has_ended = |name: &String| {
            let process = name.strip_prefix("test_").and_then(|rest| rest.split('_').next());
            process.is_some_and(|process| !Path::new("/proc").join(process).exists())
        };
        self.databases().into_iter().filter(has_ended).for_each(|name| self.drop_database(&name));
        let name = format!("test_{}_{}", std::process::id(), self.made.fetch_add(1, Ordering::Relaxed));
        self.execute(&format!("CREATE DATABASE {name} TEMPLATE {copy_of}"));
        name
    }

    /// Drops a database, unless another process does.
    pub fn drop_database(&self, name: &str) {
        let _ = self.psql(&format!("DROP DATABASE IF EXISTS {name} WITH (FORCE)"));
    }

    /// The names of its databases.
    pub fn databases(&self) -> Vec<String> {
        self.execute("SELECT datname FROM pg_database").lines().map(str::to_owned).collect()
    }

    /// Waits for every other process that holds it.
    pub fn lock(&self) -> File {
        let file = File::create(self.folder.join("lock")).unwrap();
        file.lock().unwrap();
        file
    }

    /// A connection to a database of its own.
    pub async fn connect(&self) -> PgConnection {
        self.options(&self.make_database("template0")).connect().await.unwrap()
    }

    async fn wait(&self) {
        for _ in 0..600 {
            if let Ok(connection) = self.options("postgres").connect().await {
                return connection.close().await.unwrap();
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("PostgreSQL was started and does not answer");
    }
}

impl Drop for PostgresServer {
    fn drop(&mut self) {
        if let Some((process, _)) = &mut self.own {
            drop(process.stdin.take());
            let _ = process.wait();
        }
    }
}

/// Starts a server that ends with this process.
fn start_own(programs: &Path) -> (Child, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    if getuid().is_root() {
        chown(folder.path(), Some(NOBODY), Some(NOBODY)).unwrap();
    }
    let data = folder.path().join("data");
    let made = as_ordinary_user(&programs.join("initdb"), folder.path())
        .args(["--auth=trust", "--username=postgres", "--encoding=UTF8", "--locale=C", "--no-sync", "-D"])
        .arg(&data)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let process = as_ordinary_user(Path::new("/bin/sh"), folder.path())
        .args(["-c", UNTIL_ITS_INPUT_ENDS])
        .arg(programs.join("postgres"))
        .args(["-F", "-c", "listen_addresses=", "-c", "max_connections=500", "-k"])
        .arg(folder.path())
        .arg("-D")
        .arg(&data)
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    (process, folder)
}

/// The folder with the newest server's programs, where Debian puts it.
fn programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").ok()?;
    let number = |path: &PathBuf| path.file_name()?.to_str()?.parse::<u32>().ok();
    let newest = versions.filter_map(|entry| Some(entry.ok()?.path())).max_by_key(number)?.join("bin");
    newest.join("initdb").exists().then_some(newest)
}

fn as_ordinary_user(program: &Path, folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    if getuid().is_root() {
        command.uid(NOBODY).gid(NOBODY);
    }
    command
}
