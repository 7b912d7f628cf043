//! A process that works for us, within its limits, and is ended when nobody waits for it any more.

use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::bucket_address::BucketAddress;
use crate::clock;

/// How long between two looks whether a helper has ended.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// What a helper may cost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Helper {
    /// The program: `web-admin`.
    pub program: PathBuf,
    /// Most memory, in MB.
    pub memory_mb: u64,
    /// Longest time.
    pub time: Duration,
}

/// How a helper has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HelperExit {
    /// With what it said.
    Said(Vec<u8>),
    /// It was ended, for it took too long.
    Late,
    /// By a signal, or with an error; how.
    Died(String),
}

/// Tells the thread beside a helper that nobody waits any more.
struct HelperWait(Arc<AtomicBool>);

impl Drop for HelperWait {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Gives a helper its input, and waits for what it says. Dropped, the helper is ended.
///
/// # Errors
/// When it cannot be started.
pub async fn run_helper(helper: Helper, input: Vec<u8>) -> anyhow::Result<HelperExit> {
    let left = Arc::new(AtomicBool::new(false));
    let _waiting = HelperWait(Arc::clone(&left));
    Ok(tokio::task::spawn_blocking(move || attend(&helper, &input, &left)).await??)
}

/// Starts a helper and stays with it until it has ended.
fn attend(helper: &Helper, input: &[u8], left: &AtomicBool) -> std::io::Result<HelperExit> {
    let mut command = Command::new(&helper.program);
    // What a stranger has sent is read where there are no keys.
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(BucketAddress::is_variable) {
            command.env_remove(name);
        }
    }
    let mut child = command
        .args(["judge", "--memory-mb", &helper.memory_mb.to_string()])
        .args(["--seconds", &helper.time.as_secs().max(1).to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
    thread::scope(|scope| {
        // A helper that dies early has no ears; how it ended tells more than that.
        scope.spawn(move || stdin.map(|mut stdin| stdin.write_all(input)));
        let said = scope.spawn(move || {
            let mut said = Vec::new();
            stdout.map(|mut stdout| stdout.read_to_end(&mut said)).transpose().map(|_| said)
        });
        let ended = wait(&mut child, helper.time, left);
        let said = said.join().unwrap_or_else(|_| Ok(Vec::new()))?;
        Ok(match ended? {
            None => HelperExit::Late,
            Some(status) if status.success() => HelperExit::Said(said),
            Some(status) => HelperExit::Died(status.to_string()),
        })
    })
}

/// Waits for a helper to end; none where it had to be ended.
fn wait(child: &mut Child, time: Duration, left: &AtomicBool) -> std::io::Result<Option<ExitStatus>> {
    let begun = clock::instant();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() >= time || left.load(Ordering::Relaxed) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(LOOK_EVERY);
    }
}

#[cfg(test)]
mod tests {
    //! A helper that hangs, dies or is no longer wanted must not be left behind.

    use std::os::unix::fs::PermissionsExt;
    use std::path::{Path, PathBuf};

    use super::*;

    /// A program in a shell, which writes its process id into the folder first.
    fn helper(folder: &Path, script: &str, time: Duration) -> Helper {
        let program = folder.join("helper.sh");
        let pid = folder.join("pid");
        std::fs::write(&program, format!("#!/bin/sh\necho $$ > {0}.part; mv {0}.part {0}\n{script}\n", pid.display()))
            .unwrap();
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o700)).unwrap();
        Helper { program, memory_mb: 100, time }
    }

    fn is_running(folder: &Path) -> bool {
        let pid = std::fs::read_to_string(folder.join("pid")).unwrap();
        let stat = std::fs::read_to_string(PathBuf::from("/proc").join(pid.trim()).join("stat"));
        stat.is_ok_and(|stat| !stat.contains(") Z"))
    }

    #[tokio::test]
    async fn who_hangs_is_ended_and_who_dies_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let minute = Duration::from_secs(60);
        // More than a pipe holds, both ways.
        let input = vec![b'x'; 1_000_000];
        let said = run_helper(helper(folder.path(), "exec cat", minute), input.clone()).await.unwrap();
        assert_eq!(said, HelperExit::Said(input.clone()));
        let died = run_helper(helper(folder.path(), "kill -ABRT $$", minute), input.clone()).await.unwrap();
        assert!(matches!(&died, HelperExit::Died(how) if how.contains("signal: 6")), "{died:?}");
        let late = helper(folder.path(), "exec sleep 100", Duration::from_millis(300));
        assert_eq!(run_helper(late, input).await.unwrap(), HelperExit::Late);
        assert!(!is_running(folder.path()));
    }

    #[tokio::test]
    async fn who_works_for_nobody_is_ended() {
        let folder = tempfile::tempdir().unwrap();
        let work = run_helper(helper(folder.path(), "exec sleep 100", Duration::from_secs(60)), Vec::new());
        let begun = async {
            while !folder.path().join("pid").exists() {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        tokio::select! {
            ended = work => panic!("{ended:?}"),
            () = begun => {}
        }
        let ended = (0..100).any(|_| {
            thread::sleep(LOOK_EVERY);
            !is_running(folder.path())
        });
        assert!(ended, "the helper goes on for nobody");
    }
}
