//! A network that carries, cuts, or falls silent.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::thread;
use std::time::Duration;

use tests::dice::Dice;

use crate::Harm;

/// Most bytes that a connection carries before something happens to it.
const FARTHEST: u64 = 2_000_000;
/// How long the service is left with a connection that nobody is at the other end of.
const SILENCE: Duration = Duration::from_secs(35);

/// What becomes of a connection, and after how many bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Carried,
    Cut(u64),
    Silent(u64),
}

impl Fate {
    fn draw(dice: &mut Dice, harm: &Harm) -> Self {
        let after = dice.below(FARTHEST);
        match dice.below(10) {
            _ if harm.is_over() => Self::Carried,
            0..5 => Self::Carried,
            5..8 => Self::Cut(after),
            _ => Self::Silent(after),
        }
    }

    const fn allowance(self) -> u64 {
        match self {
            Self::Carried => u64::MAX,
            Self::Cut(bytes) | Self::Silent(bytes) => bytes,
        }
    }
}

/// A network in front of the service.
#[derive(Debug)]
pub struct Network {
    /// Where it takes connections.
    pub port: u16,
}

impl Network {
    /// Carries connections to a service until the process ends.
    pub fn before(service: u16, seed: u64, harm: Arc<Harm>) -> anyhow::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let port = listener.local_addr()?.port();
        let mut dice = Dice::new(seed.wrapping_add(1000));
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let (fate, harm) = (Fate::draw(&mut dice, &harm), Arc::clone(&harm));
                thread::spawn(move || {
                    // A service that is dead takes no connections: its clients are told so by the end of theirs.
                    if let Ok(server) = TcpStream::connect(("127.0.0.1", service)) {
                        carry(client, server, fate, &harm);
                    }
                });
            }
        });
        Ok(Self { port })
    }
}

/// Carries bytes both ways until the fate of the connection is met, or one side ends it.
fn carry(mut client: TcpStream, mut server: TcpStream, fate: Fate, harm: &Harm) {
    let (Ok(mut from), Ok(mut to)) = (server.try_clone(), client.try_clone()) else { return };
    thread::spawn(move || {
        let _ = std::io::copy(&mut from, &mut to);
        let _ = to.shutdown(Shutdown::Both);
    });
    let (mut piece, mut left) = ([0; 8192], fate.allowance());
    while let Ok(read @ 1..) = client.read(&mut piece) {
        let passed = read.min(usize::try_from(left).unwrap_or(usize::MAX));
        if server.write_all(&piece[..passed]).is_err() {
            break;
        }
        left -= passed as u64;
        if passed < read {
            match fate {
                Fate::Silent(_) => {
                    harm.silences.fetch_add(1, SeqCst);
                    // The client knows at once, the service does not.
                    let _ = client.shutdown(Shutdown::Both);
                    thread::sleep(SILENCE);
                }
                _ => drop(harm.cuts.fetch_add(1, SeqCst)),
            }
            break;
        }
    }
    let _ = server.shutdown(Shutdown::Both);
    let _ = client.shutdown(Shutdown::Both);
}
