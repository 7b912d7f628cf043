//! A stand-in for the service: a socket that reads requests and gives prepared answers, one per connection.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::{self, JoinHandle};

/// What a client sent.
pub struct Request {
    /// Request line and headers, in lower case.
    pub head: String,
    /// Body.
    pub body: Vec<u8>,
}

/// A service that will answer a known number of connections.
pub struct StandIn {
    /// Where it listens, as `--server` wants it.
    pub address: String,
    thread: JoinHandle<Vec<Request>>,
}

impl StandIn {
    /// Starts a service that gives each answer once, in order.
    pub fn answering(answers: &[String]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("http://{}", listener.local_addr().expect("an address"));
        let answers = answers.to_vec();
        let thread = thread::spawn(move || {
            answers.iter().map(|answer| serve(&mut listener.accept().expect("a client").0, answer)).collect()
        });
        Self { address, thread }
    }

    /// What was asked, once every answer is given.
    pub fn requests(self) -> Vec<Request> {
        self.thread.join().expect("the stand-in ends")
    }
}

/// An answer with a JSON body.
pub fn answer(status: &str, media_type: &str, body: &str) -> String {
    let length = body.len();
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {media_type}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
    )
}

/// An upload was begun; its id is `u1`.
pub fn begun() -> String {
    "HTTP/1.1 201 Created\r\nLocation: /api/v1/uploads/u1\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".to_owned()
}

/// So many bytes of it are there.
pub fn arrived(bytes: usize) -> String {
    format!("HTTP/1.1 204 No Content\r\nUpload-Offset: {bytes}\r\nConnection: close\r\n\r\n")
}

/// It has become a session.
pub fn became(session: &str) -> String {
    format!("HTTP/1.1 204 No Content\r\nStylet-Session: {session}\r\nConnection: close\r\n\r\n")
}

fn serve(stream: &mut TcpStream, answer: &str) -> Request {
    let mut reader = BufReader::new(stream.try_clone().expect("a second handle"));
    let mut head = String::new();
    while !head.ends_with("\r\n\r\n") {
        assert_ne!(reader.read_line(&mut head).expect("a head"), 0, "the client left: {head}");
    }
    let head = head.to_ascii_lowercase();
    let length =
        head.lines().find_map(|line| line.strip_prefix("content-length: ")).map_or(0, |n| n.parse().expect("a length"));
    let mut body = vec![0; length];
    reader.read_exact(&mut body).expect("a body");
    stream.write_all(answer.as_bytes()).expect("an answer");
    Request { head, body }
}
