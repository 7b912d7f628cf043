//! Quantum noise: a Poisson number for each pixel of each pulse, the same in any order of evaluation.

/// A stream of uniform numbers for a key and a place: Philox 2×32 with ten rounds (Salmon et al., "Parallel random numbers:
/// as easy as 1, 2, 3", SC 2011).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counter {
    key: u32,
    place: u32,
    next: u32,
}

impl Counter {
    /// The stream of a pixel in a pulse of an attempt.
    pub(crate) fn new(seed: u64, pulse: u32, pixel: u32) -> Self {
        let [low, _] = philox([seed as u32, pulse], (seed >> 32) as u32);
        Self { key: low, place: pixel, next: 0 }
    }

    /// Draws a number in (0, 1).
    fn uniform(&mut self) -> f64 {
        let [high, low] = philox([self.place, self.next], self.key);
        self.next += 1;
        let bits = u64::from(high) << 20 ^ u64::from(low);
        ((bits & ((1 << 52) - 1)) as f64 + 0.5) / (1_u64 << 52) as f64
    }
}

fn philox(mut counter: [u32; 2], mut key: u32) -> [u32; 2] {
    for _ in 0..10 {
        let product = u64::from(counter[0]) * 0xD256_D193;
        counter = [(product >> 32) as u32 ^ key ^ counter[1], product as u32];
        key = key.wrapping_add(0x9E37_79B9);
    }
    counter
}

/// Below this mean a Poisson number is drawn by inversion.
const SMALL_MEAN: f64 = 10.0;

/// Draws a Poisson number of a mean ≥ 0.
pub(crate) fn draw_poisson(mean: f64, counter: &mut Counter) -> f64 {
    if mean < SMALL_MEAN { draw_by_inversion(mean, counter) } else { draw_by_rejection(mean, counter) }
}

fn draw_by_inversion(mean: f64, counter: &mut Counter) -> f64 {
    let (wanted, mut count) = (counter.uniform(), 0.0);
    let mut term = libm::exp(-mean);
    let mut sum = term;
    // The terms fall below the resolution of a double before 100 of them for a mean of 10.
    while sum < wanted && count < 100.0 {
        count += 1.0;
        term *= mean / count;
        sum += term;
    }
    count
}

/// Transformed rejection (Hörmann, "The transformed rejection method for generating Poisson random variables", Insurance:
/// Mathematics and Economics 12, 1993, algorithm PTRS).
fn draw_by_rejection(mean: f64, counter: &mut Counter) -> f64 {
    let b = 0.931 + 2.53 * libm::sqrt(mean);
    let a = -0.059 + 0.02483 * b;
    let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
    let steep = 0.9277 - 3.6224 / (b - 2.0);
    loop {
        let u = counter.uniform() - 0.5;
        let v = counter.uniform();
        let margin = 0.5 - u.abs();
        let count = libm::floor((2.0 * a / margin + b) * u + mean + 0.43);
        if margin >= 0.07 && v <= steep {
            return count;
        }
        if count < 0.0 || margin < 0.013 && v > margin {
            continue;
        }
        let left = libm::log(v * inverse_alpha / (a / (margin * margin) + b));
        if left <= count * libm::log(mean) - mean - libm::lgamma(count + 1.0) {
            return count;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_answers() {
        // Random123, file kat_vectors.
        assert_eq!(philox([0, 0], 0), [0xFF1D_AE59, 0x6CD1_0DF2]);
        assert_eq!(philox([u32::MAX; 2], u32::MAX), [0x2C3F_628B, 0xAB4F_D7AD]);
        assert_eq!(philox([0x243F_6A88, 0x85A3_08D3], 0x1319_8A2E), [0xDD7C_E038, 0xF62A_4C12]);
    }

    #[test]
    fn poisson_numbers_have_their_mean_and_variance() {
        for mean in [0.3, 4.0, 9.99, 10.01, 60.0, 2000.0] {
            let count = 60_000;
            let draw = |pixel: u32| draw_poisson(mean, &mut Counter::new(7, 1, pixel));
            let numbers: Vec<f64> = (0..count).map(draw).collect();
            let average = numbers.iter().sum::<f64>() / f64::from(count);
            let variance = numbers.iter().map(|n| (n - average) * (n - average)).sum::<f64>() / f64::from(count);
            // Five standard errors of both.
            let error = 5.0 * (mean / f64::from(count)).sqrt();
            assert!((average - mean).abs() < error, "{mean}: {average}");
            let error = 5.0 * ((2.0 + 1.0 / mean) / f64::from(count)).sqrt();
            assert!((variance / mean - 1.0).abs() < error, "{mean}: {variance}");
        }
    }
}
