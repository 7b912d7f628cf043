//! The driver's own thread: it sends forces to the service and receives its states, so that the
//! servo does neither.
//!
//! The service answers each message with one state, so the client sets the pace: [`PERIOD`] at
//! best, slower with a slow service. There are two watchdogs, because a stalled client may leave
//! its last force applied: a servo that stops writing and a service that stops reporting both mean
//! zero force.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use triple_buffer::{Input, Output};
use tungstenite::{Error, Utf8Bytes};

use super::agreement::Agreement;
use super::code;
use super::command::{KEEP_ALIVE, SetForce};
use super::session::Inverse3Session;
use super::state::StateFrame;
use crate::clock;
use crate::device::{DeviceFault, Reading};
use crate::servo::priority;

/// Shortest time between two messages: half a tick of the servo, so that a force waits for a
/// quarter of a tick on average.
const PERIOD: Duration = Duration::from_micros(500);
/// Shortest pause: a service that floods the connection must not occupy a whole processor.
const BREATH: Duration = Duration::from_micros(50);
/// Silence after which the servo counts as stopped: fifty of its ticks.
const SERVO_SILENT: Duration = Duration::from_millis(50);
/// Time after which an unanswered message is followed by another.
const UNANSWERED: Duration = Duration::from_millis(100);
/// Age of the last state beyond which no force is applied. The servo's own hold comes well before.
const BLIND: Duration = Duration::from_millis(250);
/// Time without a valid state after which the service counts as lost.
const LOST: Duration = Duration::from_secs(1);
/// Maximum number of messages read in a row before the force is sent again.
const BACKLOG: usize = 64;
/// Time that closing waits for the service to acknowledge.
const GOODBYE: Duration = Duration::from_millis(200);

/// State shared by both threads without a lock.
#[derive(Default)]
pub struct Shared {
    /// Asks the driver to close.
    pub closing: AtomicBool,
    /// Why the device was lost: 0 while it is available, [`GONE`], or a code.
    fault: AtomicU32,
    /// Why the device rejects forces, one bit each of [`code`]; 0 when it accepts them.
    pub refusal: AtomicU32,
    /// The service applies a force other than the commanded one.
    pub disagrees: AtomicBool,
    /// States received.
    pub states: AtomicU64,
    /// Messages that could not be parsed.
    pub garbage: AtomicU64,
}

const GONE: u32 = u32::MAX;

impl Shared {
    /// Returns why the device was lost.
    pub fn fault(&self) -> Option<DeviceFault> {
        match self.fault.load(Ordering::Acquire) {
            0 => None,
            GONE => Some(DeviceFault::Gone),
            code => Some(DeviceFault::Reported(code)),
        }
    }

    fn fail(&self, fault: u32) {
        self.fault.store(fault, Ordering::Release);
    }
}

/// Reports the device as lost when the thread ends, however it ends.
struct EndOfThread(Arc<Shared>);

impl Drop for EndOfThread {
    fn drop(&mut self) {
        if self.0.fault().is_none() {
            self.0.fail(GONE);
        }
    }
}

/// The device as the thread sees it.
pub struct Exchange {
    pub session: Inverse3Session,
    pub device_id: String,
    pub command: SetForce,
    pub readings: Input<Reading>,
    pub forces_n: Output<Vector3<f64>>,
    pub reading: Reading,
    pub agreement: Agreement,
    pub shared: Arc<Shared>,
}

/// Times and values of the last messages.
struct LastTimes {
    written: Option<Instant>,
    sent: Option<Instant>,
    heard: Instant,
    answered: bool,
    understood: bool,
    shown_n: Vector3<f64>,
}

impl Exchange {
    /// Runs until asked to close, or until the service is lost.
    pub fn run(mut self) {
        let _end = EndOfThread(Arc::clone(&self.shared));
        // Without the priority, forces are late when the processor is busy; the servo's own
        // priority reports that, with advice.
        let _refused = priority::raise(priority::DRIVER);
        let now = clock::instant();
        let mut times = LastTimes {
            written: None,
            sent: None,
            heard: now,
            answered: true,
            understood: true,
            shown_n: Vector3::zeros(),
        };
        while !self.shared.closing.load(Ordering::Acquire) {
            let start = clock::instant();
            if self.round(&mut times).is_err() {
                return;
            }
            std::thread::sleep(PERIOD.saturating_sub(start.elapsed()).max(BREATH));
        }
        if self.session.send(self.command.text(&Vector3::zeros())).is_ok() {
            self.session.close(GOODBYE);
        }
    }

    /// Sends the force if one is due and receives the service's states.
    fn round(&mut self, times: &mut LastTimes) -> Result<(), Error> {
        let wanted_n = self.wanted_n(times);
        let lets_go = wanted_n == Vector3::zeros() && times.shown_n != wanted_n;
        let overdue = times.sent.is_none_or(|sent| sent.elapsed() > UNANSWERED);
        if times.answered || lets_go || overdue {
            // A service that has not answered yet gets no unchanged force again: only a request for
            // a state.
            let says_nothing = !times.answered && wanted_n == times.shown_n;
            self.session.send(if says_nothing { KEEP_ALIVE } else { self.command.text(&wanted_n) })?;
            self.agreement.told(wanted_n);
            *times = LastTimes { sent: Some(clock::instant()), answered: false, shown_n: wanted_n, ..*times };
        }
        self.listen(times)?;
        match times.heard.elapsed() > LOST {
            true => Err(self.lost(times)),
            false => Ok(()),
        }
    }

    /// Receives messages. A service may send more than requested: only the latest state counts.
    fn listen(&mut self, times: &mut LastTimes) -> Result<(), Error> {
        let mut text = self.session.receive()?;
        for _ in 0..BACKLOG {
            let Some(heard) = text else { break };
            times.answered = true;
            self.hear(&heard, times);
            text = self.session.arrived()?;
        }
        Ok(())
    }

    /// The force to apply, in N: the servo's latest, unless one of the watchdogs triggers.
    fn wanted_n(&mut self, times: &mut LastTimes) -> Vector3<f64> {
        if self.forces_n.update() {
            times.written = Some(clock::instant());
        }
        let servo_writes = times.written.is_some_and(|written| written.elapsed() < SERVO_SILENT);
        let sees = times.heard.elapsed() < BLIND;
        if servo_writes && sees { *self.forces_n.output_buffer() } else { Vector3::zeros() }
    }

    fn hear(&mut self, text: &Utf8Bytes, times: &mut LastTimes) {
        let Some(frame) = StateFrame::read(text) else {
            times.understood = false;
            self.shared.garbage.fetch_add(1, Ordering::Relaxed);
            return;
        };
        times.understood = true;
        if let Some(refusal) = frame.arm(&self.device_id).and_then(|arm| arm.refusal()) {
            self.shared.refusal.store(refusal, Ordering::Relaxed);
        }
        if let Some(reported_n) = frame.reported_n(&self.device_id) {
            let disagrees = self.agreement.disagrees(&reported_n, clock::now_s());
            self.shared.disagrees.store(disagrees, Ordering::Relaxed);
        }
        if let Some(reading) = frame.reading(&self.device_id, clock::now_s(), &self.reading) {
            self.reading = reading;
            self.readings.write(reading);
            times.heard = clock::instant();
            self.shared.states.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Records why no valid state came for [`LOST`].
    fn lost(&self, times: &LastTimes) -> Error {
        if !times.understood {
            self.shared.fail(code::NOT_UNDERSTOOD);
        }
        Error::ConnectionClosed
    }
}
