//! The tar of an exam file. Names, lengths and contents determine every byte of it, also of the tar
//! headers, so that a verifier compares instead of interpreting: links, longer names, duplicates
//! and bytes between or after the entries are differences.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use anyhow::{Context, bail, ensure};
use data_encoding::HEXLOWER;
use ed25519_dalek::SigningKey;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tar::Header;

use super::{ExamEntry, ExamManifest, MANIFEST, RECORDING, SIGNATURE};
use crate::training::certificate::{Certificate, checked_text, sign_text};

/// Size limit of a manifest, in bytes.
const MOST_MANIFEST_BYTES: usize = 1 << 20;
/// Size limit of a signature, in bytes.
const MOST_SIGNATURE_BYTES: usize = 1 << 10;
/// Limit of listed entries.
const MOST_ENTRIES: usize = 500;
/// Size of a tar block, in bytes.
const BLOCK: usize = 512;
/// Size of the end of an archive, in bytes.
const END: usize = 2 * BLOCK;
/// Bytes read at once.
const PIECE: usize = 1 << 16;

/// The signature over the text of the manifest.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExamSignature {
    public_key: String,
    signature: String,
}

/// A recording that will follow the head of an exam file.
#[derive(Clone, Copy, Debug)]
pub struct ExamRecording<'a> {
    /// SHA-256.
    pub sha256: &'a str,
    /// Length, in bytes.
    pub bytes: u64,
}

/// Signs a manifest over these entries and the recording, and returns the bytes before the
/// recording. The recording and [`write_tail`] follow.
///
/// # Errors
/// If a name is too long, or there are more entries than a verifier accepts.
pub fn write_head(
    key: &SigningKey,
    mut manifest: ExamManifest,
    small: &BTreeMap<String, Vec<u8>>,
    recording: ExamRecording<'_>,
) -> anyhow::Result<Vec<u8>> {
    let entry = |(name, content): (&String, &Vec<u8>)| ExamEntry {
        name: name.clone(),
        bytes: content.len() as u64,
        sha256: HEXLOWER.encode(&Sha256::digest(content)),
    };
    let ExamRecording { sha256, bytes } = recording;
    manifest.entries = small.iter().map(entry).collect();
    manifest.entries.push(ExamEntry { name: RECORDING.to_owned(), bytes, sha256: sha256.to_owned() });
    check_entries(&manifest.entries)?;
    let text = serde_json::to_string_pretty(&manifest)?;
    ensure!(text.len() <= MOST_MANIFEST_BYTES, "a manifest of {} bytes", text.len());
    let Certificate { statement, public_key, signature } = sign_text(key, &text);
    let mut head = Vec::new();
    append(&mut head, MANIFEST, statement.as_bytes())?;
    append(&mut head, SIGNATURE, &serde_json::to_vec(&ExamSignature { public_key, signature })?)?;
    for (name, content) in small {
        append(&mut head, name, content)?;
    }
    head.extend(make_header(RECORDING, bytes)?.as_bytes());
    Ok(head)
}

/// Returns the bytes after a recording of this length.
#[must_use]
pub fn write_tail(recording_bytes: u64) -> Vec<u8> {
    vec![0; padding(recording_bytes) + END]
}

fn append(to: &mut Vec<u8>, name: &str, content: &[u8]) -> anyhow::Result<()> {
    let bytes = content.len() as u64;
    to.extend(make_header(name, bytes)?.as_bytes());
    to.extend(content);
    to.resize(to.len() + padding(bytes), 0);
    Ok(())
}

/// Returns the only header of an entry that a verifier accepts.
fn make_header(name: &str, bytes: u64) -> anyhow::Result<Header> {
    let mut header = Header::new_gnu();
    header.set_path(name).with_context(|| name.to_owned())?;
    header.set_size(bytes);
    header.set_mode(0o600);
    header.set_cksum();
    Ok(header)
}

/// Returns the number of zeros that complete the last block.
const fn padding(bytes: u64) -> usize {
    (BLOCK - (bytes % BLOCK as u64) as usize) % BLOCK
}

/// Verifies an exam file byte for byte with the public key published by the school. Returns its
/// manifest. Memory is bounded, whatever the file contains.
///
/// # Errors
/// Names the first entry that is not as signed; fails if the file cannot be read.
pub fn check(file: impl Read, published_key: &str) -> anyhow::Result<ExamManifest> {
    let mut file = ExamReader { file };
    let text = file.read_small(MANIFEST, MOST_MANIFEST_BYTES)?;
    let text = String::from_utf8(text).ok().context("manifest.json: not UTF-8")?;
    let signature = file.read_small(SIGNATURE, MOST_SIGNATURE_BYTES)?;
    let certificate = read_signature(&signature, text).context(SIGNATURE)?;
    let text = checked_text(&certificate, published_key).context("manifest.json, signed in signature.json")?;
    let manifest: ExamManifest = serde_json::from_str(text).context("manifest.json: not an exam file")?;
    ensure!(manifest.kind == ExamManifest::KIND, "manifest.json: not an exam file");
    ensure!(manifest.format == ExamManifest::FORMAT, "manifest.json: format {}; allowed: 1", manifest.format);
    check_entries(&manifest.entries)?;
    for entry in &manifest.entries {
        file.compare(entry)?;
    }
    file.finish()?;
    Ok(manifest)
}

