//! A disk that fails on demand, under a service of its own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use super::service::Service;

/// The library that is preloaded, compiled once.
static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/main/support/failing_disk.c");
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("failing_disk-{}.so", std::process::id()));
    let compiled = Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).status();
    assert!(compiled.unwrap().success());
    library
});

/// What a write may fail with.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// EIO.
    Broken = 5,
    /// ENOSPC.
    Full = 28,
}

/// The switch of such a disk.
pub struct FailingDisk {
    control: PathBuf,
}

impl FailingDisk {
    /// A service on a folder, whose disk works for now.
    pub fn under_service(folder: &Path) -> (Self, Service) {
        let control = folder.join("fault");
        let environment = [("LD_PRELOAD", LIBRARY.as_path()), ("STYLET_FAILING_DISK", &control)];
        let service = Service::start_with(folder, &environment);
        (Self { control }, service)
    }

    /// From now on writes to files whose path holds a word fail.
    pub fn fail(&self, fault: Fault, word: &str) {
        let part = self.control.with_extension("part");
        std::fs::write(&part, format!("{} {word}", fault as i32)).unwrap();
        std::fs::rename(part, &self.control).unwrap();
    }

    /// From now on none fails.
    pub fn mend(&self) {
        std::fs::remove_file(&self.control).unwrap();
    }
}
