//! Connections: limits on their number, in total and per address, and on their idle time.
//!
//! A client that opens a hundred connections and sends half a request head on each must not lock
//! out the others. An idle connection is closed, one whose client reads nothing is reset by the
//! system, and no address may have more connections than a school behind one router needs.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use rustix::net::sockopt;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tower::{Service, ServiceExt};

/// Limits on connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConnectionLimits {
    /// Maximum number of connections.
    pub whole: usize,
    /// Maximum number of connections from one address.
    pub by_address: usize,
    /// Maximum time until the head of a request has arrived, including the wait for the next
    /// request.
    pub head: Duration,
    /// Maximum time for which sent bytes may remain unacknowledged.
    pub unread: Duration,
    /// Time for which requests may continue after the service was asked to stop.
    pub last_orders: Duration,
}

/// Maximum number of connections, if the limit on open files allows it.
const MOST: usize = 1024;
/// Open files other than connections: the database, the log, and recordings being read and written.
const OTHER_FILES: u64 = 64;
/// A class of forty, each browser with six connections, behind one router.
const BY_ADDRESS: usize = 256;

impl ConnectionLimits {
    /// Returns the limits for this process: two files per connection, after raising the limit on
    /// open files to its maximum. Behind a proxy all connections come from one address, so limits
    /// per client are left to the proxy.
    #[must_use]
    pub fn of_process(behind_proxy: bool) -> Self {
        let Rlimit { maximum, current } = getrlimit(Resource::Nofile);
        // If this fails, the current limit applies.
        let raised = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum }).is_ok();
        let files = if raised { maximum } else { current }.unwrap_or(u64::MAX);
        let room = files.saturating_sub(OTHER_FILES) / 2;
        let whole = room.clamp(8, MOST as u64) as usize;
        Self {
            whole,
            by_address: if behind_proxy { whole } else { BY_ADDRESS.min(whole / 4) },
            head: Duration::from_secs(15),
            unread: Duration::from_secs(30),
            last_orders: Duration::from_secs(10),
        }
    }
}

/// Number of connections by address.
#[derive(Clone, Debug, Default)]
struct Guests(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

/// A connection that is counted until it is dropped.
struct Guest {
    guests: Guests,
    address: IpAddr,
    _place: OwnedSemaphorePermit,
}

impl Guests {
    /// Counts a connection; returns `None` if its address has reached the limit.
    fn admit(&self, address: IpAddr, most: usize, place: OwnedSemaphorePermit) -> Option<Guest> {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let count = counts.entry(address).or_default();
        if *count >= most {
            return None;
        }
        *count += 1;
        Some(Guest { guests: self.clone(), address, _place: place })
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        let mut counts = self.guests.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = counts.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                counts.remove(&self.address);
            }
        }
    }
}

/// Serves until `stop` completes, and then lets open requests finish within
/// [`ConnectionLimits::last_orders`].
pub async fn serve_connections(
    listener: TcpListener,
    app: Router,
    limits: ConnectionLimits,
    stop: impl Future<Output = ()>,
) {
    let (places, guests) = (Arc::new(Semaphore::new(limits.whole)), Guests::default());
    let graceful = GracefulShutdown::new();
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(limits.head);
    let mut services = app.into_make_service_with_connect_info::<SocketAddr>();
    let mut stop = std::pin::pin!(stop);
    loop {
        let arrived = tokio::select! {
            arrived = count_arrival(&listener, &places) => arrived,
            () = &mut stop => break,
        };
        let Some((stream, address, place)) = arrived else { continue };
        let Some(guest) = guests.admit(address.ip(), limits.by_address, place) else { continue };
        // Both are optional: a connection is served without them, too.
        let _ = (stream.set_nodelay(true), sockopt::set_tcp_user_timeout(&stream, as_millis(limits.unread)));
        let Ok(service) = Service::<SocketAddr>::call(&mut services, address).await;
        let service = service.map_request(|request: Request<_>| request.map(Body::new));
        let connection = builder.serve_connection(TokioIo::new(stream), TowerToHyperService::new(service));
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            let _guest = guest;
            // An error here means that the client is gone.
            let _ended = connection.await;
        });
    }
    drop(listener);
    // Connections that are still open after that are dropped.
    let _done = tokio::time::timeout(limits.last_orders, graceful.shutdown()).await;
}

