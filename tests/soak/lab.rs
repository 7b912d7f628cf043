//! A school in a folder, and the programs that serve and visit it.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, bail, ensure};
use tests::processes::{free_port, said};

/// A school in a folder.
#[derive(Debug)]
pub struct Lab {
    /// The folder.
    pub folder: PathBuf,
    /// Where its service listens.
    pub port: u16,
    /// Where the programs are.
    programs: PathBuf,
}

/// A service that runs; killed when dropped.
#[derive(Debug)]
pub struct Serving(pub Child);

impl Drop for Serving {
    fn drop(&mut self) {
        // One that has ended by itself leaves nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Lab {
    /// Founds a school with the shipped course.
    pub fn found(folder: &Path) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let ours = std::env::current_exe()?;
        let programs = ours.parent().context("a folder of programs")?.to_owned();
        for name in ["web-admin", "stylet"] {
            let needed = programs.join(name);
            ensure!(
                needed.exists(),
                "{} is missing: build it first (cargo build --workspace --bins)",
                needed.display()
            );
        }
        let port = free_port()?;
        let lab = Self { folder: folder.to_owned(), port, programs };
        ensure!(!lab.data().exists(), "{}: exists; a soak begins in an empty folder", lab.data().display());
        lab.web_admin(&["migrate"])?;
        let curricula = tests::root().join("curricula");
        lab.web_admin(&["curricula", "import", &curricula.to_string_lossy(), "--school", "North"])?;
        Ok(lab)
    }

    /// The service's data folder.
    #[must_use]
    pub fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    /// A program of ours.
    #[must_use]
    pub fn program(&self, name: &str) -> Command {
        Command::new(self.programs.join(name))
    }

    /// Runs a command on the service's data that must succeed; what it printed.
    pub fn web_admin(&self, arguments: &[&str]) -> anyhow::Result<String> {
        let output = self.program("web-admin").args(arguments).arg("--data-dir").arg(self.data()).output()?;
        said(&output).with_context(|| format!("web-admin {}", arguments.join(" ")))
    }

    /// Starts the service, and waits until it listens.
    pub fn serve(&self) -> anyhow::Result<Serving> {
        let log = std::fs::File::options().create(true).append(true).open(self.folder.join("service.log"))?;
        let child = self
            .program("web-admin")
            .args(["serve", "--listen", &format!("127.0.0.1:{}", self.port), "--judges", "2", "--reserve-mb", "100"])
            .arg("--data-dir")
            .arg(self.data())
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()?;
        let mut serving = Serving(child);
        let out = serving.0.stdout.take().context("its standard output")?;
        for line in BufReader::new(out).lines() {
            if line?.contains("http://") {
                return Ok(serving);
            }
        }
        let log = std::fs::read_to_string(self.folder.join("service.log"))?;
        let last: Vec<&str> = log.lines().rev().take(5).collect();
        bail!("it ended with {} before it listened; it said last: {last:#?}", serving.0.wait()?)
    }

    /// Asks the service to stop, and waits until it has.
    pub fn end(&self, mut service: Serving) -> anyhow::Result<()> {
        let asked = Command::new("kill").args(["-TERM", &service.0.id().to_string()]).status()?;
        ensure!(asked.success(), "the service cannot be asked to stop");
        let ended = service.0.wait()?;
        ensure!(ended.success(), "the service stopped with {ended}");
        Ok(())
    }
}
