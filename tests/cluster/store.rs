//! The store in which recordings lie: a program that speaks S3, in memory, and refuses where it is told to.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdin, Command, Stdio};

use anyhow::{Context, ensure};
use tests::root;

/// The bucket's name.
pub const BUCKET: &str = "school";

/// The store. It ends when its standard input does, which is with this process.
#[derive(Debug)]
pub struct BucketStore {
    child: Child,
    input: Option<ChildStdin>,
    /// Where it listens.
    pub port: u16,
}

impl BucketStore {
    /// Starts one with an empty bucket.
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
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        write!(stream, "GET /-/{BUCKET}/{way}/{first} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer)?;
        ensure!(answer.split(' ').nth(1) == Some("200"), "the store was told \"{way}\" and answers: {answer}");
        Ok(())
    }
}

impl Drop for BucketStore {
    fn drop(&mut self) {
        drop(self.input.take());
        // It ends by itself.
        let _ = self.child.wait();
    }
}
