//! Speed over a window of time. One tick of an encoder in steps of 55 µm is 55 mm/s, and most ticks
//! bring no new position: a difference over two samples would be noise.

use serde::{Deserialize, Serialize};

/// Maximum number of samples in a window: 50 ms at 10 kHz, 7.5 ms at 68 kHz. At a higher rate the
/// window is shorter.
const MOST_SAMPLES: usize = 512;

/// A displacement of the tip and its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TimedDisplacement {
    pub t_s: f64,
    pub x_m: f64,
}

/// The recent samples, oldest first, in a ring that is allocated once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SpeedWindow {
    samples: Vec<TimedDisplacement>,
    first: usize,
    count: usize,
}

impl SpeedWindow {
    /// An empty window with room for its samples; without room if `window_s`, in s, is 0.
    pub fn new(window_s: f64) -> Self {
        let capacity = if window_s > 0.0 { MOST_SAMPLES } else { 0 };
        Self { samples: vec![TimedDisplacement::default(); capacity], first: 0, count: 0 }
    }

    fn get(&self, age: usize) -> Option<TimedDisplacement> {
        if age >= self.count {
            return None;
        }
        self.samples.get((self.first + age) % self.samples.len()).copied()
    }

    fn forget_oldest(&mut self) {
        self.first = (self.first + 1) % self.samples.len();
        self.count -= 1;
    }

    /// The newest sample at least `window_s` older than `t_s`, otherwise the oldest; `None` before
    /// the first.
    pub fn reference(&self, t_s: f64, window_s: f64) -> Option<TimedDisplacement> {
        let old_enough = (1..self.count).map_while(|age| self.get(age).filter(|sample| t_s - sample.t_s >= window_s));
        old_enough.last().or_else(|| self.get(0))
    }

    /// Stores a sample, and drops those that no later one will be measured from.
    pub fn push(&mut self, sample: TimedDisplacement, window_s: f64) {
        if self.samples.is_empty() {
            return;
        }
        while self.get(1).is_some_and(|next| sample.t_s - next.t_s >= window_s) || self.count == self.samples.len() {
            self.forget_oldest();
        }
        let at = (self.first + self.count) % self.samples.len();
        if let Some(place) = self.samples.get_mut(at) {
            *place = sample;
            self.count += 1;
        }
    }
}
