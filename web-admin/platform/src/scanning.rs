//! Malware scanning of uploads by ClamAV's `clamd`: its command `INSTREAM` over a local socket.
//!
//! The file is sent in chunks, each preceded by its length as four bytes, big-endian; a length of
//! zero ends it. The response is `stream: OK`, `stream: NAME FOUND`, or a text that ends in
//! `ERROR`, terminated by a zero byte.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use model::count_u32;
use model::single_line_text::on_one_line;
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::UnixStream;

/// Command to scan the data that follows. The prefix `z` makes command and response end with a zero
/// byte.
const INSTREAM: &[u8] = b"zINSTREAM\0";
/// Size of a chunk, in bytes.
const PIECE: usize = 64 * 1024;
/// Maximum length of a response, in bytes: a name and a few words.
const LONGEST_ANSWER: u64 = 4096;
/// Maximum length of a malware name, in characters.
const LONGEST_NAME: usize = 200;

/// Socket and time limit of a scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scanner {
    /// The socket of `clamd`.
    pub socket: PathBuf,
    /// Time limit for scanning a file.
    pub time: Duration,
}

/// Verdict of a scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScanVerdict {
    /// No malware was found.
    Clean,
    /// Malware of this name was found.
    Found(String),
}

impl Scanner {
    /// Scans a file.
    ///
    /// # Errors
    /// Fails if the scanner cannot be reached, takes too long or has not scanned the whole file, or
    /// if the file cannot be read.
    pub async fn scan(&self, file: &Path) -> anyhow::Result<ScanVerdict> {
        let asked = tokio::time::timeout(self.time, self.ask(file)).await;
        let answer =
            asked.with_context(|| format!("the scanner has not responded for {} s", self.time.as_secs()))??;
        verdict(&answer)
    }

    /// Sends a file and returns the response.
    async fn ask(&self, file: &Path) -> anyhow::Result<String> {
        let mut file = File::open(file).await.context("cannot read the received file")?;
        let socket = UnixStream::connect(&self.socket).await;
        let mut socket = socket.with_context(|| format!("no scanner responds at {}", self.socket.display()))?;
        let sent = send(&mut file, &mut socket).await;
        let mut answer = Vec::new();
        // A scanner whose size limit is exceeded responds and closes early, so prefer its response
        // to the write error.
        let read = (&mut socket).take(LONGEST_ANSWER).read_to_end(&mut answer).await;
        if answer.is_empty() {
            sent.context("the scanner does not accept the file")?;
            read.context("the scanner does not respond")?;
            bail!("the scanner closed the connection without a response");
        }
        Ok(String::from_utf8_lossy(&answer).trim_end_matches('\0').trim().to_owned())
    }
}

/// Sends the command, the file in chunks, and the end marker.
async fn send(file: &mut File, socket: &mut UnixStream) -> std::io::Result<()> {
    socket.write_all(INSTREAM).await?;
    let mut piece = vec![0; PIECE];
    loop {
        let length = file.read(&mut piece).await?;
        let announced = count_u32(length).to_be_bytes();
        socket.write_all(&announced).await?;
        if length == 0 {
            return socket.flush().await;
        }
        socket.write_all(&piece[..length]).await?;
    }
}

/// Parses a response. Anything but the two known verdicts is an error.
fn verdict(answer: &str) -> anyhow::Result<ScanVerdict> {
    let said = answer.strip_prefix("stream: ").filter(|said| !said.contains('\n'));
    if said == Some("OK") {
        return Ok(ScanVerdict::Clean);
    }
    match said.and_then(|said| said.strip_suffix(" FOUND")) {
        Some(name) => Ok(ScanVerdict::Found(on_one_line(name).chars().take(LONGEST_NAME).collect())),
        None => {
            bail!(
                "the scanner responded \"{}\": is clamd's StreamMaxLength less than --max-upload-mb?",
                on_one_line(answer)
            )
        }
    }
}

#[cfg(test)]
mod tests {
    //! A response that is not a verdict must not be taken for one.

    use super::*;

    #[test]
    fn only_a_whole_word_for_a_file_lets_it_in() {
        assert_eq!(verdict("stream: OK").unwrap(), ScanVerdict::Clean);
        let found = verdict("stream: Win.Test.EICAR_HDB-1 FOUND").unwrap();
        assert_eq!(found, ScanVerdict::Found("Win.Test.EICAR_HDB-1".to_owned()));
        for nothing in [
            "",
            "OK",
            "stream:OK",
            "stream: OK\nstream: X FOUND",
            "INSTREAM size limit exceeded. ERROR",
            "stream: Can't allocate memory ERROR",
            "COMMAND READ TIMED OUT",
            "UNKNOWN COMMAND",
        ] {
            assert!(verdict(nothing).is_err(), "{nothing}");
        }
        let Ok(ScanVerdict::Found(name)) = verdict(&format!("stream: {} FOUND", "x\u{202e}".repeat(500))) else {
            panic!("something was found")
        };
        assert!(name.chars().count() <= LONGEST_NAME && !name.contains('\u{202e}'), "{name}");
    }
}
