//! A real `web-admin serve`, spoken to byte by byte.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use model::Role;
use serde_json::Value;

use super::App;
use super::database::program;

/// A real `web-admin serve`, killed when dropped.
pub struct Service {
    pub child: Child,
    pub address: String,
    pub greeting: String,
}

impl Service {
    pub fn start(folder: &Path) -> Self {
        Self::start_with(folder, &[])
    }

    /// With variables in its environment.
    pub fn start_with(folder: &Path, environment: &[(&str, &Path)]) -> Self {
        let mut command = Self::command(folder);
        Self::run(command.envs(environment.iter().copied()).stderr(Stdio::null()))
    }

    /// With further options, its log in a file.
    pub fn start_logging(folder: &Path, options: &[&str], log: &Path) -> Self {
        let log = std::fs::File::create(log).unwrap();
        Self::run(Self::command(folder).args(options).stderr(log))
    }

    fn command(folder: &Path) -> Command {
        let mut command = program(folder);
        command.args(["serve", "--listen", "127.0.0.1:0"]);
        command
    }

    fn run(command: &mut Command) -> Self {
        let child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut service = Self { child, address: String::new(), greeting: String::new() };
        let mut lines = BufReader::new(service.child.stdout.take().unwrap()).lines().map(Result::unwrap);
        while service.address.is_empty() {
            let line = lines.next().expect("the service prints its address");
            match line.split_once("http://") {
                Some((_, address)) => address.trim().clone_into(&mut service.address),
                None => service.greeting += &line,
            }
        }
        service
    }

    pub fn signal(&self, name: &str) {
        assert!(Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap().success());
    }

    /// Sends the head of a request and `part` of the body.
    pub fn begin(&self, head: &str, token: &str, part: &[u8]) -> TcpStream {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let head = format!("{head}\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(part).unwrap();
        stream
    }

    pub fn upload(&self, token: &str, whole: &[u8], sent: usize) -> TcpStream {
        let head = format!(
            "POST /api/v1/sessions HTTP/1.1\r\nContent-Type: application/octet-stream\r\nContent-Length: {}",
            whole.len()
        );
        self.begin(&head, token, &whole[..sent])
    }

    /// Sends the bytes of a piece, or only the first `sent` of them.
    pub fn piece(&self, token: &str, (path, offset): (&str, usize), bytes: &[u8], sent: usize) -> TcpStream {
        let head = format!(
            "PATCH {path} HTTP/1.1\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: {offset}\r\n\
             Content-Type: application/offset+octet-stream\r\nContent-Length: {}",
            bytes.len()
        );
        self.begin(&head, token, &bytes[..sent])
    }

    /// Status and body of a page.
    pub fn get(&self, path: &str) -> (u16, String) {
        answer(self.begin(&format!("GET {path} HTTP/1.1"), "", &[]))
    }

    /// Ids of the listed sessions.
    pub fn listed(&self, token: &str) -> Vec<String> {
        let (status, body) = answer(self.begin("GET /api/v1/sessions HTTP/1.1", token, &[]));
        assert_eq!(status, 200, "{body}");
        let list: Value = serde_json::from_str(&body).unwrap();
        let sessions = list["sessions"].as_array().unwrap().iter();
        sessions.map(|session| session["session_id"].as_str().unwrap().to_owned()).collect()
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn answer(stream: TcpStream) -> (u16, String) {
    let (status, _, body) = whole_answer(stream);
    (status, body)
}

/// Status, head in lower case, and body.
pub fn whole_answer(mut stream: TcpStream) -> (u16, String, String) {
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let (head, body) = text.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), head.to_lowercase(), body.to_owned())
}

/// The value of a header in a head.
pub fn header<'a>(head: &'a str, name: &str) -> &'a str {
    head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": ")).unwrap_or("")
}

/// A folder with one trainee; their token.
pub async fn founded() -> (tempfile::TempDir, String) {
    let app = App::new().await;
    let school = app.school("North").await;
    let token = app.member(school, Role::Trainee, "ada@example.org").await.token;
    app.state.db.close().await;
    (app.folder, token)
}
