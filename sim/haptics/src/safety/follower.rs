//! The motion behind an encoder's steps.
//!
//! An encoder of 55 µm says of a handle at 0.5 mm/s nothing for 110 ticks and then that it made 55 mm/s for one. Whoever takes that
//! for motion damps a hundred times too hard in one tick and not at all in the others. So the way from one reading to the next is
//! spread over as many ticks as passed between the two. The whole way is never wrong by more than the last step, a handle that says
//! something new in every tick is followed without delay, and neither the encoder's step nor the rate of the readings need be known.
//! A time between readings counts as no more than twice the one before, and a tick: who starts after a rest did not creep till then.

use nalgebra::Vector3;

/// How much a tick weighs in the mean of squares.
const WEIGHT: f64 = 1.0 / 8.0;
/// Times between readings that are remembered: of a handle that is read after one tick, then after two, the even motion is sought.
const REMEMBERED: usize = 4;

/// Follows a handle from reading to reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Follower {
    /// Where the handle was said to be last, and where it is followed to by now, in m.
    said_m: Option<Vector3<f64>>,
    at_m: Vector3<f64>,
    /// Ticks since what is said changed, and those of the changes before, the latest first.
    age: u32,
    ages: [u32; REMEMBERED],
    /// Mean square of the latest ways, in m².
    square_m2: f64,
    /// Ticks that are left of those over which the last change is spread.
    left: u32,
}

/// What a handle does in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// Its way, in m.
    pub way_m: Vector3<f64>,
    /// Mean square of the latest ways, in m².
    pub square_m2: f64,
    /// Ticks from one reading to the next, at least 1.
    pub ticks: u32,
}

impl Follower {
    /// A tick's motion, from where the handle is now said to be, in m.
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

    /// The longest of the times between readings, in ticks.
    fn spread(&self) -> u32 {
        self.ages.into_iter().fold(1, u32::max)
    }
}

#[cfg(test)]
mod tests {
    //! It would be of no use if it lost way, lagged behind a device that says something new in each tick, or let a step through.

    use super::*;

    /// The ways along x, in m, of a handle that is said to be at each of some places.
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
