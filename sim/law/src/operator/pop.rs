//! Detection of a pop: the axial force falls by more than 0.25 N within 30 ms while the needle
//! advances.

/// Smallest perceptible drop, in N (physics section 6).
const DROP_N: f64 = 0.25;
/// Time window of the drop, in s.
const WINDOW_S: f64 = 0.030;
/// Number of stored samples; taken at least `WINDOW_S / SAMPLES` apart, so that any tick rate fits.
const SAMPLES: usize = 32;

#[derive(Clone, Copy, Debug)]
struct Felt {
    t_s: f64,
    force_n: f64,
    x_m: f64,
}

/// The recent samples that the hand felt.
#[derive(Clone, Debug)]
pub(super) struct PopSense {
    recent: [Option<Felt>; SAMPLES],
    next: usize,
    last_t_s: f64,
}

impl PopSense {
    pub fn new() -> Self {
        Self { recent: [None; SAMPLES], next: 0, last_t_s: f64::NEG_INFINITY }
    }

    /// Returns true in the tick in which a pop is felt. A drop while the needle retracts is caused
    /// by the hand itself: tremor reverses the friction and stops the cutting, by as much as a pop.
    /// So a drop only counts if the tip is farther in than at any stored sample. A pop is felt
    /// once.
    pub fn feel(&mut self, t_s: f64, force_n: f64, x_m: f64) -> bool {
        let recent = || self.recent.iter().flatten().filter(|felt| t_s - felt.t_s <= WINDOW_S);
        if recent().any(|felt| felt.force_n - force_n > DROP_N) && recent().all(|felt| x_m > felt.x_m) {
            *self = Self::new();
            return true;
        }
        if t_s - self.last_t_s >= WINDOW_S / SAMPLES as f64 {
            if let Some(slot) = self.recent.get_mut(self.next) {
                *slot = Some(Felt { t_s, force_n, x_m });
            }
            self.next = (self.next + 1) % SAMPLES;
            self.last_t_s = t_s;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The times at which a pop is felt for a force as a function of time, at 1 kHz, with the
    /// needle advancing or retracting.
    fn felt(force_n: impl Fn(f64) -> f64, speed: f64) -> Vec<f64> {
        let mut sense = PopSense::new();
        (0..1000).map(|tick| f64::from(tick) * 1e-3).filter(|&t| sense.feel(t, force_n(t), speed * t)).collect()
    }

    #[test]
    fn a_quick_drop_is_felt_once_and_a_slow_or_small_one_never() {
        assert_eq!(felt(|t| if t < 0.5 { 1.0 } else { 0.7 }, 0.01), [0.5]);
        assert!(felt(|t| if t < 0.5 { 1.0 } else { 0.76 }, 0.01).is_empty(), "0.24 N is not felt");
        assert!(felt(|t| 5.0 - 8.0 * t, 0.01).is_empty(), "8 N/s is 0.24 N in 30 ms");
    }

    #[test]
    fn a_drop_while_drawing_back_is_not_a_pop() {
        assert!(felt(|t| if t < 0.5 { 1.0 } else { 0.2 }, -0.01).is_empty());
    }
}
