//! A connection to the service, from the address to the first frame.

use std::io;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use tungstenite::client::client_with_config;
use tungstenite::http::Uri;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, Utf8Bytes, WebSocket};

use super::Inverse3Error;
use super::command::FULL_STATE;
use super::state::StateFrame;
use crate::clock;

/// Time-out of a connection attempt.
const CONNECT: Duration = Duration::from_secs(1);
/// Time-out of the first frame, in s.
pub const FIRST_FRAME_S: u64 = 2;
/// Read time-out, after which the caller checks the clock.
const READ: Duration = Duration::from_millis(5);
/// Write time-out, for a service that does not read.
const WRITE: Duration = Duration::from_millis(100);
/// Maximum size of a frame, which is normally a few kilobytes.
const LARGEST_FRAME: usize = 1 << 20;

/// A connection.
pub struct Inverse3Session {
    socket: WebSocket<TcpStream>,
    /// Address of the service.
    pub address: SocketAddr,
}

impl Inverse3Session {
    /// Connects, with Nagle's algorithm disabled.
    pub fn connect(url: &str) -> Result<Self, Inverse3Error> {
        let unreachable = |why: String| Inverse3Error::Unreachable { url: url.to_owned(), why };
        let (stream, address) = reach(url).map_err(unreachable)?;
        let prepare = || {
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(Duration::from_secs(FIRST_FRAME_S)))?;
            stream.set_write_timeout(Some(WRITE))
        };
        prepare().map_err(|error: io::Error| unreachable(error.to_string()))?;
        let config = WebSocketConfig::default()
            .read_buffer_size(16 << 10)
            .max_message_size(Some(LARGEST_FRAME))
            .max_frame_size(Some(LARGEST_FRAME));
        let (socket, _) = client_with_config(url, stream, Some(config)).map_err(|error| {
            let why = match error {
                HandshakeError::Failure(error) => error.to_string(),
                HandshakeError::Interrupted(_) => "it does not answer the handshake".to_owned(),
            };
            Inverse3Error::NotTheService { url: url.to_owned(), why }
        })?;
        let this = Self { socket, address };
        this.socket.get_ref().set_read_timeout(Some(READ)).map_err(|error| unreachable(error.to_string()))?;
        Ok(this)
    }

    /// Returns the first frame that lists devices with their configuration; requests one if
    /// necessary.
    pub fn inventory(&mut self, url: &str) -> Result<Utf8Bytes, Inverse3Error> {
        let deadline = clock::instant() + Duration::from_secs(FIRST_FRAME_S);
        let silent = || Inverse3Error::Silent { url: url.to_owned(), seconds: FIRST_FRAME_S };
        let first = self.text_before(deadline).ok_or_else(silent)?;
        match StateFrame::read(&first) {
            None => Err(Inverse3Error::NotUnderstood { url: url.to_owned(), start: first.chars().take(60).collect() }),
            Some(frame) if frame.is_full() => Ok(first),
            Some(_) => {
                self.send(FULL_STATE).ok().ok_or_else(silent)?;
                // A service that ignores the request may still have listed its devices in the first
                // frame.
                Ok(self.full_text_before(deadline).unwrap_or(first))
            }
        }
    }

    fn full_text_before(&mut self, deadline: Instant) -> Option<Utf8Bytes> {
        loop {
            let text = self.text_before(deadline)?;
            if StateFrame::read(&text).is_some_and(|frame| frame.is_full()) {
                return Some(text);
            }
        }
    }

    fn text_before(&mut self, deadline: Instant) -> Option<Utf8Bytes> {
        while clock::instant() < deadline {
            if let Some(text) = self.receive().ok()? {
                return Some(text);
            }
        }
        None
    }

    /// Sends a text.
    pub fn send(&mut self, text: &str) -> Result<(), Error> {
        self.socket.send(Message::text(text))
    }

    /// Returns the next text, if one arrives within some milliseconds.
    ///
    /// # Errors
    /// If the connection is closed or broken.
    pub fn receive(&mut self) -> Result<Option<Utf8Bytes>, Error> {
        match self.socket.read() {
            Ok(Message::Text(text)) => Ok(Some(text)),
            Ok(Message::Close(_)) => Err(Error::ConnectionClosed),
            Ok(_) => Ok(None),
            Err(Error::Io(error)) if is_later(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Returns a text that has already arrived, without waiting.
    ///
    /// # Errors
    /// If the connection is closed or broken.
    pub fn arrived(&mut self) -> Result<Option<Utf8Bytes>, Error> {
        self.socket.get_ref().set_nonblocking(true)?;
        let text = self.receive();
        self.socket.get_ref().set_nonblocking(false)?;
        text
    }

    /// Closes with a handshake: dropping a socket with unread data may discard the last message
    /// sent, the zero force.
    pub fn close(&mut self, patience: Duration) {
        let deadline = clock::instant() + patience;
        let mut open = self.socket.close(None).is_ok() && self.socket.flush().is_ok();
        while open && clock::instant() < deadline {
            open = match self.socket.read() {
                Ok(_) => true,
                Err(Error::Io(error)) => is_later(&error),
                Err(_) => false,
            };
        }
    }
}

fn is_later(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}

/// Connects to the host of the URL, trying each of its addresses in turn.
fn reach(url: &str) -> Result<(TcpStream, SocketAddr), String> {
    let uri: Uri = url.parse().map_err(|error| format!("not an address: {error}"))?;
    let host = uri.host().filter(|_| uri.scheme_str() == Some("ws")).ok_or("an address begins with ws://HOST")?;
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let addresses = (host, uri.port_u16().unwrap_or(80)).to_socket_addrs().map_err(|error| error.to_string())?;
    let mut why = "the host has no address".to_owned();
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => return Ok((stream, address)),
            Err(error) => why = error.to_string(),
        }
    }
    Err(why)
}
