//! A PostgreSQL of a test's own: a folder, a socket in it, and no port; gone with the test. The server refuses to be run by root, so that
//! there it is given to `nobody`.

use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, getuid, kill_process};
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;

/// Who runs the server where the test is root's.
const NOBODY: u32 = 65534;

/// The server, while it runs.
pub struct PostgresServer {
    process: Child,
    folder: TempDir,
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
        let process = as_ordinary_user(&programs.join("postgres"), folder.path())
            .args(["-F", "-c", "listen_addresses=", "-k"])
            .arg(folder.path())
            .arg("-D")
            .arg(&data)
            .spawn()
            .unwrap();
        let server = Self { process, folder };
        server.wait().await;
        Some(server)
    }

    /// The options that lead to its database.
    pub fn options(&self) -> PgConnectOptions {
        PgConnectOptions::new_without_pgpass().socket(self.folder.path()).username("postgres").database("postgres")
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
    /// A fast shutdown: a server that is killed leaves its memory behind.
    fn drop(&mut self) {
        if let Some(pid) = i32::try_from(self.process.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process(pid, Signal::INT);
        }
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
