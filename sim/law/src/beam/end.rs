//! Functions of the ends of an inserted beam.

/// With x = βs and y = 2x, a beam with free ends under a force V and a moment M at one of them
/// shows there w = (2β/k)(B V − β C M)/A and w' = (2β²/k)(−C V + 2β D M)/A, and at its other end w
/// = (2β/k)(E V + 2β G M)/A, where
///
/// ```text
/// A = sinh²x − sin²x             B = sinh x cosh x − sin x cos x     C = sinh²x + sin²x
/// D = sinh x cosh x + sin x cos x    E = sinh x cos x − cosh x sin x     G = sinh x sin x
/// ```
///
/// (Hetényi, section 13.) All are scaled by one factor, since only their ratios matter.
pub(super) struct End {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
    pub e: f64,
    pub g: f64,
}

/// Largest y for which the series are used: the closed forms cancel, A ~ y⁴/24 being the difference
/// of numbers of size 1.
const SERIES_UP_TO: f64 = 2.0;
/// Number of terms of the series: at y = 2 the seventh of the slowest, A's, is 2⁻²⁸·10⁻¹⁶ of the
/// first.
const TERMS: i32 = 7;

impl End {
    /// Evaluates the functions for y = 2βs, above 0 and finite.
    pub fn new(y: f64) -> Self {
        if y < SERIES_UP_TO { Self::series(y) } else { Self::closed(y) }
    }

    /// A = Σ y⁴ᵐ/(4m)! from m = 1; C, B and D the same of 4m − 2, 4m − 1 and 4m − 3. E and G are
    /// the parts of sinh and cosh of (1 + i)x: E = −Σ 4 (−4)ᵐ x⁴ᵐ⁺³/(4m + 3)!, G = Σ 2 (−4)ᵐ
    /// x⁴ᵐ⁺²/(4m + 2)!, from m = 0.
    fn series(y: f64) -> Self {
        let x = 0.5 * y;
        let (mut end, mut wide, mut narrow, mut sign) =
            (Self { a: 0.0, b: 0.0, c: 0.0, d: 0.0, e: 0.0, g: 0.0 }, 1.0, 1.0, 1.0);
        for term in 0..TERMS {
            let n = f64::from(4 * term);
            let d = wide * y / (n + 1.0);
            let c = d * y / (n + 2.0);
            let b = c * y / (n + 3.0);
            wide = b * y / (n + 4.0);
            let g = narrow * x * x / ((n + 1.0) * (n + 2.0));
            let e = g * x / (n + 3.0);
            narrow = e * x / (n + 4.0);
            end.a += wide;
            end.b += b;
            end.c += c;
            end.d += d;
            end.e -= 4.0 * sign * e;
            end.g += 2.0 * sign * g;
            sign *= -4.0;
        }
        end
    }

    /// The closed forms times exp(−y), so that nothing overflows: the far end of a long needle is
    /// not affected by the hand.
    fn closed(y: f64) -> Self {
        let x = 0.5 * y;
        let p = libm::exp(-x);
        let q = p * p;
        let (cosh_y, sinh_y) = (0.5 * (1.0 + q * q), 0.5 * (1.0 - q * q));
        let (cos_y, sin_y) = (q * libm::cos(y), q * libm::sin(y));
        let (cosh_x, sinh_x) = (0.5 * (p + p * q), 0.5 * (p - p * q));
        let (cos_x, sin_x) = (libm::cos(x), libm::sin(x));
        Self {
            a: 0.5 * (cosh_y + cos_y) - q,
            b: 0.5 * (sinh_y - sin_y),
            c: 0.5 * (cosh_y - cos_y),
            d: 0.5 * (sinh_y + sin_y),
            e: sinh_x * cos_x - cosh_x * sin_x,
            g: sinh_x * sin_x,
        }
    }
}
