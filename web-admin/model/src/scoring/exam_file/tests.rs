//! Checks that a file verifies as written, and that no byte of it can change unnoticed.

use std::collections::BTreeMap;

use data_encoding::HEXLOWER;
use ed25519_dalek::SigningKey;
use sha2::{Digest, Sha256};

use super::*;
use crate::training::certificate::public_key;

const RECORDED: [u8; 700] = [7; 700];

fn key() -> SigningKey {
    SigningKey::from_bytes(&[7; 32])
}

fn manifest() -> ExamManifest {
    let text = include_str!("../../../../../tests/data/exam_file/manifest.json");
    serde_json::from_str(text).expect("a manifest")
}

fn small() -> BTreeMap<String, Vec<u8>> {
    let entries = [("documents/exercise.toml", "id = \"x\""), ("scores.json", "[]")];
    entries.map(|(name, content)| (name.to_owned(), content.as_bytes().to_vec())).into()
}

fn written(small: &BTreeMap<String, Vec<u8>>) -> anyhow::Result<Vec<u8>> {
    let sha256 = HEXLOWER.encode(&Sha256::digest(RECORDED));
    let recording = ExamRecording { sha256: &sha256, bytes: RECORDED.len() as u64 };
    let head = write_head(&key(), manifest(), small, recording)?;
    Ok([&head, &RECORDED[..], &write_tail(recording.bytes)].concat())
}

fn checked(file: &[u8]) -> Result<ExamManifest, String> {
    check(file, &public_key(&key())).map_err(|error| format!("{error:#}"))
}

#[test]
fn written_file_verifies_and_tar_reads_it() {
    let file = written(&small()).expect("written");
    let manifest = checked(&file).expect("genuine");
    assert_eq!(manifest.entries.len(), 3);
    let mut archive = tar::Archive::new(&file[..]);
    let names =
        archive.entries().expect("a tar").map(|entry| entry.expect("an entry").path().expect("a path").into_owned());
    let names: Vec<_> = names.map(|name| name.display().to_string()).collect();
    assert_eq!(names, [MANIFEST, SIGNATURE, "documents/exercise.toml", "scores.json", RECORDING]);
    assert!(check(&file[..], &public_key(&SigningKey::from_bytes(&[8; 32]))).is_err(), "another school's key");
}

#[test]
fn every_changed_byte_is_found() {
    let file = written(&small()).expect("written");
    let spelled = file.windows(10).position(|window| window == b"public_key").expect("in the file");
    // Every byte of the signature, and of the rest those of many distances from the start of a block.
    for place in (0..file.len()).step_by(29).chain(spelled..spelled + 220) {
        let mut changed = file.clone();
        // The other case of a letter: a hexadecimal number must not have two spellings.
        changed[place] ^= if file[place].is_ascii_alphabetic() { 0x20 } else { 1 };
        assert!(checked(&changed).is_err(), "byte {place}");
    }
    for end in (0..file.len()).step_by(37) {
        assert!(checked(&file[..end]).is_err(), "truncated after {end} bytes");
    }
    assert!(checked(&[&file[..], b"\0"].concat()).expect_err("longer").contains("more bytes follow"));
}

#[test]
fn first_wrong_entry_is_named() {
    let file = written(&small()).expect("written");
    for (from, to, named) in [
        ("id = \"x\"", "id = \"y\"", "documents/exercise.toml: the content"),
        ("Ada", "Eva", "manifest.json"),
        ("public_key", "public_kay", "signature.json"),
    ] {
        let place = file.windows(from.len()).position(|window| window == from.as_bytes()).expect("in the file");
        let changed = [&file[..place], to.as_bytes(), &file[place + to.len()..]].concat();
        assert!(checked(&changed).expect_err("changed").starts_with(named), "{named}");
    }
    let start = file.windows(11).position(|window| window == b"scores.json").expect("in the file");
    let start =
        file[start + 1..].windows(11).position(|window| window == b"scores.json").expect("its header") + start + 1;
    let without = [&file[..start], &file[start + 1024..]].concat();
    assert!(checked(&without).expect_err("removed").starts_with("scores.json: missing"));
    let twice = [&file[..start], &file[start..start + 1024], &file[start..]].concat();
    assert!(checked(&twice).expect_err("twice").starts_with("recording.mcap: missing or out of place"));
}

#[test]
fn hostile_names_and_numbers_are_refused() {
    for name in ["../x", "/x", "a//b", "a b", ".x", MANIFEST, RECORDING, &"x".repeat(101)] {
        let entries = BTreeMap::from([(name.to_owned(), Vec::new())]);
        assert!(written(&entries).is_err(), "{name}");
    }
    let many = (0..500).map(|number| (format!("{number}"), Vec::new())).collect();
    assert!(written(&many).expect_err("too many").to_string().contains("501 entries"));
    // A header that announces more than there is must not reserve memory for it.
    let mut header = tar::Header::new_gnu();
    header.set_path(MANIFEST).expect("a path");
    header.set_size(u64::MAX >> 8);
    header.set_mode(0o600);
    header.set_cksum();
    assert!(checked(header.as_bytes()).expect_err("large").contains("at most"));
    assert!(checked(b"").is_err() && checked(&[0; 4096]).is_err());
}
