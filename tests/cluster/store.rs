//! The store in which recordings lie: a program that speaks S3. One of the tests' own, in memory, refuses where it is told to; it costs a fifth
//! of what is measured, and has one core at most. The other is SeaweedFS, as `deploy/cluster` starts it.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, ensure};
use tests::processes::free_ports;
use tests::root;

/// The bucket's name.
pub const BUCKET: &str = "school";
/// Longest until a store answers.
const PATIENCE: Duration = Duration::from_secs(60);
/// How long between two questions whether it does.
const ASK_EVERY: Duration = Duration::from_millis(100);

/// The store. It ends when it is dropped; the tests' own also when its standard input does, which is with this process.
#[derive(Debug)]
pub struct BucketStore {
    child: Child,
    input: Option<ChildStdin>,
    /// Where it listens.
    pub port: u16,
}

impl BucketStore {
    /// Starts SeaweedFS in a folder, with an empty bucket.
    pub fn start_seaweed(weed: &Path, folder: &Path) -> anyhow::Result<Self> {
        let data = folder.join("store");
        std::fs::create_dir_all(&data)?;
        let log = File::create(folder.join("store.log"))?;
        let mut command = Command::new(weed);
        command.args(["-logtostderr=true", "server", "-ip=127.0.0.1", "-ip.bind=127.0.0.1", "-filer", "-s3"]);
        let ports = free_ports(8)?;
        for (part, ports) in ["s3", "master", "volume", "filer"].iter().zip(ports.chunks(2)) {
            command.arg(format!("-{part}.port={}", ports[0])).arg(format!("-{part}.port.grpc={}", ports[1]));
        }
        command.args(["-s3.port.iceberg=0", "-s3.port.lance=0", "-master.telemetry=false"]);
        command.args(["-master.volumeSizeLimitMB=1024", "-volume.max=0", "-volume.preStopSeconds=1"]);
        command.arg("-dir").arg(data).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        let child = command.spawn().with_context(|| weed.display().to_string())?;
        let store = Self { child, input: None, port: ports[0] };
        let make = || store.request("PUT", &format!("/{BUCKET}")).is_ok();
        let made = (0..PATIENCE.as_millis() / ASK_EVERY.as_millis()).any(|_| {
            thread::sleep(ASK_EVERY);
            make()
        });
        ensure!(made, "SeaweedFS makes no bucket; {} says why", folder.join("store.log").display());
        Ok(store)
    }

    /// Starts the tests' own with an empty bucket.
    pub fn start() -> anyhow::Result<Self> {
        let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
        let mut command = Command::new(root().join(&python));
        command.arg(root().join("tests/python/serve_bucket.py")).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().with_context(|| format!("{python}: deploy/test makes Python's environment"))?;
        let mut said = String::new();
        BufReader::new(child.stdout.take().context("its standard output")?).read_line(&mut said)?;
        let port = said.trim().rsplit(':').next().and_then(|port| port.parse().ok());
        let port = port.with_context(|| format!("the store said \"{}\"; expected is its address", said.trim()))?;
        let store = Self { input: child.stdin.take(), child, port };
        store.mend()?;
        Ok(store)
    }

    /// Its process.
    pub fn process_id(&self) -> u32 {
        self.child.id()
    }

    /// Has it take nothing more, for want of room.
    pub fn fill(&self) -> anyhow::Result<()> {
        self.tell("full", 1)
    }

    /// Has it refuse nothing any more.
    pub fn mend(&self) -> anyhow::Result<()> {
        self.tell("lost", 0)
    }

    fn tell(&self, way: &str, first: usize) -> anyhow::Result<()> {
        self.request("GET", &format!("/-/{BUCKET}/{way}/{first}"))
    }

    fn request(&self, method: &str, path: &str) -> anyhow::Result<()> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        )?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer)?;
        ensure!(
            answer.split(' ').nth(1) == Some("200"),
            "the store was asked \"{method} {path}\" and answers: {answer}"
        );
        Ok(())
    }
}

impl Drop for BucketStore {
    fn drop(&mut self) {
        if self.input.take().is_none() {
            // What it keeps goes with the test.
            let _ = self.child.kill();
        }
        let _ = self.child.wait();
    }
}
