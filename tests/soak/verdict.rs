//! What is left of what was made.

use std::fmt::Write;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;
use std::time::Duration;

use anyhow::{Context, bail};
use model::SessionKey;
use platform::clock;
use platform::config::Config;
use platform::files::hash_file;
use store::Database;
use store::operations::schools;
use store::recordings::sessions;
use store::scoring::{jobs, scores};
use tests::endings::say;

use crate::Harm;
use crate::lab::Lab;
use crate::station::Made;

/// Longest until everything is scored.
const PATIENCE: Duration = Duration::from_secs(900);

/// What was found at the end.
#[derive(Debug, Default)]
pub struct Verdict {
    made: usize,
    acknowledged: usize,
    /// Of what was made, what the database and the disk have.
    kept: usize,
    /// What nobody has made, or what is there twice.
    surplus: usize,
    scored_once: usize,
    hashed_right: usize,
    findings: usize,
}

/// Waits until nothing is left to score.
pub fn await_scores(lab: &Lab) -> anyhow::Result<()> {
    let begun = clock::instant();
    runtime()?.block_on(async {
        let db = Database::open_existing(&Config::in_folder(&lab.data()).database).await?;
        while jobs::count_jobs(db.reader()).await? > 0 {
            if begun.elapsed() > PATIENCE {
                bail!("{} recordings still wait to be scored", jobs::count_jobs(db.reader()).await?);
            }
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
        db.close().await;
        Ok(())
    })
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    Ok(tokio::runtime::Builder::new_current_thread().enable_all().build()?)
}

/// Holds what is there against what was made.
pub fn pass(lab: &Lab, made: Vec<Made>) -> anyhow::Result<Verdict> {
    let mut verdict = Verdict { made: made.len(), ..Verdict::default() };
    verdict.acknowledged = made.iter().filter(|made| made.acknowledged).count();
    let config = Config::in_folder(&lab.data());
    runtime()?.block_on(async {
        let db = Database::open_existing(&config.database).await?;
        let school_id = schools::list_schools(db.reader()).await?.first().context("a school")?.id;
        let mut hashes: Vec<String> = made.into_iter().map(|made| made.sha256).collect();
        for file in sessions::list_recordings(db.reader()).await? {
            let Some(at) = hashes.iter().position(|sha256| *sha256 == file.recording_sha256) else {
                verdict.surplus += 1;
                continue;
            };
            hashes.swap_remove(at);
            verdict.kept += 1;
            let on_disk = hash_file(&config.recordings_dir.join(&file.recording_path));
            verdict.hashed_right += usize::from(on_disk.is_ok_and(|(sha256, _)| sha256 == file.recording_sha256));
            let scores = scores::list_scores(db.reader(), SessionKey { school_id, id: file.id }).await?;
            verdict.scored_once += usize::from(scores.len() == 1);
        }
        db.close().await;
        anyhow::Ok(())
    })?;
    verdict.findings = findings(lab)?;
    Ok(verdict)
}

/// How much `verify` finds.
fn findings(lab: &Lab) -> anyhow::Result<usize> {
    let output = lab.program("web-admin").args(["verify", "--data-dir"]).arg(lab.data()).output()?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(0);
    }
    say(&said);
    Ok(said.lines().count().max(1))
}

impl Verdict {
    /// Nothing is amiss.
    #[must_use]
    pub const fn is_good(&self) -> bool {
        let Self { made, acknowledged, kept, surplus, scored_once, hashed_right, findings } = *self;
        made > 0
            && acknowledged == made
            && kept == made
            && surplus == 0
            && scored_once == made
            && hashed_right == made
            && findings == 0
    }

    /// For people.
    #[must_use]
    pub fn table(&self, harm: &Harm) -> String {
        let load = |count: &AtomicUsize| count.load(SeqCst);
        let lines = [
            ("kills of the service", load(&harm.services)),
            ("kills of a client", load(&harm.clients)),
            ("connections cut", load(&harm.cuts)),
            ("connections fallen silent", load(&harm.silences)),
            ("attempts made", self.made),
            ("acknowledged", self.acknowledged),
            ("kept", self.kept),
            ("kept and not made, or twice", self.surplus),
            ("scored once", self.scored_once),
            ("hashes right", self.hashed_right),
            ("findings of verify", self.findings),
        ];
        let mut table = String::from("| what | count |\n|---|---|\n");
        for (what, count) in lines {
            // A text takes whatever is written to it.
            let _ = writeln!(table, "| {what} | {count} |");
        }
        table + if self.is_good() { "nothing is amiss" } else { "SOMETHING IS AMISS" }
    }
}
