//! A PostgreSQL of a test's own: a folder, a socket in it, and no port; gone with the test. The server refuses to be run by root, so that
//! there it is given to `nobody`.

use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
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

/// The server, while it runs.
pub struct PostgresServer {
    process: Child,
    folder: TempDir,
    programs: PathBuf,
}

impl PostgresServer {
    /// Starts one; says so and gives none where PostgreSQL is not installed.
    #[expect(clippy::print_stderr, reason = "whoever runs the tests is told what was not tried")]
    pub async fn start() -> Option<Self> {
        let Some(programs) = programs() else {
            eprintln!("not tried: PostgreSQL is not installed; deploy/test installs it");
            return None;
        };
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
        let server = Self { process, folder, programs };
        server.wait().await;
        Some(server)
    }

    /// The options that lead to its database.
    pub fn options(&self) -> PgConnectOptions {
        PgConnectOptions::new_without_pgpass().socket(self.folder.path()).username("postgres").database("postgres")
    }

    /// The address of one of its databases.
    pub fn url(&self, database: &str) -> String {
        let folder = self.folder.path().to_str().unwrap().replace('/', "%2F");
        format!("postgres://postgres:secret@{folder}/{database}")
    }

    /// Has it do what no transaction can.
    pub fn execute(&self, statement: &str) {
        let mut psql = as_ordinary_user(&self.programs.join("psql"), self.folder.path());
        let psql = psql.args(["-X", "-q", "-U", "postgres", "-h"]).arg(self.folder.path());
        let done = psql.args(["-d", "postgres", "-c", statement]).output().unwrap();
        assert!(done.status.success(), "{statement}: {}", String::from_utf8_lossy(&done.stderr));
    }

    /// A connection to its database.
    pub async fn connect(&self) -> PgConnection {
        self.options().connect().await.unwrap()
    }

    async fn wait(&self) {
        for _ in 0..600 {
            if let Ok(connection) = self.options().connect().await {
                return connection.close().await.unwrap();
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("PostgreSQL was started and does not answer");
    }
}

impl Drop for PostgresServer {
    fn drop(&mut self) {
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
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
