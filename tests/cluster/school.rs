//! A school on a database, a bucket and a mail server of the command's own, with a network before the first two.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::SeqCst;

use anyhow::{Context, ensure};
use clap::Args;
use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};
use tempfile::TempDir;
use tests::processes::said;
use tests::root;

use crate::postgres::Postgres;
use crate::processor::sum_processor_time;
use crate::relay::{Destination, Relay};
use crate::smtp::MailServer;
use crate::store::{BUCKET, BucketStore};

/// The exercise that is attempted.
const EXERCISE: &str = "curricula/lower-back-basics/1-feel-the-layers.toml";
/// How fast the needle goes where nobody says otherwise, in mm/s: the attempt takes 9 s.
pub const SPEED_MM_S: f64 = 8.0;
/// The password of everybody who signs in.
pub const PASSWORD: &str = "vier Käse im Wind";

/// What every test begins with.
#[derive(Clone, Debug, Args)]
pub struct SchoolArgs {
    /// The `web-admin` to try, built for PostgreSQL [default: the one beside this program]
    #[arg(long, value_name = "FILE")]
    pub program: Option<PathBuf>,
    /// Folder for data and logs, which are left there [default: one that goes with the test]
    #[arg(long, value_name = "DIR")]
    pub folder: Option<PathBuf>,
    /// SeaweedFS to keep recordings, as deploy/cluster installs it: target/cluster/venv/bin/weed [default: a store in memory, in Python]
    #[arg(long, value_name = "FILE")]
    pub weed: Option<PathBuf>,
    /// Decides what happens; not when, which the machine does, too
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// A recording on the disk.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Id of its session.
    pub session: String,
    /// All of it.
    pub bytes: Vec<u8>,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// A school and all that it stands on.
#[derive(Debug)]
pub struct School {
    /// The folder of everything.
    pub folder: PathBuf,
    /// The program that serves it, where no other is named.
    pub program: PathBuf,
    /// Its database.
    pub database: Mutex<Postgres>,
    /// Between services and database.
    pub database_network: Relay,
    /// Its bucket.
    pub store: BucketStore,
    /// Between services and bucket.
    pub store_network: Relay,
    /// Where services find both.
    database_url: String,
    store_port: u16,
    /// Where its mail goes.
    pub mail: MailServer,
    recorded: AtomicU64,
    first_seed: u64,
    _scratch: TempDir,
}

impl School {
    /// Founds a school with the shipped courses.
    pub fn found(args: &SchoolArgs) -> anyhow::Result<Self> {
        let scratch = tempfile::tempdir()?;
        let folder = args.folder.clone().unwrap_or_else(|| scratch.path().to_owned());
        std::fs::create_dir_all(&folder)?;
        let is_new = std::fs::read_dir(&folder)?.next().is_none();
        ensure!(is_new, "{}: holds something; a test begins in an empty folder", folder.display());
        let program = args.program.clone().map_or_else(|| beside_us("web-admin"), Ok)?;
        let database = Postgres::start()?;
        let store = match &args.weed {
            Some(weed) => BucketStore::start_seaweed(weed, &folder)?,
            None => BucketStore::start()?,
        };
        let database_network = Relay::to(Destination::Socket(database.socket()))?;
        let store_network = Relay::to(Destination::Port(store.port))?;
        let school = Self {
            folder,
            program: program.canonicalize().with_context(|| program.display().to_string())?,
            database_url: format!("postgres://postgres@127.0.0.1:{}/stylet", database_network.port),
            store_port: store_network.port,
            database_network,
            store_network,
            database: Mutex::new(database),
            store,
            mail: MailServer::start()?,
            recorded: AtomicU64::new(0),
            first_seed: args.seed.wrapping_mul(1_000_000),
            _scratch: scratch,
        };
        school
            .web_admin(&["migrate"])
            .context("a program that is built with --features web-admin/replicas is needed")?;
        let curricula = root().join("curricula");
        school.web_admin(&["curricula", "import", &curricula.to_string_lossy(), "--school", "North"])?;
        Ok(school)
    }

    /// Leads services past the network, which would take its share of what is measured.
    pub fn bypass_network(&mut self) {
        let socket = self.database.get_mut().unwrap_or_else(PoisonError::into_inner).socket();
        let folder = socket.parent().map(|folder| folder.to_string_lossy().replace('/', "%2F")).unwrap_or_default();
        self.database_url = format!("postgres://postgres@{folder}/stylet");
        self.store_port = self.store.port;
    }

