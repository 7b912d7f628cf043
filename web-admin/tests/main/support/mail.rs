//! A mail server that answers when it is told to.

use std::io::{self, BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// The server. It ends with the test.
pub struct MailServer {
    /// Where it listens.
    pub url: String,
    /// Every letter that was handed over.
    pub letters: Receiver<String>,
    /// What it answers to the next letter.
    pub answers: Sender<&'static str>,
}

impl MailServer {
    pub fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("smtp://{}", listener.local_addr().unwrap());
        let ((taken, letters), (answers, to_say)) = (channel(), channel());
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                // A client that is killed has nobody left to be told.
                let _ = converse(client, &taken, &to_say);
            }
        });
        Self { url, letters, answers }
    }
}

/// Speaks as much of SMTP as it takes to be sent letters.
fn converse(client: TcpStream, taken: &Sender<String>, to_say: &Receiver<&'static str>) -> io::Result<()> {
    let mut out = client.try_clone()?;
    let mut lines = BufReader::new(client).lines();
    out.write_all(b"220 here\r\n")?;
    while let Some(line) = lines.next() {
        let answer = match line?.as_str() {
            "DATA" => {
                out.write_all(b"354 go on\r\n")?;
                let letter: Vec<String> = lines.by_ref().map_while(Result::ok).take_while(|line| line != ".").collect();
                let (Ok(()), Ok(answer)) = (taken.send(letter.join("\n")), to_say.recv()) else { return Ok(()) };
                answer
            }
            "QUIT" => return Ok(()),
            _ => "250 well",
        };
        write!(out, "{answer}\r\n")?;
    }
    Ok(())
}
