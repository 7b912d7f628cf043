//! The test's side: a copy of the library of its own, its script, and what it heard.

#![expect(unsafe_code, reason = "the script goes in and the notes come out through symbols of the loaded library")]

use std::path::{Path, PathBuf};

use libloading::{Library, library_filename};
use tempfile::TempDir;

use crate::{Heard, Script};

/// Environment variable with the script's name, for a library that another program loads.
pub const ENVIRONMENT: &str = "STYLET_STAND_IN_HD";

/// A copy of the library, so that tests that run at once each have their own device.
pub struct StandIn {
    folder: TempDir,
    library: Library,
}

impl StandIn {
    /// A device that behaves as scripted.
    ///
    /// # Panics
    /// When the library is not beside the test.
    #[must_use]
    pub fn new(script: Script) -> Self {
        let folder = copy(|bytes| bytes);
        // SAFETY: the library is this crate, and has no initialisers.
        let library = unsafe { Library::new(file(&folder)) }.expect("the stand-in loads");
        // SAFETY: declared so in `abi.rs`, of the same build.
        let set = unsafe { library.get::<fn(Script)>("stand_in_script") }.expect("a script can be set");
        set(script);
        Self { folder, library }
    }

    /// Where the library is.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        file(&self.folder)
    }

    /// What it heard so far.
    ///
    /// # Panics
    /// When the library is another.
    #[must_use]
    pub fn heard(&self) -> Heard {
        // SAFETY: declared so in `abi.rs`, of the same build.
        let heard = unsafe { self.library.get::<fn() -> Heard>("stand_in_heard") }.expect("it can be asked");
        heard()
    }
}

/// A folder with a library of another version in it, which lacks a function, and the library's path.
///
/// # Panics
/// When the stand-in has no such function.
#[must_use]
pub fn lacking(symbol: &str) -> (TempDir, PathBuf) {
    let name = [symbol.as_bytes(), b"\0"].concat();
    let folder = copy(|mut bytes| {
        let mut found = 0;
        for at in 0..bytes.len() - name.len() {
            if bytes[at..].starts_with(&name) {
                bytes[at] = b'#';
                found += 1;
            }
        }
        assert!(found > 0, "the stand-in has no {symbol}");
        bytes
    });
    let path = file(&folder);
    (folder, path)
}

fn file(folder: &TempDir) -> PathBuf {
    folder.path().join(library_filename("HD"))
}

/// A changed copy in a folder of its own. The system loads a file once, and each copy is another file.
fn copy(change: impl FnOnce(Vec<u8>) -> Vec<u8>) -> TempDir {
    let test = std::env::current_exe().expect("a test");
    let beside = test.parent().unwrap_or(Path::new(".")).join(library_filename("libhd"));
    let bytes = std::fs::read(&beside).expect("cargo builds the stand-in beside the test that depends on it");
    let folder = TempDir::new().expect("a folder");
    std::fs::write(file(&folder), change(bytes)).expect("a copy");
    folder
}
