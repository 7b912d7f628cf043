//! Person, day and repetition of an attempt: traits have a part constant for the person, a part
//! constant for the day, and a new part in each attempt.

use super::gauss::Draw;

/// Fractions of a trait's variance that are constant for the person, constant for a day, and new in
/// every attempt (choice). The correlation of attempts is thus 0.75 within a day and 0.5 between
/// days, if all people have the same skill.
const VARIANCE: [f64; 3] = [0.5, 0.25, 0.25];

/// An attempt, identified by person, day and repetition. Equal numbers draw equal traits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occasion {
    /// Seed of the person's traits.
    pub person: u64,
    /// Seed of the person's traits on that day.
    pub day: u64,
    /// Seed of the attempt: its errors, lapses and tremor.
    pub attempt: u64,
}

impl Occasion {
    /// The only attempt of a person: all traits are drawn from one seed.
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
        // Attempts on one day differ, and so do the first attempts of two days or two people with
        // the same number.
        Self { levels: [person, day, scatter_seed(day ^ attempt, 3)].map(Draw::new) }
    }

    /// Deviation of a trait from its mean in this attempt, in standard deviations between attempts
    /// of different people.
    pub fn z(&mut self) -> f64 {
        self.levels.iter_mut().zip(VARIANCE).map(|(level, share)| level.normal(libm::sqrt(share))).sum()
    }

    /// The generator for random draws within the attempt.
    pub fn into_chance(self) -> Draw {
        let [_, _, attempt] = self.levels;
        attempt
    }
}

/// Scatters a seed, so that neighbouring numbers draw unrelated traits (the finaliser of
/// `SplitMix64`, Steele et al. 2014).
fn scatter_seed(seed: u64, level: u64) -> u64 {
    let z = seed.wrapping_add(level.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    //! Fails if a person's traits are new each day, or the same every day: a trait must correlate
    //! by 0.5 between days and by 0.75 within one.

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