/// Waits for a free slot, then accepts the next connection.
async fn count_arrival(
    listener: &TcpListener,
    places: &Arc<Semaphore>,
) -> Option<(TcpStream, SocketAddr, OwnedSemaphorePermit)> {
    let place = Arc::clone(places).acquire_owned().await.ok()?;
    match listener.accept().await {
        Ok((stream, address)) => Some((stream, address, place)),
        Err(error) => {
            tracing::warn!(cause = %error, "failed to accept a connection");
            // Out of file descriptors, accept fails at once each time: do not spin.
            tokio::time::sleep(Duration::from_millis(100)).await;
            None
        }
    }
}

fn as_millis(time: Duration) -> u32 {
    time.as_millis().min(u128::from(u32::MAX)) as u32
}

#[cfg(test)]
mod tests {
    //! Half a head on every connection is the cheapest way to lock out all others.

    use axum::routing::get;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::TcpSocket;

    use super::*;

    const LIMITS: ConnectionLimits = ConnectionLimits {
        whole: 40,
        by_address: 10,
        head: Duration::from_millis(700),
        unread: Duration::from_secs(1),
        last_orders: Duration::from_secs(1),
    };

    async fn service() -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let app = Router::new().route("/", get(async || "here"));
        tokio::spawn(serve_connections(listener, app, LIMITS, std::future::pending()));
        address
    }

    /// Connects from one of this machine's loopback addresses.
    async fn from(last: u8, to: SocketAddr) -> TcpStream {
        let socket = TcpSocket::new_v4().unwrap();
        socket.bind(SocketAddr::from(([127, 0, 0, last], 0))).unwrap();
        socket.connect(to).await.unwrap()
    }

    /// Returns the response until the connection is closed; empty if it is refused.
    async fn ask(mut stream: TcpStream, request: &str) -> String {
        let mut answer = String::new();
        // A refused connection is closed, or reset if the request was already sent.
        let _ = stream.write_all(request.as_bytes()).await;
        let _ = stream.read_to_string(&mut answer).await;
        answer
    }

    const WHOLE: &str = "GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

    #[tokio::test]
    async fn one_address_takes_no_place_from_the_others() {
        let to = service().await;
        let mut held = Vec::new();
        for _ in 0..30 {
            let mut stream = from(1, to).await;
            let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost:").await;
            held.push(stream);
        }
        assert!(ask(from(2, to).await, WHOLE).await.ends_with("here"));
        assert_eq!(ask(from(1, to).await, WHOLE).await, "", "that address has all it may have");
    }

    #[tokio::test]
    async fn who_says_nothing_more_is_closed_and_gives_its_place_back() {
        let to = service().await;
        let mut held = Vec::new();
        for last in 1..=4 {
            for half in ["GET / HTTP/1.1\r\nHost:", "", WHOLE, "GET / HTTP/1.1\r\nHost: x\r\n\r\n"] {
                let mut stream = from(last, to).await;
                stream.write_all(half.as_bytes()).await.unwrap();
                held.push(stream);
            }
        }
        for mut stream in held {
            let mut answer = Vec::new();
            let read = stream.read_to_end(&mut answer);
            let ended = tokio::time::timeout(Duration::from_secs(20), read).await;
            assert!(ended.is_ok(), "a connection was kept that said {:?}", String::from_utf8_lossy(&answer));
        }
        for _ in 0..LIMITS.by_address {
            assert!(ask(from(1, to).await, WHOLE).await.ends_with("here"));
        }
    }
}
