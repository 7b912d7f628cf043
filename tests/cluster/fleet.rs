//! Services as processes: started, killed, asked to leave.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use anyhow::{Context, bail, ensure};
use tests::endings::say;
use tests::processes::free_port;

use crate::school::School;

/// Most starts until a service is taken for broken.
const MOST_STARTS: u32 = 3;

/// What a service does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Post {
    /// Pages and the API, and nothing that others do as well.
    Serve {
        /// Where it listens.
        port: u16,
    },
    /// Everything else.
    Work,
}

/// A service, alive or dead.
#[derive(Debug)]
pub struct Replica {
    school: Arc<School>,
    /// What it does.
    pub post: Post,
    /// Its name, which is that of its data folder and of its log.
    pub name: String,
    /// What it runs.
    pub program: PathBuf,
    process: Option<Child>,
}

impl Replica {
    /// One that does not run yet.
    pub fn new(school: &Arc<School>, post: Post, name: String) -> Self {
        Self { school: Arc::clone(school), post, name, program: school.program.clone(), process: None }
    }

    /// Its process, while it lives.
    pub fn process_id(&self) -> Option<u32> {
        self.process.as_ref().map(Child::id)
    }

    /// Starts it, more than once where it must be, as whoever looks after a machine's services does.
    pub fn start_again(&mut self) -> anyhow::Result<()> {
        for _ in 1..MOST_STARTS {
            match self.start() {
                Ok(()) => return Ok(()),
                Err(error) => say(&format!("started once more: {error:#}")),
            }
        }
        self.start()
    }

    /// Starts it, and waits until it is at work.
    pub fn start(&mut self) -> anyhow::Result<()> {
        let log = self.school.folder.join(format!("{}.log", self.name));
        let file = File::options().create(true).append(true).open(&log)?;
        let mut command = self.school.command(&self.program, &self.name);
        match self.post {
            // Everybody comes from an address of their own, as through a proxy: brakes go by address.
            Post::Serve { port } => {
                command.args(["serve", "--behind-tls", "--judges", "0", "--listen"]).arg(format!("127.0.0.1:{port}"))
            }
            Post::Work => command.args(["work", "--judges", "1"]),
        };
        if let Post::Serve { .. } = self.post {
            command.args([
                "--reserve-mb",
                "100",
                "--leave-s",
                "1",
                "--owner-uploads",
                "100000",
                "--owner-mb",
                "1000000",
            ]);
        }
        command.args(["--public-url", "https://school.example.org"]);
        let mut child = command.stdout(Stdio::piped()).stderr(file).spawn()?;
        let out = child.stdout.take().context("its standard output")?;
        self.process = Some(child);
        for line in BufReader::new(out).lines() {
            let line = line?;
            if line.contains("http://") || line == "Working" {
                return Ok(());
            }
        }
        self.process = None;
        let said = std::fs::read_to_string(&log)?;
        let last: Vec<&str> = said.lines().rev().take(5).collect();
        bail!("{} ended before it was at work; it said last: {last:#?}", self.name)
    }

    /// Kills it, if it lives.
    pub fn kill(&mut self) -> anyhow::Result<()> {
        if let Some(mut process) = self.process.take() {
            ensure!(process.try_wait()?.is_none(), "{} has died by itself: {}.log says of what", self.name, self.name);
            process.kill()?;
            process.wait()?;
        }
        Ok(())
    }

    /// Fails where it has died by itself.
    pub fn look_after(&mut self) -> anyhow::Result<()> {
        let ended = self.process.as_mut().map_or(Ok(None), Child::try_wait)?;
        ensure!(ended.is_none(), "{} has died by itself: {}.log says of what", self.name, self.name);
        Ok(())
    }

    /// Asks it to leave, and waits until it has.
    pub fn leave(&mut self) -> anyhow::Result<()> {
        let Some(mut process) = self.process.take() else { return Ok(()) };
        let asked = Command::new("kill").args(["-TERM", &process.id().to_string()]).status()?;
        ensure!(asked.success(), "{} cannot be asked to leave", self.name);
        let ended = process.wait()?;
        ensure!(ended.success(), "{} left with {ended}", self.name);
        Ok(())
    }
}

impl Drop for Replica {
    fn drop(&mut self) {
        // One that has died already has been reported.
        let _ = self.kill();
    }
}

/// Two that serve and two that work, all of them started.
pub fn start_four(school: &Arc<School>) -> anyhow::Result<Vec<Replica>> {
    let mut fleet = Vec::new();
    for number in 1..=2 {
        let mut replica = Replica::new(school, Post::Serve { port: free_port()? }, format!("serve-{number}"));
        replica.start()?;
        fleet.push(replica);
    }
    for number in 1..=2 {
        let mut replica = Replica::new(school, Post::Work, format!("work-{number}"));
        replica.start()?;
        fleet.push(replica);
    }
    Ok(fleet)
}

/// Where those listen that serve.
pub fn ports(fleet: &[Replica]) -> Vec<u16> {
    let port = |replica: &Replica| match replica.post {
        Post::Serve { port } => Some(port),
        Post::Work => None,
    };
    fleet.iter().filter_map(port).collect()
}
