//! Linear axis scales and round tick values.

/// An interval of values, or of coordinates in the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Start; for values, the smaller end.
    pub from: f64,
    /// End.
    pub to: f64,
}

impl Extent {
    /// Creates an extent from its two ends.
    #[must_use]
    pub const fn new(from: f64, to: f64) -> Self {
        Self { from, to }
    }

    /// Returns the range of some values; infinite and reversed if there are none.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::new(f64::INFINITY, f64::NEG_INFINITY), |found, value| {
            Self::new(found.from.min(value), found.to.max(value))
        })
    }

    /// Returns the signed distance from start to end.
    #[must_use]
    pub fn length(self) -> f64 {
        self.to - self.from
    }
}

/// A linear map from a domain of values to a range of coordinates. An empty or invalid domain is
/// widened, so that there is no division by zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisScale {
    domain: Extent,
    range: Extent,
}

impl AxisScale {
    /// Maps `domain` onto `range`.
    #[must_use]
    pub fn new(domain: Extent, range: Extent) -> Self {
        let Extent { from, to } = domain;
        let usable = from.is_finite() && to.is_finite() && to > from;
        let start = if from.is_finite() { from } else { 0.0 };
        Self { domain: if usable { domain } else { Extent::new(start, start + 1.0) }, range }
    }

    /// Returns the coordinate of a value, clamped to the range. NaN maps to the start.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        let Extent { from, to } = self.domain;
        let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.0 } else { share };
        self.range.from + share * self.range.length()
    }

    /// Returns whether a value is in the domain.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.domain.from..=self.domain.to).contains(&value)
    }

    /// Returns the domain.
    #[must_use]
    pub fn domain(&self) -> Extent {
        self.domain
    }

    /// Returns at most `most` round values inside the domain, spaced by 1, 2 or 5 times a power of
    /// ten.
    #[must_use]
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let Extent { from, to } = self.domain;
        let step = round_step(to - from, most);
        let first = (from / step).ceil();
        let count = ((to / step + 1e-9).floor() - first).max(0.0);
        // The limit keeps an invalid domain from filling the page.
        (0..=100).map(f64::from).take_while(|i| *i <= count).map(|i| (first + i) * step).collect()
    }
}

/// Returns the smallest of 1, 2, 5 × 10ⁿ that needs at most `most` ticks.
fn round_step(span: f64, most: usize) -> f64 {
    let least = span / (most.max(2) - 1) as f64;
    let power = 10_f64.powi(decimal_exponent(least));
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// Returns the exponent of the power of ten at or below a positive number.
fn decimal_exponent(value: f64) -> i32 {
    let digits = libm::log10(value).floor();
    // The exponent of an `f64` always fits; anything else is an invalid domain.
    if digits.is_finite() { digits.clamp(-300.0, 300.0) as i32 } else { 0 }
}

/// Formats a tick's value with as many decimals as its step needs.
#[must_use]
pub fn tick_label(value: f64, ticks: &[f64]) -> String {
    let step = ticks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let decimals = if step.is_finite() && step < 1.0 { decimal_exponent(step).unsigned_abs() as usize } else { 0 };
    // Adding 0.0 turns negative zero, which would read as −0, into zero.
    words::decimal(&format!("{:.decimals$}", value + 0.0))
}

#[cfg(test)]
mod tests {
    //! Ticks must be monotone, round and inside the domain, for invalid input too.
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;

    #[test]
    fn ticks_are_round_rise_and_stay_inside() {
        for (from, to, most) in [(0.0, 31.7, 8), (-0.3, 2.2, 6), (0.0, 0.013, 5), (0.0, 1e6, 10), (7.0, 7.5, 4)] {
            let domain = Extent::new(from, to);
            let ticks = AxisScale::new(domain, Extent::new(0.0, 100.0)).ticks(most);
            assert!((2..=most).contains(&ticks.len()), "{domain:?} gives {ticks:?}");
            assert!(ticks.windows(2).all(|w| w[0] < w[1]));
            assert!(ticks.iter().all(|t| *t >= from - 1e-9 && *t <= to + 1e-9), "{domain:?} gives {ticks:?}");
        }
        assert_eq!(
            AxisScale::new(Extent::new(0.0, 10.0), Extent::new(0.0, 1.0)).ticks(6),
            [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]
        );
    }

    #[test]
    fn places_rise_with_values_and_stay_on_the_paper() {
        let scale = AxisScale::new(Extent::new(2.0, 4.0), Extent::new(300.0, 20.0));
        assert_eq!([scale.at(2.0), scale.at(3.0), scale.at(4.0)], [300.0, 160.0, 20.0]);
        assert_eq!([scale.at(-9.0), scale.at(9.0)], [300.0, 20.0]);
    }

    #[test]
    fn nonsense_gives_numbers() {
        for (from, to) in [(1.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (5.0, -5.0)] {
            let scale = AxisScale::new(Extent::new(from, to), Extent::new(0.0, 100.0));
            assert!(scale.at(f64::NAN).is_finite() && scale.at(3.0).is_finite());
            assert!(!scale.ticks(5).is_empty() && scale.ticks(5).len() <= 5);
        }
    }

    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(tick_label(0.5, &[0.0, 0.5, 1.0]), "0.5");
        assert_eq!(tick_label(20.0, &[0.0, 20.0]), "20");
        assert_eq!(tick_label(-0.02, &[-0.02, 0.0, 0.02]), "−0.02");
        assert_eq!(tick_label(-0.0, &[-1.0, -0.0]), "0");
    }
}
