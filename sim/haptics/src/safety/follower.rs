//! Reconstructs smooth motion from an encoder's quantised readings.
//!
//! A handle at 0.5 mm/s on an encoder of 55 µm reads as standing still for 110 ticks and as moving
//! at 55 mm/s for one. A damper that took these readings for motion would damp a hundred times too
//! hard in one tick and not at all in the others. So the displacement between two readings is
//! spread over as many ticks as passed between them. The total displacement is never off by more
//! than the last step, a handle with a new reading in every tick is followed without delay, and
//! neither the encoder's step nor its reading rate need be known. The time between two readings
//! counts as at most twice the previous one plus a tick: a handle that starts after a rest was not
//! creeping until then.

use nalgebra::Vector3;

/// Weight of a tick in the mean of squares.
const WEIGHT: f64 = 1.0 / 8.0;
/// Number of remembered times between readings: bridges a handle that is read alternately after one
/// tick and after two.
const REMEMBERED: usize = 4;

/// Follows a handle from reading to reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Follower {
    /// The last reading of the position, and the position followed so far, in m.
    said_m: Option<Vector3<f64>>,
    at_m: Vector3<f64>,
    /// Ticks since the reading changed, and those between the previous changes, latest first.
    age: u32,
    ages: [u32; REMEMBERED],
    /// Mean square of the latest displacements per tick, in m².
    square_m2: f64,
    /// Ticks left of those over which the last change is spread.
    left: u32,
}

/// Motion of a handle in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// Displacement, in m.
    pub way_m: Vector3<f64>,
    /// Mean square of the latest displacements per tick, in m².
    pub square_m2: f64,
    /// Ticks between readings, at least 1.
    pub ticks: u32,
}

impl Follower {
    /// Returns the motion of a tick, given the position as read now, in m.
    pub fn follow(&mut self, said_m: Vector3<f64>) -> Followed {
        self.age = self.age.saturating_add(1);
        match self.said_m {
            None => self.at_m = said_m,
            Some(before_m) if before_m != said_m => {
                let age = self.age.min(self.ages[0].saturating_mul(2).saturating_add(1));
                self.ages.rotate_right(1);
                self.ages[0] = age;
                self.age = 0;
                self.left = self.spread();
            }
            Some(_) => {}
        }
        self.said_m = Some(said_m);
        let way_m = (said_m - self.at_m) / f64::from(self.left.max(1));
        self.left = self.left.saturating_sub(1);
        self.at_m = if self.left == 0 { said_m } else { self.at_m + way_m };
        self.square_m2 += WEIGHT * (way_m.norm_squared() - self.square_m2);
        Followed { way_m, square_m2: self.square_m2, ticks: self.spread() }
    }

    /// The longest of the remembered times between readings, in ticks.
    fn spread(&self) -> u32 {
        self.ages.into_iter().fold(1, u32::max)
    }
}

#[cfg(test)]
mod tests {
    //! The follower must lose no displacement, add no lag to a device with a new reading in every
    //! tick, and let no step through.

    use super::*;

    /// Displacements along x, in m, for a sequence of position readings.
    fn ways_m(said_m: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut follower = Follower::default();
        said_m.into_iter().map(|x_m| follower.follow(Vector3::new(x_m, 0.0, 0.0)).way_m.x).collect()
    }

    #[test]
    fn what_is_new_in_every_tick_is_taken_as_it_is() {
        let said_m: Vec<f64> = (0..100_i32).map(|tick| 1e-6 * f64::from(tick * tick)).collect();
        let ways_m = ways_m(said_m.iter().copied());
        assert!(said_m.windows(2).zip(&ways_m[1..]).all(|(pair, way_m)| (pair[1] - pair[0] - way_m).abs() < 1e-18));
    }

    #[test]
    fn steps_become_an_even_motion() {
        for (step_m, speed_m_per_tick) in [(55e-6, 0.5e-6), (55e-6, 2e-6), (55e-6, 30e-6), (10e-6, 7e-6)] {
            let said_m = (0..4000_i32).map(|tick| (f64::from(tick) * speed_m_per_tick / step_m).floor() * step_m);
            let ways_m = ways_m(said_m.clone());
            let even = |way_m: &f64| (0.0..2.1).contains(&(way_m / speed_m_per_tick));
            assert!(ways_m[1000..].iter().all(even), "steps of {step_m} m at {speed_m_per_tick} m a tick");
            let behind_m = said_m.fold(0.0, f64::max) - ways_m.iter().sum::<f64>();
            assert!((-1e-12..=step_m + 1e-12).contains(&behind_m), "{behind_m} m of the way were lost");
        }
    }

    #[test]
    fn a_handle_that_stops_has_made_its_whole_way() {
        let said_m = (0..400).map(|tick| if tick < 100 { 0.0 } else { 1e-4 });
        assert!((ways_m(said_m).iter().sum::<f64>() - 1e-4).abs() < 1e-15);
    }
}
