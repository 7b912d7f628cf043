//! A stand-in for the Haply Inverse Service: it answers each message with one state, as the service does, and says its version
//! over HTTP on the same port, as 3.5 is documented to, or on another, as 3.0 is. A force in a field that it does not know it ignores. What it says is stated here a second time on purpose; it shares no code with the driver.

#![expect(clippy::expect_used, reason = "a stand-in that cannot do its part has nobody to tell but the test")]

mod says;

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

pub use says::{Grip, State, first, state};
use serde_json::{Map, Value};
use tungstenite::{Message, WebSocket, accept};

/// How the service behaves.
#[derive(Clone, Debug)]
pub struct Script {
    /// What it answers to `GET /version` on the port of its WebSocket; nothing if absent.
    pub version: Option<&'static str>,
    /// What it answers on a port of its own; nobody listens there if absent.
    pub version_elsewhere: Option<&'static str>,
    /// The fields in which it understands a force.
    pub understands: &'static [&'static str],
    /// Its first frame; none if it says nothing.
    pub first: Option<String>,
    /// What the arm and its grip are like.
    pub state: State,
    /// How long it thinks before it answers.
    pub delay: Duration,
    /// States that it sends for each message; the service itself sends one.
    pub answers: usize,
    /// The message at which something happens, counted from 0.
    pub at_message: usize,
    /// What happens then, and from then on.
    pub then: Then,
}

/// What happens to a service in use.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// Nothing.
    Nothing,
    /// It closes the connection as the protocol wants it.
    Close,
    /// The connection breaks.
    Break,
    /// The connection breaks, and the next one holds.
    BreakOnce,
    /// It answers no more.
    Silence,
    /// It answers with this.
    Say(String),
}

impl Default for Script {
    fn default() -> Self {
        let state = State::default();
        Self {
            version: Some("3.5.0"),
            version_elsewhere: None,
            understands: &["vector"],
            first: Some(first(&state)),
            state,
            delay: Duration::ZERO,
            answers: 1,
            at_message: usize::MAX,
            then: Then::Nothing,
        }
    }
}

/// A running service, ended when dropped.
pub struct Service {
    /// Where it listens, as the driver wants it.
    pub url: String,
    /// The port on which it says its version besides; 0 for none.
    pub version_port: u16,
    address: SocketAddr,
    heard: Arc<Heard>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What all connections share.
#[derive(Default)]
struct Heard {
    texts: Mutex<Vec<String>>,
    /// A connection has broken.
    broken: AtomicBool,
    /// Where somebody holds the handle.
    held_m: Mutex<Option<[f64; 3]>>,
}

impl Heard {
    fn note(&self, text: &str) {
        self.texts.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
    }
}

/// What is noted when the client closes the connection as the protocol wants it.
pub const CLOSED: &str = "closed";

impl Service {
    /// Starts a service on a free port.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn start(script: Script) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let version_port = script.version_elsewhere.map_or(0, elsewhere);
        let (heard, stop) = (Arc::<Heard>::default(), Arc::new(AtomicBool::new(false)));
        let (noted, stopped) = (Arc::clone(&heard), Arc::clone(&stop));
        let thread = thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                serve(stream, &script, &noted);
            }
        });
        Self { url: format!("ws://{address}"), version_port, address, heard, stop, thread: Some(thread) }
    }

    /// Holds the handle at a place from now on, in m along the service's axes from where it started.
    pub fn hold(&self, held_m: [f64; 3]) {
        *self.heard.held_m.lock().unwrap_or_else(PoisonError::into_inner) = Some(held_m);
    }

    /// The texts it heard, in order, and [`CLOSED`].
    #[must_use]
    pub fn heard(&self) -> Vec<String> {
        self.heard.texts.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The forces it was told, in N in its own axes, with the names of the fields that held each.
    #[must_use]
    pub fn forces_n(&self) -> Vec<(String, [f64; 3])> {
        self.heard().iter().filter_map(|text| told(text)).collect()
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // Wakes the thread that waits for a connection; it may have ended by itself.
        let _woken = TcpStream::connect(self.address);
        if let Some(thread) = self.thread.take() {
            let _ended = thread.join();
        }
    }
}

