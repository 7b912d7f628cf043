//! A network between the services and what they need: it carries, cuts, holds back, and slows down.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How often a connection that is held back looks whether it still is.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// What a network does with what is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weather {
    /// Everything arrives.
    Fair,
    /// Connections are ended, and new ones too.
    Cut,
    /// Nothing arrives, and nobody is told.
    Silent,
    /// Each piece arrives so much later.
    Slow(Duration),
}

/// Where what is sent goes.
#[derive(Clone, Debug)]
pub enum Destination {
    /// A socket of this machine.
    Socket(PathBuf),
    /// A port of this machine.
    Port(u16),
}

/// Both ends of what is carried can be read, written, ended and had twice.
trait Stream: Read + Write + Send + Sized {
    fn twin(&self) -> io::Result<Self>;
    fn end(&self);
}

impl Stream for TcpStream {
    fn twin(&self) -> io::Result<Self> {
        self.try_clone()
    }

    fn end(&self) {
        // It may be over already.
        let _ = self.shutdown(Shutdown::Both);
    }
}

impl Stream for UnixStream {
    fn twin(&self) -> io::Result<Self> {
        self.try_clone()
    }

    fn end(&self) {
        let _ = self.shutdown(Shutdown::Both);
    }
}

/// What the weather is, and how often connections were cut.
#[derive(Debug)]
struct Sky {
    weather: Mutex<Weather>,
    cuts: AtomicU64,
}

impl Sky {
    fn weather(&self) -> Weather {
        *self.weather.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until a piece may go on; false where its connection has been cut since `cuts`.
    fn lets_pass(&self, cuts: u64) -> bool {
        if let Weather::Slow(delay) = self.weather() {
            thread::sleep(delay);
        }
        while self.weather() == Weather::Silent && self.cuts.load(SeqCst) == cuts {
            thread::sleep(LOOK_EVERY);
        }
        self.cuts.load(SeqCst) == cuts
    }
}

/// A network.
#[derive(Debug)]
pub struct Relay {
    /// Where it takes connections.
    pub port: u16,
    sky: Arc<Sky>,
}

impl Relay {
    /// Carries connections until the process ends.
    pub fn to(destination: Destination) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let port = listener.local_addr()?.port();
        let sky = Arc::new(Sky { weather: Mutex::new(Weather::Fair), cuts: AtomicU64::new(0) });
        let above = Arc::clone(&sky);
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let (sky, destination) = (Arc::clone(&above), destination.clone());
                thread::spawn(move || connect(client, &destination, &sky));
            }
        });
        Ok(Self { port, sky })
    }

    /// Changes what becomes of what is sent.
    pub fn turn(&self, weather: Weather) {
        *self.sky.weather.lock().unwrap_or_else(PoisonError::into_inner) = weather;
        if weather == Weather::Cut {
            self.sky.cuts.fetch_add(1, SeqCst);
        }
    }
}

/// Connects both sides. Where nobody listens, the client is told so by the end of its connection.
fn connect(client: TcpStream, destination: &Destination, sky: &Arc<Sky>) {
    let cuts = sky.cuts.load(SeqCst);
    if sky.weather() == Weather::Cut || !sky.lets_pass(cuts) {
        return;
    }
    // Small pieces are a conversation: one that waits for more would slow it down by itself.
    let _ = client.set_nodelay(true);
    match destination {
        Destination::Socket(path) => drop(UnixStream::connect(path).map(|server| carry(client, server, sky, cuts))),
        Destination::Port(port) => drop(TcpStream::connect(("127.0.0.1", *port)).map(|server| {
            let _ = server.set_nodelay(true);
            carry(client, server, sky, cuts);
        })),
    }
}

/// Carries bytes both ways until one side ends or the connection is cut.
fn carry<S: Stream + 'static>(client: TcpStream, server: S, sky: &Arc<Sky>, cuts: u64) {
    let (Ok(from), Ok(to), Ok(watched)) = (server.twin(), client.twin(), client.twin()) else { return };
    let (there, back) = (Arc::clone(sky), Arc::clone(sky));
    let ended = Arc::new(AtomicU64::new(0));
    let (first, second) = (Arc::clone(&ended), Arc::clone(&ended));
    let server_side = server.twin();
    thread::spawn(move || {
        pump(from, to, &back, cuts);
        first.fetch_add(1, SeqCst);
    });
    thread::spawn(move || {
        pump(client, server, &there, cuts);
        second.fetch_add(1, SeqCst);
    });
    // Whoever only waits to read is told of a cut, too.
    while ended.load(SeqCst) == 0 && sky.cuts.load(SeqCst) == cuts {
        thread::sleep(LOOK_EVERY);
    }
    watched.end();
    if let Ok(server) = server_side {
        server.end();
    }
}

fn pump(mut from: impl Stream, mut to: impl Stream, sky: &Sky, cuts: u64) {
    let mut piece = [0; 16_384];
    while let Ok(read @ 1..) = from.read(&mut piece) {
        if !sky.lets_pass(cuts) || to.write_all(&piece[..read]).is_err() {
            break;
        }
    }
    from.end();
    to.end();
}
