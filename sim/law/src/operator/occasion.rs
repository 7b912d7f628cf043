//! Who performs, on which day, for the how manieth time: what stays with a person, what with a day, and what is new each time.

use super::gauss::Draw;

/// Shares of a trait's variance that stay with the person, that stay for a day, and that are new with every attempt (choice).
/// Attempts of one day so correlate by 0.75 and those of different days by 0.5, where all people have the same skill.
const VARIANCE: [f64; 3] = [0.5, 0.25, 0.25];

/// An attempt as a person's on a day. Equal numbers draw equal traits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occasion {
    /// Draws what the person is like.
    pub person: u64,
    /// Draws what the person is like that day.
    pub day: u64,
    /// Draws what is new with every attempt: its errors, lapses and tremor.
    pub attempt: u64,
}

impl Occasion {
    /// The only attempt of somebody who is seen once: everything is drawn from one seed.
    #[must_use]
    pub fn once(seed: u64) -> Self {
        Self { person: seed, day: seed, attempt: seed }
    }
}

/// The draws of an occasion, trait by trait in a fixed order.
pub(super) struct Traits {
    levels: [Draw; 3],
}

impl Traits {
    pub fn new(occasion: &Occasion) -> Self {
        let Occasion { person, day, attempt } = *occasion;
        let person = scatter_seed(person, 1);
        let day = scatter_seed(person ^ day, 2);
        // One day's attempts differ, and so do the first attempts of two days or two people with the same number.
        Self { levels: [person, day, scatter_seed(day ^ attempt, 3)].map(Draw::new) }
    }

    /// How far a trait is off its mean in this attempt, in standard deviations between attempts of different people.
    pub fn z(&mut self) -> f64 {
        self.levels.iter_mut().zip(VARIANCE).map(|(level, share)| level.normal(libm::sqrt(share))).sum()
    }

    /// What is left to chance in the attempt itself.
    pub fn into_chance(self) -> Draw {
        let [_, _, attempt] = self.levels;
        attempt
    }
}

/// Scatters a seed, so that neighbouring numbers draw unlike traits (the finaliser of `SplitMix64`, Steele et al. 2014).
fn scatter_seed(seed: u64, level: u64) -> u64 {
    let z = seed.wrapping_add(level.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    //! Fails when a person is another one the next day, or the same every day: a trait must correlate by 0.5 between days
    //! and by 0.75 within one.

    use super::*;

    fn trait_of(person: u64, day: u64, attempt: u64) -> f64 {
        Traits::new(&Occasion { person, day, attempt }).z()
    }

    /// Correlation over many people; both sides have mean 0 and variance 1.
    fn correlation(other: impl Fn(u64) -> f64) -> f64 {
        (0..20_000).map(|person| trait_of(person, 0, 0) * other(person)).sum::<f64>() / 20_000.0
    }

    #[test]
    fn a_person_stays_and_a_day_passes() {
        let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 0.03, "{found} for {wanted}");
        near(correlation(|person| trait_of(person, 0, 0)), 1.0);
        near(correlation(|person| trait_of(person, 0, 1)), 0.75);
        near(correlation(|person| trait_of(person, 1, 0)), 0.5);
        near(correlation(|person| trait_of(person + 20_000, 0, 0)), 0.0);
    }
}