/// The command that sets a force.
fn command(text: &str) -> Option<Map<String, Value>> {
    let said: Value = serde_json::from_str(text).ok()?;
    said["inverse3"][0]["commands"]["set_cursor_force"].as_object().cloned()
}

fn vector(force_n: &Value) -> Option<[f64; 3]> {
    let part = |name: &str| force_n[name].as_f64();
    Some([part("x")?, part("y")?, part("z")?])
}

fn told(text: &str) -> Option<(String, [f64; 3])> {
    let command = command(text)?;
    let fields: Vec<&str> = command.keys().map(String::as_str).collect();
    let force_n = command.values().find_map(vector)?;
    assert!(command.values().all(|other| vector(other) == Some(force_n)), "one force, however it is spelled: {text}");
    Some((fields.join("+"), force_n))
}

/// Says a version on a port of its own, for as long as the test runs.
fn elsewhere(version: &'static str) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    thread::spawn(move || listener.incoming().flatten().for_each(|stream| say_version(stream, Some(version))));
    port
}

/// A connection: HTTP for the version, or a WebSocket to its end. Connections are served one after the other, but the
/// version is asked while a WebSocket is open, so that one has a thread of its own.
fn serve(stream: TcpStream, script: &Script, heard: &Arc<Heard>) {
    let mut start = [0; 12];
    let asked = stream.peek(&mut start).unwrap_or(0);
    if start[..asked].starts_with(b"GET /version") {
        return say_version(stream, script.version);
    }
    let (script, heard) = (script.clone(), Arc::clone(heard));
    thread::spawn(move || {
        if let Ok(socket) = accept(stream) {
            // A client that is gone ends the connection.
            let _ended = converse(socket, &script, &heard);
        }
    });
}

fn say_version(mut stream: TcpStream, version: Option<&str>) {
    let answer = match version {
        Some(version) => format!("HTTP/1.1 200 OK\r\n\r\n{{\"git_tag\":\"{version}\",\"project_name\":\"stand-in\"}}"),
        None => "HTTP/1.1 404 Not Found\r\n\r\n".to_owned(),
    };
    let mut request = [0; 512];
    // Read before the answer, or closing would take the answer back.
    let _asked = stream.read(&mut request);
    let _answered = stream.write_all(answer.as_bytes());
}

fn converse(mut socket: WebSocket<TcpStream>, script: &Script, heard: &Heard) -> tungstenite::Result<()> {
    if let Some(first) = &script.first {
        socket.send(Message::text(first.as_str()))?;
    }
    let mut arm = script.state.clone();
    for message in 0.. {
        match socket.read()? {
            Message::Text(text) => {
                heard.note(&text);
                let command = command(&text).unwrap_or_default();
                let understood = script.understands.iter().find_map(|&field| command.get(field).and_then(vector));
                arm.force_n = understood.unwrap_or(arm.force_n);
            }
            Message::Close(_) => heard.note(CLOSED),
            _ => {}
        }
        thread::sleep(script.delay);
        arm.held_m = *heard.held_m.lock().unwrap_or_else(PoisonError::into_inner);
        match &script.then {
            _ if message < script.at_message => answer(&mut socket, (script, &arm), message)?,
            Then::Nothing => answer(&mut socket, (script, &arm), message)?,
            Then::BreakOnce if heard.broken.load(Ordering::Relaxed) => answer(&mut socket, (script, &arm), message)?,
            Then::Close => socket.close(None)?,
            Then::Break => return Ok(()),
            Then::BreakOnce => {
                heard.broken.store(true, Ordering::Relaxed);
                return Ok(());
            }
            Then::Silence => {}
            Then::Say(text) => socket.send(Message::text(text.as_str()))?,
        }
    }
    Ok(())
}

fn answer(
    socket: &mut WebSocket<TcpStream>,
    (script, arm): (&Script, &State),
    message: usize,
) -> tungstenite::Result<()> {
    for answer in 0..script.answers {
        socket.send(Message::text(state(arm, message * script.answers + answer + 1)))?;
    }
    Ok(())
}