    /// Adds somebody of cohort A who may sign in; their token.
    pub fn add_person(&self, role: &str, email: &str) -> anyhow::Result<String> {
        let add = ["user", "add", "--school", "North", "--role", role, "--name", "Somebody", "--email", email];
        let cohort: &[&str] = if role == "administrator" { &[] } else { &["--cohort", "A"] };
        let mut command = self.command(&self.program, "office");
        command.args(add).args(cohort).args(["--password", "-"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut adding = command.spawn()?;
        adding.stdin.take().context("its standard input")?.write_all(PASSWORD.as_bytes())?;
        said(&adding.wait_with_output()?).context("web-admin user add")?;
        Ok(self.web_admin(&["user", "token", "--email", email])?.trim_end().to_owned())
    }

    /// A program on this school, with a data folder of its own; arguments are to follow.
    pub fn command(&self, program: &Path, data: &str) -> Command {
        let mut command = Command::new(program);
        command.env("STYLET_DATA_DIR", self.folder.join(data));
        command.env("STYLET_DATABASE", &self.database_url);
        command.env("STYLET_RECORDINGS", format!("s3://{BUCKET}/north"));
        command.env("STYLET_MAIL", format!("smtp://127.0.0.1:{}", self.mail.port));
        command.env("AWS_ENDPOINT", format!("http://127.0.0.1:{}", self.store_port));
        command.envs([("AWS_REGION", "us-east-1"), ("AWS_ACCESS_KEY_ID", "test"), ("AWS_SECRET_ACCESS_KEY", "test")]);
        command
    }

    /// Runs a command of the service that must succeed; what it printed.
    pub fn web_admin(&self, words: &[&str]) -> anyhow::Result<String> {
        let output = self.command(&self.program, "office").args(words).output();
        let output = output.with_context(|| self.program.display().to_string())?;
        said(&output).with_context(|| format!("web-admin {}", words.join(" ")))
    }

    /// Rows of the database, asked for beside the network.
    pub fn query(&self, statement: &str) -> anyhow::Result<Vec<Vec<String>>> {
        self.database.lock().unwrap_or_else(PoisonError::into_inner).query(statement)
    }

    /// A single number, asked for beside the network.
    pub fn count(&self, statement: &str) -> anyhow::Result<u64> {
        self.database.lock().unwrap_or_else(PoisonError::into_inner).count(statement)
    }

    /// What the database has had of the processor, in s.
    pub fn database_processor_time(&self) -> anyhow::Result<f64> {
        let server = self.database.lock().unwrap_or_else(PoisonError::into_inner).process_id();
        sum_processor_time(server.context("PostgreSQL runs")?)
    }

    /// Records an attempt of a needle that goes so fast, in mm/s.
    pub fn record(&self, speed_mm_s: f64) -> anyhow::Result<Recorded> {
        let seed = self.first_seed + self.recorded.fetch_add(1, SeqCst);
        let file = self.folder.join(format!("attempt-{seed}.mcap"));
        let mut command = Command::new(beside_us("stylet")?);
        command.arg("simulate").arg(root().join(EXERCISE)).arg("--operator").arg(format!("constant:{speed_mm_s}"));
        let told = said(&command.arg("--seed").arg(seed.to_string()).arg("--out").arg(&file).output()?)
            .context("stylet simulate")?;
        let session = told.split("session ").nth(1).and_then(|rest| rest.split_whitespace().next());
        let session = session.with_context(|| format!("stylet simulate names no session: {told}"))?.to_owned();
        let bytes = std::fs::read(&file)?;
        std::fs::remove_file(file)?;
        Ok(Recorded { session, sha256: HEXLOWER.encode(&Sha256::digest(&bytes)), bytes })
    }

    /// Waits for the end of the queues: nothing is to be scored or mailed any more, and nothing is held.
    pub fn are_queues_empty(&self) -> anyhow::Result<bool> {
        let waiting = "SELECT (SELECT count(*) FROM jobs WHERE deaths < 2) + (SELECT count(*) FROM mails WHERE next_run_at IS NOT NULL)
                            + (SELECT count(*) FROM uploads WHERE received = length AND session_id IS NULL AND deaths < 2)";
        Ok(self.count(waiting)? == 0)
    }
}

/// A program that was built beside this one.
pub fn beside_us(name: &str) -> anyhow::Result<PathBuf> {
    let ours = std::env::current_exe()?;
    let program = ours.parent().context("a folder of programs")?.join(name);
    ensure!(program.exists(), "{} is missing: build it first (cargo build --workspace --bins)", program.display());
    Ok(program)
}
