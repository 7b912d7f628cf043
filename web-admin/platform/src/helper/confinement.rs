//! Takes rights away from a process that reads untrusted input: Landlock for files and TCP, seccomp
//! for other sockets and for programs. On other systems than Linux nothing is taken away.

use std::path::PathBuf;

/// What a confined process may still use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PermittedPaths {
    /// Files and folders that it may read.
    pub read: Vec<PathBuf>,
    /// Folders below which it may read, create and remove files.
    pub write: Vec<PathBuf>,
}

/// Confines the calling thread, and all threads that it will start: no other files, no sockets, no
/// programs. A kernel without Landlock (before 5.13) still refuses sockets and programs.
///
/// # Errors
/// Fails if a folder cannot be created, or the kernel refuses.
#[cfg(target_os = "linux")]
pub fn confine(paths: &PermittedPaths) -> anyhow::Result<()> {
    for folder in &paths.write {
        std::fs::create_dir_all(folder)?;
    }
    linux::permit_paths(paths)?;
    linux::refuse_calls()
}

/// Does nothing on this system.
///
/// # Errors
/// Never fails here.
#[cfg(not(target_os = "linux"))]
pub fn confine(_: &PermittedPaths) -> anyhow::Result<()> {
    Ok(())
}

#[cfg(target_os = "linux")]
mod linux {
    use std::env::consts::ARCH;

    use landlock::{
        ABI, Access, AccessFs, AccessNet, Ruleset, RulesetAttr, RulesetCreatedAttr, Scope, path_beneath_rules,
    };
    use seccompiler::{BpfProgram, SeccompAction, SeccompFilter, TargetArch, apply_filter};

    use super::PermittedPaths;

    /// The version of Landlock whose rights are taken away; an older kernel takes those that it knows.
    const VERSION: ABI = ABI::V6;

    /// Calls that reading, computing and writing do not need: sockets, programs, other processes,
    /// and interfaces of the kernel that have often been attacked.
    const REFUSED: [libc::c_long; 24] = [
        libc::SYS_socket,
        libc::SYS_socketpair,
        libc::SYS_connect,
        libc::SYS_bind,
        libc::SYS_listen,
        libc::SYS_accept4,
        libc::SYS_execve,
        libc::SYS_execveat,
        libc::SYS_ptrace,
        libc::SYS_process_vm_readv,
        libc::SYS_process_vm_writev,
        libc::SYS_pidfd_getfd,
        libc::SYS_mount,
        libc::SYS_umount2,
        libc::SYS_unshare,
        libc::SYS_setns,
        libc::SYS_bpf,
        libc::SYS_perf_event_open,
        libc::SYS_userfaultfd,
        libc::SYS_io_uring_setup,
        libc::SYS_add_key,
        libc::SYS_request_key,
        libc::SYS_keyctl,
        libc::SYS_open_by_handle_at,
    ];

    pub(super) fn permit_paths(paths: &PermittedPaths) -> anyhow::Result<()> {
        let rules = Ruleset::default()
            .handle_access(AccessFs::from_all(VERSION))?
            .handle_access(AccessNet::from_all(VERSION))?
            .scope(Scope::from_all(VERSION))?
            .create()?;
        rules
            .add_rules(path_beneath_rules(&paths.read, AccessFs::from_read(VERSION)))?
            .add_rules(path_beneath_rules(&paths.write, AccessFs::from_all(VERSION)))?
            .restrict_self()?;
        Ok(())
    }

    /// Makes [`REFUSED`] fail with `EPERM`, on the processors for which there is a filter.
    pub(super) fn refuse_calls() -> anyhow::Result<()> {
        let Ok(processor) = TargetArch::try_from(ARCH) else { return Ok(()) };
        let refused = REFUSED.map(|call| (call, Vec::new())).into();
        let error = SeccompAction::Errno(libc::EPERM.unsigned_abs());
        let filter: BpfProgram = SeccompFilter::new(refused, SeccompAction::Allow, error, processor)?.try_into()?;
        Ok(apply_filter(&filter)?)
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    //! A confined thread must reach nothing but the permitted paths. Threads of the test process
    //! stand in for the helper: both mechanisms act on a thread.

    use std::fs;
    use std::io::{ErrorKind, Result};
    use std::net::{TcpListener, TcpStream, UdpSocket};
    use std::os::unix::net::UnixStream;
    use std::process::Command;
    use std::thread;

    use super::*;

    fn is_refused<T>(outcome: Result<T>) -> bool {
        outcome.is_err_and(|error| error.kind() == ErrorKind::PermissionDenied)
    }

    #[test]
    fn confined_thread_uses_permitted_paths_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("recording"), "own").unwrap();
        fs::write(at("other"), "of another school").unwrap();
        let paths = PermittedPaths { read: vec![at("recording")], write: vec![at("replays")] };
        thread::scope(|scope| {
            scope.spawn(|| {
                confine(&paths).unwrap();
                assert_eq!(fs::read(at("recording")).unwrap(), b"own");
                assert!(is_refused(fs::read(at("other"))));
                assert!(is_refused(fs::read_dir(folder.path())));
                assert!(is_refused(fs::read("/etc/passwd")));
                assert!(is_refused(fs::write(at("recording"), "changed")));
                assert!(is_refused(fs::write(at("new"), "")));
                assert!(is_refused(fs::remove_file(at("other"))));
                fs::create_dir(at("replays/part")).unwrap();
                fs::write(at("replays/part/frames"), "frames").unwrap();
                fs::rename(at("replays/part"), at("replays/whole")).unwrap();
                assert_eq!(fs::read(at("replays/whole/frames")).unwrap(), b"frames");
                let started = thread::spawn(move || is_refused(fs::read("/etc/passwd")));
                assert!(started.join().unwrap(), "a thread started later is confined too");
            });
        });
        assert_eq!(fs::read(at("other")).unwrap(), b"of another school", "other threads keep their rights");
    }

    #[test]
    fn confined_thread_opens_no_socket_and_starts_no_program() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let confined = thread::spawn(move || {
            confine(&PermittedPaths::default()).unwrap();
            assert!(is_refused(TcpStream::connect(address)));
            assert!(is_refused(TcpListener::bind("127.0.0.1:0")));
            assert!(is_refused(UdpSocket::bind("127.0.0.1:0")));
            assert!(is_refused(UnixStream::connect("/run/docker.sock")));
            assert!(is_refused(UnixStream::pair()));
            assert!(is_refused(Command::new("/bin/true").status()));
        });
        confined.join().unwrap();
    }
}
