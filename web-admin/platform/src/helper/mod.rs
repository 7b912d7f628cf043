//! Runs a helper process within time and memory limits, and kills it when its caller goes away.

mod confinement;

pub use confinement::{PermittedPaths, confine};

use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::bucket_address::BucketAddress;
use crate::clock;

/// Interval for polling whether a helper has exited.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// A helper program and its limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Helper {
    /// The program: `web-admin`.
    pub program: PathBuf,
    /// Memory limit, in MB.
    pub memory_mb: u64,
    /// Time limit.
    pub time: Duration,
}

/// How a helper exited.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HelperExit {
    /// Successfully, with this output.
    Said(Vec<u8>),
    /// It was killed because it exceeded the time limit.
    Late,
    /// It crashed or failed; contains the exit status as text.
    Died(String),
}

/// Signals on drop that the caller no longer waits for the helper.
struct HelperWait(Arc<AtomicBool>);

impl Drop for HelperWait {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Passes input to a helper and waits for its output. Dropping the future kills the helper.
///
/// # Errors
/// Fails if it cannot be started.
pub async fn run_helper(helper: Helper, input: Vec<u8>) -> anyhow::Result<HelperExit> {
    let left = Arc::new(AtomicBool::new(false));
    let _waiting = HelperWait(Arc::clone(&left));
    Ok(tokio::task::spawn_blocking(move || attend(&helper, &input, &left)).await??)
}

/// Starts a helper and blocks until it has exited.
fn attend(helper: &Helper, input: &[u8], left: &AtomicBool) -> std::io::Result<HelperExit> {
    let mut command = Command::new(&helper.program);
    // The helper reads untrusted input, so it must not have the bucket's credentials.
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
        // A helper that crashes early breaks the pipe; its exit status is the better report.
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

/// Waits until a helper exits; returns `None` if it was killed.
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
    //! A helper that hangs, crashes or is abandoned must not keep running.

    use std::os::unix::fs::PermissionsExt;
    use std::path::{Path, PathBuf};

    use super::*;

    /// Returns a helper that is a shell script. It first writes its process id into the folder.
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
        // More than a pipe buffers, in both directions.
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
