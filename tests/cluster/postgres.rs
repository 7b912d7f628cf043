//! A PostgreSQL of the command's own: a folder, a socket in it, and no port. It is stopped when the command ends, however it ends.

use std::fs::File;
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, ensure};
use platform::clock;
use rustix::process::getuid;
use tempfile::TempDir;
use tests::processes::said;

/// Who runs the server where the command is root's, by whom it refuses to be run.
const NOBODY: u32 = 65534;
/// Longest until a server answers.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs a program, and shuts it down fast when nothing is to be read any more: a server that is killed leaves its memory behind.
const UNTIL_ITS_INPUT_ENDS: &str = r#""$0" "$@" & cat > /dev/null; kill -INT $! 2> /dev/null; wait $!"#;

/// How a server is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// What is under way is rolled back.
    Fast,
    /// As if the machine had lost power: what was committed is read from the server's log when it starts.
    Immediate,
}

/// The server, while it runs.
#[derive(Debug)]
pub struct Postgres {
    process: Option<Child>,
    folder: TempDir,
    programs: PathBuf,
}

impl Postgres {
    /// Makes a server and starts it.
    pub fn start() -> anyhow::Result<Self> {
        let programs = programs().context("PostgreSQL is not installed: apt-get install postgresql")?;
        let folder = tempfile::tempdir()?;
        if getuid().is_root() {
            chown(folder.path(), Some(NOBODY), Some(NOBODY))?;
        }
        let mut server = Self { process: None, folder, programs };
        let mut initdb = server.command("initdb");
        initdb.args(["--auth=trust", "--username=postgres", "--encoding=UTF8", "--locale=C", "-D", "data"]);
        said(&initdb.output()?).context("initdb")?;
        server.start_again()?;
        server.query("CREATE DATABASE stylet")?;
        Ok(server)
    }

    /// Starts it after a stop, and waits until it answers.
    pub fn start_again(&mut self) -> anyhow::Result<()> {
        let log = File::options().create(true).append(true).open(self.folder.path().join("log"))?;
        let mut command = self.command("/bin/sh");
        command.args(["-c", UNTIL_ITS_INPUT_ENDS]).arg(self.programs.join("postgres"));
        command.args(["-c", "listen_addresses=", "-c", "max_connections=200", "-c", "log_checkpoints=off"]);
        command.args(["-c", "shared_preload_libraries=pg_stat_statements", "-c", "pg_stat_statements.track=all"]);
        command.arg("-k").arg(self.folder.path()).args(["-D", "data"]);
        self.process = Some(command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log).spawn()?);
        let begun = clock::instant();
        while let Err(error) = self.ask("postgres", "SELECT 1") {
            ensure!(begun.elapsed() < PATIENCE, "PostgreSQL was started and does not answer: {error:#}");
            thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// Stops it, and waits until it has.
    pub fn stop(&mut self, how: Stop) -> anyhow::Result<()> {
        let Some(mut process) = self.process.take() else { return Ok(()) };
        if how == Stop::Immediate {
            let file = std::fs::read_to_string(self.folder.path().join("data/postmaster.pid"))?;
            let id = file.lines().next().context("postmaster.pid is empty")?;
            ensure!(Command::new("kill").args(["-QUIT", id]).status()?.success(), "PostgreSQL cannot be stopped");
        }
        drop(process.stdin.take());
        process.wait()?;
        Ok(())
    }

    /// Where it listens.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.folder.path().join(".s.PGSQL.5432")
    }

    /// Its process, which has started all others of it, while it runs.
    pub fn process_id(&self) -> Option<u32> {
        self.process.as_ref().map(Child::id)
    }

    /// Rows of the school's database, as text; or of the server's own, where that is not there yet.
    pub fn query(&self, statement: &str) -> anyhow::Result<Vec<Vec<String>>> {
        let database = if statement.starts_with("CREATE DATABASE") { "postgres" } else { "stylet" };
        self.ask(database, statement)
    }

    /// A single number.
    pub fn count(&self, statement: &str) -> anyhow::Result<u64> {
        let rows = self.query(statement)?;
        let cell = rows.first().and_then(|row| row.first()).with_context(|| format!("{statement}: no row"))?;
        cell.parse().with_context(|| format!("{statement}: {cell}; expected is a whole number"))
    }

    fn ask(&self, database: &str, statement: &str) -> anyhow::Result<Vec<Vec<String>>> {
        let mut psql = self.command("psql");
        psql.args([
            "-X",
            "-q",
            "-A",
            "-t",
            "-F",
            "\t",
            "-v",
            "ON_ERROR_STOP=1",
            "-U",
            "postgres",
            "-d",
            database,
            "-h",
        ]);
        let told = said(&psql.arg(self.folder.path()).args(["-c", statement]).output()?).context("psql")?;
        Ok(told.lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect())
    }

    /// A program of the server, in its folder, as an ordinary user.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(self.programs.join(program));
        command.current_dir(self.folder.path()).stdin(Stdio::null());
        if getuid().is_root() {
            command.uid(NOBODY).gid(NOBODY);
        }
        command
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        // Nobody is left to be told that it did not stop.
        let _ = self.stop(Stop::Fast);
    }
}

/// The folder with the newest server's programs, where Debian puts it.
fn programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").ok()?;
    let number = |path: &PathBuf| path.file_name()?.to_str()?.parse::<u32>().ok();
    let newest = versions.filter_map(|entry| Some(entry.ok()?.path())).max_by_key(number)?.join("bin");
    newest.join("initdb").exists().then_some(newest)
}
