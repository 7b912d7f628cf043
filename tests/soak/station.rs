//! A station that records attempts and sends them, and is killed over it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::thread;
use std::time::Duration;

use anyhow::{Context, ensure};
use data_encoding::HEXLOWER;
use platform::clock;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tests::dice::Dice;
use tests::processes::said;

use crate::Harm;
use crate::lab::Lab;

/// In how many of a hundred runs the client is killed.
const KILLED: u64 = 30;
/// Longest until it is, in ms.
const LONGEST_LIFE_MS: u64 = 1500;

/// An attempt that was recorded.
#[derive(Clone, Debug)]
pub struct Made {
    /// SHA-256 of the recording.
    pub sha256: String,
    /// The service has said that it has it.
    pub acknowledged: bool,
}

/// A station and its user.
#[derive(Debug)]
pub struct Station {
    lab: Arc<Lab>,
    folder: PathBuf,
    network: u16,
    dice: Dice,
    token: String,
    first_seed: u64,
    /// Every attempt, by the name of its file.
    pub made: BTreeMap<String, Made>,
}

impl Station {
    /// A station with a trainee of its own.
    pub fn new(lab: &Arc<Lab>, number: u16, network: u16, seed: u64) -> anyhow::Result<Self> {
        let folder = lab.folder.join(format!("station-{number}"));
        std::fs::create_dir_all(&folder)?;
        let email = format!("trainee-{number}@example.org");
        let add = ["user", "add", "--school", "North", "--role", "trainee", "--name", "Somebody", "--email", &email];
        lab.web_admin(&add)?;
        let token = lab.web_admin(&["user", "token", "--email", &email])?.trim_end().to_owned();
        std::fs::write(folder.join("token"), &token)?;
        let dice = Dice::new(seed.wrapping_mul(100).wrapping_add(u64::from(number) + 1));
        let first_seed = u64::from(number) * 1_000_000;
        Ok(Self { lab: Arc::clone(lab), folder, network, dice, token, first_seed, made: BTreeMap::new() })
    }

    /// Records and sends until the harm is over.
    pub fn work(&mut self, harm: &Harm) -> anyhow::Result<()> {
        while !harm.is_over() {
            let name = self.record()?;
            // Every third as other programs send them.
            if self.made.len().is_multiple_of(3) {
                self.post(&name);
            } else {
                self.upload(&name, harm)?;
            }
        }
        Ok(())
    }

    /// Records an attempt; the name of its file.
    fn record(&mut self) -> anyhow::Result<String> {
        let seed = self.first_seed + self.made.len() as u64;
        let name = format!("attempt-{seed}.mcap");
        let exercise = tests::root().join("curricula/lower-back-basics/1-feel-the-layers.toml");
        let mut command = self.lab.program("stylet");
        command.arg("simulate").arg(exercise).args(["--operator", "constant:8", "--seed", &seed.to_string(), "--out"]);
        said(&command.arg(self.folder.join(&name)).output()?).context("stylet simulate")?;
        let sha256 = HEXLOWER.encode(&Sha256::digest(std::fs::read(self.folder.join(&name))?));
        self.made.insert(name.clone(), Made { sha256, acknowledged: false });
        Ok(name)
    }

    /// Sends a recording by way of the outbox, as often as the client is killed.
    fn upload(&mut self, name: &str, harm: &Harm) -> anyhow::Result<()> {
        let mut command = self.stylet(&["upload", name], self.network);
        command.args(["--retries", "2", "--retry-wait-ms", "50"]);
        self.run(command, Some(harm))?;
        for _ in 0..20 {
            if harm.is_over() || self.made.get(name).is_some_and(|made| made.acknowledged) {
                break;
            }
            let mut again = self.stylet(&["outbox", "send"], self.network);
            again.args(["--retries", "2", "--retry-wait-ms", "50"]);
            self.run(again, Some(harm))?;
            if !self.waits(name)? {
                break;
            }
        }
        Ok(())
    }

