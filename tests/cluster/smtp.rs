//! A mail server that takes everything, and remembers what came.

use std::io::{self, BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// The server.
#[derive(Debug)]
pub struct MailServer {
    /// Where it listens.
    pub port: u16,
    taken: Arc<Mutex<Vec<String>>>,
}

impl MailServer {
    /// Takes letters until the process ends.
    pub fn start() -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let port = listener.local_addr()?.port();
        let taken = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&taken);
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let kept = Arc::clone(&kept);
                // A client that is killed has nobody left to be told.
                thread::spawn(move || drop(converse(client, &kept)));
            }
        });
        Ok(Self { port, taken })
    }

    /// To whom every letter went that was taken so far.
    pub fn taken(&self) -> Vec<String> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Speaks as much of SMTP (RFC 5321) as it takes to be sent letters.
fn converse(client: TcpStream, taken: &Mutex<Vec<String>>) -> io::Result<()> {
    let mut out = client.try_clone()?;
    let mut lines = BufReader::new(client).lines();
    let mut to = String::new();
    out.write_all(b"220 here\r\n")?;
    while let Some(line) = lines.next() {
        let line = line?;
        let answer: &[u8] = match line.split([' ', ':']).next().unwrap_or_default().to_ascii_uppercase().as_str() {
            "RCPT" => {
                to = line.split(['<', '>']).nth(1).unwrap_or_default().to_owned();
                b"250 known\r\n"
            }
            "DATA" => {
                out.write_all(b"354 go on\r\n")?;
                skip_letter(&mut lines)?;
                // It is taken before its sender can know: as with every server.
                taken.lock().unwrap_or_else(PoisonError::into_inner).push(to.clone());
                b"250 taken\r\n"
            }
            "QUIT" => {
                out.write_all(b"221 bye\r\n")?;
                return Ok(());
            }
            _ => b"250 well\r\n",
        };
        out.write_all(answer)?;
    }
    Ok(())
}

/// Reads a letter to its end. One that breaks off is none.
fn skip_letter(lines: &mut impl Iterator<Item = io::Result<String>>) -> io::Result<()> {
    for line in lines {
        if line? == "." {
            return Ok(());
        }
    }
    Err(io::ErrorKind::UnexpectedEof.into())
}
