//! The tar file of a backup: written once, then read back and checked.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use anyhow::{Context, bail, ensure};
use data_encoding::HEXLOWER;
use platform::recording_store::RecordingStore;
use sha2::{Digest, Sha256};
use store::recordings::sessions::RecordingFile;
use tar::{Archive, Builder, EntryType, Header, HeaderMode};

use super::{DATABASE, MANIFEST, Manifest, RECORDINGS, SMALL};

/// Size limit for a manifest, in bytes; real ones are far smaller.
const MOST_MANIFEST_BYTES: u64 = 1 << 16;

/// Sources of an archive.
pub(super) struct Sources<'a> {
    /// Copy of the database.
    pub database: &'a Path,
    /// Small files by name.
    pub small: &'a BTreeMap<String, Vec<u8>>,
    /// Recording store.
    pub store: &'a RecordingStore,
}

/// Writes an archive and syncs it to disk.
pub(super) async fn write(
    to: File,
    manifest: &Manifest,
    sources: &Sources<'_>,
    recordings: &[RecordingFile],
) -> anyhow::Result<()> {
    let mut archive = Builder::new(BufWriter::new(to));
    archive.mode(HeaderMode::Deterministic);
    append(&mut archive, MANIFEST, &serde_json::to_vec_pretty(manifest)?)?;
    archive.append_path_with_name(sources.database, DATABASE)?;
    for (name, bytes) in sources.small {
        append(&mut archive, name, bytes)?;
    }
    let bar = indicatif::ProgressBar::new(recordings.len() as u64);
    for recording in recordings {
        let file = sources.store.fetch(&recording.recording_path).await;
        let file = file.with_context(|| recording.recording_path.clone())?;
        let name = Path::new(RECORDINGS).join(&recording.recording_path);
        archive.append_path_with_name(file.path(), name).with_context(|| file.path().display().to_string())?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut file = archive.into_inner()?;
    file.flush()?;
    Ok(file.get_ref().sync_all()?)
}

fn append(archive: &mut Builder<impl Write>, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let mut header = Header::new_gnu();
    header.set_size(bytes.len() as u64);
    header.set_mode(0o600);
    archive.append_data(&mut header, name, bytes)
}

/// Reads the manifest, which is the first file of an archive.
pub(super) fn manifest(path: &Path) -> anyhow::Result<Manifest> {
    let file = File::open(path)?;
    let mut archive = Archive::new(BufReader::new(file));
    let first = archive.entries()?.next().context("not a backup: the file is empty")?;
    let mut entry = first.context("not a tar file, or a truncated one")?;
    ensure!(entry.path()?.as_os_str() == MANIFEST, "not a backup: {MANIFEST} is missing");
    let mut text = Vec::new();
    (&mut entry).take(MOST_MANIFEST_BYTES).read_to_end(&mut text)?;
    serde_json::from_slice(&text).with_context(|| MANIFEST.to_owned())
}

/// Checks that the archive holds exactly the expected files, each with its expected hash.
pub(super) fn check(path: &Path, manifest: &Manifest, recordings: &[RecordingFile]) -> anyhow::Result<()> {
    let named = |r: &RecordingFile| (format!("{RECORDINGS}/{}", r.recording_path), r.recording_sha256.clone());
    let mut expected: BTreeMap<String, String> = recordings.iter().map(named).collect();
    expected.insert(DATABASE.to_owned(), manifest.database_sha256.clone());
    expected.extend(manifest.files.clone());
    each_file(path, |name, content| {
        let sha256 = hash(content)?;
        match expected.remove(name) {
            Some(wanted) => ensure!(wanted == sha256, "{name}: the bytes do not match the stored hash"),
            None => ensure!(name == MANIFEST, "{name}: not listed in the manifest"),
        }
        Ok(())
    })?;
    match expected.keys().next() {
        Some(missing) => bail!("{missing}: missing"),
        None => Ok(()),
    }
}

/// Unpacks an archive into an empty folder and syncs each file before the next.
pub(super) fn unpack(path: &Path, folder: &Path) -> anyhow::Result<()> {
    each_file(path, |name, content| {
        let single = name == MANIFEST || name == DATABASE || SMALL.contains(&name);
        let known = single || name.starts_with(&format!("{RECORDINGS}/"));
        let plain = Path::new(name).components().all(|part| matches!(part, std::path::Component::Normal(_)));
        ensure!(known && plain, "{name}: not part of a backup");
        let place = folder.join(name);
        std::fs::create_dir_all(place.parent().unwrap_or(folder))?;
        let mut file = File::create_new(&place).with_context(|| name.to_owned())?;
        std::io::copy(content, &mut file)?;
        Ok(file.sync_all()?)
    })
}

/// Calls `take` with the name and content of each file in an archive. Anything but a regular file
/// is an error.
fn each_file(path: &Path, mut take: impl FnMut(&str, &mut dyn Read) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    for entry in Archive::new(BufReader::new(file)).entries()? {
        let mut entry = entry.context("not a tar file, or a truncated one")?;
        let name = entry.path()?.to_str().context("a file name that is not UTF-8")?.to_owned();
        ensure!(entry.header().entry_type() == EntryType::Regular, "{name}: not a regular file");
        take(&name, &mut entry)?;
    }
    Ok(())
}

fn hash(content: &mut dyn Read) -> std::io::Result<String> {
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match content.read(&mut piece)? {
            0 => return Ok(HEXLOWER.encode(&hash.finalize())),
            read => hash.update(&piece[..read]),
        }
    }
}