/// Returns the signature over a text. Only the spelling that this program writes is accepted, so
/// that no byte of it is free.
fn read_signature(bytes: &[u8], text: String) -> anyhow::Result<Certificate> {
    let read: ExamSignature = serde_json::from_slice(bytes).context("not a signature")?;
    ensure!(serde_json::to_vec(&read)? == bytes, "not as this program writes it");
    let ExamSignature { public_key, signature } = read;
    ensure!(signature == signature.to_lowercase(), "not in lower case");
    Ok(Certificate { statement: text, public_key, signature })
}

/// Checks that a list of entries ends with the recording and has plain, distinct names.
fn check_entries(entries: &[ExamEntry]) -> anyhow::Result<()> {
    ensure!(entries.len() <= MOST_ENTRIES, "manifest.json: {} entries; at most {MOST_ENTRIES}", entries.len());
    let mut names = BTreeSet::from([MANIFEST, SIGNATURE]);
    for ExamEntry { name, .. } in entries {
        let is_plain = |part: &str| {
            !part.is_empty()
                && !part.starts_with('.')
                && part.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
        };
        ensure!(name.split('/').all(is_plain), "manifest.json: \"{name}\" is not a plain path");
        ensure!(names.insert(name), "manifest.json: {name} is listed twice");
    }
    ensure!(entries.last().is_some_and(|last| last.name == RECORDING), "manifest.json: {RECORDING} is not the last");
    Ok(())
}

/// Reads an exam file from its start to its end.
struct ExamReader<R> {
    file: R,
}

impl<R: Read> ExamReader<R> {
    /// Reads an entry whose length only its header states.
    fn read_small(&mut self, name: &str, most: usize) -> anyhow::Result<Vec<u8>> {
        let block = self.read_block(name)?;
        let bytes = Header::from_byte_slice(&block).entry_size();
        let bytes = bytes.ok().context("not a tar file").with_context(|| name.to_owned())?;
        ensure!(bytes <= most as u64, "{name}: {bytes} bytes; at most {most}");
        compare_header(&block, name, bytes)?;
        let mut content = Vec::new();
        (&mut self.file).take(bytes).read_to_end(&mut content).with_context(|| name.to_owned())?;
        ensure!(content.len() as u64 == bytes, "{name}: the file is truncated");
        self.read_zeros(padding(bytes), name)?;
        Ok(content)
    }

    /// Compares the next entry with the manifest.
    fn compare(&mut self, ExamEntry { name, bytes, sha256 }: &ExamEntry) -> anyhow::Result<()> {
        compare_header(&self.read_block(name)?, name, *bytes)?;
        let (mut hash, mut left, mut piece) = (Sha256::new(), *bytes, vec![0; PIECE]);
        while left > 0 {
            let most = if left < PIECE as u64 { left as usize } else { PIECE };
            match self.file.read(&mut piece[..most]).with_context(|| name.clone())? {
                0 => bail!("{name}: the file is truncated"),
                read => {
                    hash.update(&piece[..read]);
                    left -= read as u64;
                }
            }
        }
        ensure!(HEXLOWER.encode(&hash.finalize()) == *sha256, "{name}: the content was changed");
        self.read_zeros(padding(*bytes), name)
    }

    /// Checks that nothing follows but the end of the archive.
    fn finish(&mut self) -> anyhow::Result<()> {
        self.read_zeros(END, "the end of the file")?;
        ensure!(self.file.read(&mut [0])? == 0, "the end of the file: more bytes follow");
        Ok(())
    }

    fn read_block(&mut self, name: &str) -> anyhow::Result<[u8; BLOCK]> {
        let mut block = [0; BLOCK];
        self.file.read_exact(&mut block).context("the file is truncated").with_context(|| name.to_owned())?;
        Ok(block)
    }

    fn read_zeros(&mut self, number: usize, name: &str) -> anyhow::Result<()> {
        let mut zeros = [0; END];
        let zeros = &mut zeros[..number];
        self.file.read_exact(zeros).context("the file is truncated").with_context(|| name.to_owned())?;
        ensure!(zeros.iter().all(|byte| *byte == 0), "{name}: bytes outside the entries");
        Ok(())
    }
}

fn compare_header(block: &[u8; BLOCK], name: &str, bytes: u64) -> anyhow::Result<()> {
    let header = make_header(name, bytes)?;
    ensure!(block == header.as_bytes(), "{name}: missing or out of place, or its tar header was changed");
    Ok(())
}
