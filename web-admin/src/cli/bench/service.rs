//! The service as a process of its own.

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, ensure};
use axum::http::StatusCode;
use platform::clock::Clock;
use platform::config::Config;

use super::visitor::BenchVisitor;

/// Interval at which the service is polled until its database check has finished.
const BETWEEN_QUESTIONS: Duration = Duration::from_millis(200);

/// A running `web-admin serve`, killed when dropped.
pub(super) struct BenchService {
    /// Base URL at which it listens.
    pub url: String,
    /// Time that it took to start, in s.
    pub started_in_s: f64,
    child: Child,
    /// Kept open: writing to a closed pipe would fail in the service.
    output: BufReader<ChildStdout>,
}

impl BenchService {
    /// Serves a school on a free port, and waits until it listens.
    pub(super) fn start(config: &Config) -> anyhow::Result<Self> {
        let clock = Clock::system();
        let begun = clock.now();
        let mut child = Command::new(std::env::current_exe()?)
            .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
            .arg(&config.data_dir)
            .env("STYLET_DATABASE", config.database.as_url())
            .env("RUST_LOG", "warn")
            .stdout(Stdio::piped())
            .spawn()
            .context("the service cannot be started")?;
        let output = BufReader::new(child.stdout.take().context("an output that was asked for")?);
        let mut service = Self { url: String::new(), started_in_s: 0.0, child, output };
        while service.url.is_empty() {
            let mut line = String::new();
            let read = service.output.read_line(&mut line)?;
            ensure!(read > 0, "the service has ended before it listened");
            service.url = line.find("http://").map_or("", |at| line[at..].trim()).to_owned();
        }
        service.started_in_s = (clock.now().micros() - begun.micros()) as f64 / 1e6;
        Ok(service)
    }

    /// Waits until the service has checked its database, which it does while serving, and returns
    /// how long that took, in s.
    pub(super) async fn wait_until_checked(&self) -> anyhow::Result<f64> {
        let (stranger, clock) = (BenchVisitor::new("stranger", &self.url, Vec::new()), Clock::system());
        let begun = clock.now();
        loop {
            let answer = stranger.ask("/readyz", "identity").await?;
            let said = String::from_utf8_lossy(&answer.body);
            ensure!(answer.status == StatusCode::OK, "the service is not ready: {}", said.trim());
            if said.trim() == "ready" {
                return Ok((clock.now().micros() - begun.micros()) as f64 / 1e6);
            }
            tokio::time::sleep(BETWEEN_QUESTIONS).await;
        }
    }

    /// Returns the peak resident memory, in bytes.
    pub(super) fn peak_bytes(&self) -> anyhow::Result<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()))
            .context("memory is read from /proc")?;
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("a peak in /proc")?;
        let kibibytes: u64 = peak.trim().trim_end_matches("kB").trim().parse()?;
        Ok(kibibytes * 1024)
    }
}

impl Drop for BenchService {
    fn drop(&mut self) {
        // Both fail for a process that has already exited, which is fine.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