    /// A command of the client, with this station's outbox and token.
    fn stylet(&self, words: &[&str], port: u16) -> Command {
        let mut command = self.lab.program("stylet");
        command.args(words).args(["--server", &format!("http://127.0.0.1:{port}"), "--token-file", "token", "--json"]);
        command.args(["--outbox", "outbox"]).current_dir(&self.folder);
        command.env("XDG_DATA_HOME", &self.folder).env("XDG_CONFIG_HOME", &self.folder).env_remove("STYLET_TOKEN");
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        command
    }

    /// Runs the client, kills it perhaps, and notes what it says was delivered.
    fn run(&mut self, mut command: Command, harm: Option<&Harm>) -> anyhow::Result<()> {
        let mut child = command.spawn()?;
        if let Some(harm) = harm.filter(|_| self.dice.happens(KILLED)) {
            let (begun, life) = (clock::instant(), Duration::from_millis(self.dice.below(LONGEST_LIFE_MS)));
            while begun.elapsed() < life && child.try_wait()?.is_none() {
                thread::sleep(Duration::from_millis(5));
            }
            if child.try_wait()?.is_none() {
                child.kill()?;
                harm.clients.fetch_add(1, SeqCst);
            }
        }
        let output = child.wait_with_output()?;
        // A client that was killed has said nothing, or half of it.
        let deliveries: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap_or_default();
        for delivery in deliveries.iter().filter(|delivery| delivery["delivered"] == true) {
            let name = delivery["recording"].as_str().unwrap_or_default();
            if let Some(made) = self.made.get_mut(name) {
                made.acknowledged = true;
            }
        }
        Ok(())
    }

    /// What waits in the outbox.
    fn waiting(&self) -> anyhow::Result<Vec<Value>> {
        let mut command = self.lab.program("stylet");
        command.args(["outbox", "--json", "--outbox", "outbox"]).current_dir(&self.folder);
        Ok(serde_json::from_str(&said(&command.output()?)?)?)
    }

    fn waits(&self, name: &str) -> anyhow::Result<bool> {
        Ok(self.waiting()?.iter().any(|waiting| waiting["name"] == name))
    }

    /// Sends a recording at once, through the network, until it is acknowledged or that takes too long.
    fn post(&mut self, name: &str) {
        for _ in 0..20 {
            if self.posted(name, self.network) {
                return;
            }
            thread::sleep(Duration::from_millis(200));
        }
    }

    fn posted(&mut self, name: &str, port: u16) -> bool {
        let Ok(bytes) = std::fs::read(self.folder.join(name)) else { return false };
        let agent: ureq::Agent = ureq::Agent::config_builder()
            .timeout_global(Some(Duration::from_secs(20)))
            .http_status_as_error(false)
            .build()
            .into();
        let sent = agent
            .post(format!("http://127.0.0.1:{port}/api/v1/sessions"))
            .header("Authorization", format!("Bearer {}", self.token))
            .content_type("application/octet-stream")
            .send(&bytes);
        let acknowledged = sent.is_ok_and(|answer| matches!(answer.status().as_u16(), 200 | 201));
        if let Some(made) = self.made.get_mut(name).filter(|_| acknowledged) {
            made.acknowledged = true;
        }
        acknowledged
    }

    /// Delivers what is left over a network that works: also what was refused, for the service was asked to try again.
    pub fn deliver_rest(&mut self) -> anyhow::Result<()> {
        let waiting = self.waiting()?;
        let ids: Vec<&str> = waiting.iter().filter_map(|waiting| waiting["id"].as_str()).collect();
        if !ids.is_empty() {
            // A token goes to no address but the one that it was given for: the network's, which carries everything by now.
            let command = self.stylet(&[&["outbox", "send"], &ids[..]].concat(), self.network);
            self.run(command, None)?;
        }
        let left = self.waiting()?;
        ensure!(left.is_empty(), "{}: the outbox is not empty: {left:?}", self.folder.display());
        // What came at once and was never acknowledged; and what left the outbox while nobody listened.
        let open: Vec<String> =
            self.made.iter().filter(|(_, made)| !made.acknowledged).map(|(name, _)| name.clone()).collect();
        for name in open {
            ensure!(self.posted(&name, self.lab.port), "{name} is not taken");
        }
        Ok(())
    }
}
