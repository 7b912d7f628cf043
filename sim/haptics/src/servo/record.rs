//! The records from the servo to the recorder: a ring that drops and counts on overflow, and never
//! blocks the servo.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rtrb::{Consumer, Producer, RingBuffer};

/// Capacity of the ring, in ticks: half a minute at 1 kHz, to bridge a slow disk.
pub const CAPACITY: usize = 1 << 15;

/// One tick: the exact input of the force law, bit for bit, and its results.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Time since the first tick, in s: a whole number of periods. Times increase; a stall is a
    /// gap.
    pub t_s: f64,
    /// Tip position, in m, patient frame.
    pub position_m: [f64; 3],
    /// patient_from_needle as a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Whether the confirm button is down.
    pub confirm: bool,
    /// Total force of the law on the hand, in N, patient frame.
    pub force_n: [f32; 3],
    /// Force sent to the device after scaling and the safety chain, in N, patient frame.
    pub device_n: [f32; 3],
    /// Flags of the safety chain and of [`super::flags`].
    pub flags: u32,
    /// Lateness of the tick, in µs.
    pub lateness_us: f32,
    /// Compute time of the tick, in µs.
    pub compute_us: f32,
}

/// The servo's end of the ring.
pub(super) struct Sender {
    ring: Producer<Record>,
    dropped: Arc<AtomicU64>,
}

impl Sender {
    /// Sends a record; drops and counts it if the ring is full.
    pub fn send(&mut self, record: Record) {
        if self.ring.push(record).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Records dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

/// The recorder's end of the ring.
#[derive(Debug)]
pub struct Records {
    ring: Consumer<Record>,
    dropped: Arc<AtomicU64>,
}

impl Records {
    /// Returns the next record, if one is available.
    pub fn pop(&mut self) -> Option<Record> {
        self.ring.pop().ok()
    }

    /// Records dropped so far because the recorder was too slow.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Whether the servo has ended and all its records have been taken.
    #[must_use]
    pub fn is_over(&self) -> bool {
        // In this order: the servo pushes its last record before it abandons the ring.
        self.ring.is_abandoned() && self.ring.is_empty()
    }
}

/// A ring of [`CAPACITY`] records.
pub(super) fn ring() -> (Sender, Records) {
    let (producer, consumer) = RingBuffer::new(CAPACITY);
    let dropped = Arc::new(AtomicU64::new(0));
    let records = Records { ring: consumer, dropped: Arc::clone(&dropped) };
    (Sender { ring: producer, dropped }, records)
}

#[cfg(test)]
mod tests {
    //! A ring that overwrote or blocked would lose an attempt or stop the servo; one that did not
    //! count drops would hide them.

    use super::*;

    #[test]
    fn a_full_ring_keeps_the_oldest_and_counts_the_rest() {
        let (mut sender, mut records) = ring();
        for tick in 0..CAPACITY + 5 {
            sender.send(Record { t_s: tick as f64, ..Record::default() });
        }
        assert_eq!((sender.dropped(), records.dropped()), (5, 5));
        drop(sender);
        assert!(!records.is_over(), "there is something left to take");
        let taken: Vec<f64> = std::iter::from_fn(|| records.pop()).map(|record| record.t_s).collect();
        assert_eq!(taken, (0..CAPACITY).map(|tick| tick as f64).collect::<Vec<_>>());
        assert!(records.is_over());
    }
}
