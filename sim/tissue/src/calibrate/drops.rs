//! The drops of a curve: a sudden fall of its force is a ruptured boundary.

use super::curve::Curve;

/// Minimum fall of a drop, in standard deviations of the noise (choice).
const NOISE_FACTOR: f64 = 6.0;
/// Minimum fall of a drop, as a fraction of the curve's peak (choice).
const PEAK_PART: f64 = 0.02;
/// A force continues a line if it is within this many deviations of the noise: the line itself is
/// only known to two.
const LINE_FACTOR: f64 = 4.5;

/// The advancing part of a curve, where boundaries can rupture.
pub(super) struct Front {
    pub depth_m: Vec<f64>,
    pub force_n: Vec<f64>,
    /// Noise of the whole curve, in N.
    noise_n: f64,
}

/// A fall of the force between two neighbouring samples of the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drop {
    /// Index of the front's sample before the fall; the boundary ruptured between it and the next.
    pub gap: usize,
    /// Total fall of the force, in N.
    pub fall_n: f64,
}

impl Front {
    pub fn new(curve: &Curve) -> Self {
        let front = curve.front();
        Self {
            depth_m: front.iter().map(|&at| curve.depth_m[at]).collect(),
            force_n: front.iter().map(|&at| curve.force_n[at]).collect(),
            noise_n: curve.noise_n(),
        }
    }

    /// The middle of a gap, in m: the samples do not show where in the gap a boundary ruptured.
    pub fn middle_m(&self, gap: usize) -> f64 {
        0.5 * (self.depth_m[gap] + self.depth_m[gap + 1])
    }

    /// Width of a gap, in m.
    pub fn width_m(&self, gap: usize) -> f64 {
        self.depth_m[gap + 1] - self.depth_m[gap]
    }

    /// Number of gaps.
    pub fn gaps(&self) -> usize {
        self.depth_m.len().saturating_sub(1)
    }

    /// The gap whose middle is nearest to a depth.
    pub fn nearest_gap(&self, depth_m: f64) -> usize {
        let after = self.depth_m.partition_point(|&x| x <= depth_m);
        after.saturating_sub(1).min(self.gaps().saturating_sub(1))
    }

    /// The minimum fall of a drop, in N.
    pub fn least_fall_n(&self) -> f64 {
        let peak_n = self.force_n.iter().copied().fold(0.0, f64::max);
        (NOISE_FACTOR * self.noise_n).max(PEAK_PART * peak_n)
    }

    /// All drops, in order of depth.
    pub fn drops(&self) -> Vec<Drop> {
        let least_n = self.least_fall_n();
        let falls = self.falls(least_n);
        falls.into_iter().flat_map(|(top, bottom)| self.split(top, bottom, least_n)).collect()
    }

    /// Whether a drop may be one side of a single outlier: behind it the force continues as before.
    /// Friction and cutting that recover within a gap look the same.
    pub fn is_lone(&self, drop: &Drop) -> bool {
        self.goes_on(drop.gap) || self.goes_on(drop.gap + 1)
    }

    /// Whether the sample behind this one lies on the line through those before it.
    fn goes_on(&self, lone: usize) -> bool {
        let Some(&[first, second, third, fourth]) =
            lone.checked_sub(4).and_then(|from| self.force_n[from..lone].first_chunk())
        else {
            return false;
        };
        let (mean_n, slope_n) = (0.25 * (first + second + third + fourth), 0.25 * (third + fourth - first - second));
        let line_n = mean_n + 3.5 * slope_n;
        self.force_n.get(lone + 1).is_some_and(|behind| (behind - line_n).abs() <= LINE_FACTOR * self.noise_n)
    }

    /// Stretches from a top to a bottom whose fall is large enough; an equally large rise ends a
    /// stretch.
    fn falls(&self, least_n: f64) -> Vec<(usize, usize)> {
        let force = |at: usize| self.force_n[at];
        let (mut falls, mut top, mut bottom) = (Vec::new(), 0, None);
        for at in 1..self.force_n.len() {
            bottom = match bottom {
                None if force(top) - force(at) >= least_n => Some(at),
                None => {
                    top = if force(at) >= force(top) { at } else { top };
                    None
                }
                Some(low) if force(at) - force(low) >= least_n => {
                    falls.push((top, low));
                    top = at;
                    None
                }
                Some(low) => Some(if force(at) < force(low) { at } else { low }),
            };
        }
        falls.extend(bottom.map(|low| (top, low)));
        falls
    }

    /// The drops within one fall: runs of steep steps, each a drop if it falls far enough;
    /// without such a run, the steepest step.
    fn split(&self, top: usize, bottom: usize, least_n: f64) -> Vec<Drop> {
        let fall_n = |gap: usize| self.force_n[gap] - self.force_n[gap + 1];
        let steepest = |gaps: &[usize]| gaps.iter().copied().max_by(|&a, &b| fall_n(a).total_cmp(&fall_n(b)));
        let steep: Vec<usize> = (top..bottom).filter(|&gap| fall_n(gap) > 0.5 * least_n).collect();
        let drop = |run: &[usize]| {
            let total_n: f64 = run.iter().map(|&gap| fall_n(gap)).sum();
            steepest(run).filter(|_| total_n >= least_n).map(|gap| Drop { gap, fall_n: total_n })
        };
        let found: Vec<Drop> = steep.chunk_by(|a, b| a + 1 == *b).filter_map(drop).collect();
        if !found.is_empty() {
            return found;
        }
        let whole: Vec<usize> = (top..bottom).collect();
        let fall_n = self.force_n[top] - self.force_n[bottom];
        steepest(&whole).map(|gap| Drop { gap, fall_n }).into_iter().collect()
    }
}
