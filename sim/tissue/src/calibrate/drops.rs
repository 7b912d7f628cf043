//! The drops of a curve: where its force falls at once, a boundary has given way.

use super::curve::Curve;

/// A fall must be this many standard deviations of the noise to be a drop (choice).
const NOISE_FACTOR: f64 = 6.0;
/// A fall must be this part of the curve's peak to be a drop (choice).
const PEAK_PART: f64 = 0.02;
/// A force goes on along a line if it is within this many deviations of the noise: the line itself is only known to two.
const LINE_FACTOR: f64 = 4.5;

/// The advancing part of a curve, which is where boundaries can give way.
pub(super) struct Front {
    pub depth_m: Vec<f64>,
    pub force_n: Vec<f64>,
    /// Noise of the whole curve, in N.
    noise_n: f64,
}

/// A fall of the force between two neighbouring samples of the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drop {
    /// The sample of the front before it; the boundary gave way between it and the next.
    pub gap: usize,
    /// How far the force falls altogether, in N.
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

    /// The middle of a gap, in m: no sample tells where in the gap a boundary gave way.
    pub fn middle_m(&self, gap: usize) -> f64 {
        0.5 * (self.depth_m[gap] + self.depth_m[gap + 1])
    }

    /// How wide a gap is, in m.
    pub fn width_m(&self, gap: usize) -> f64 {
        self.depth_m[gap + 1] - self.depth_m[gap]
    }

    /// How many gaps there are.
    pub fn gaps(&self) -> usize {
        self.depth_m.len().saturating_sub(1)
    }

    /// The gap whose middle is nearest to a depth.
    pub fn nearest_gap(&self, depth_m: f64) -> usize {
        let after = self.depth_m.partition_point(|&x| x <= depth_m);
        after.saturating_sub(1).min(self.gaps().saturating_sub(1))
    }

    /// The least fall that counts as a drop, in N.
    pub fn least_fall_n(&self) -> f64 {
        let peak_n = self.force_n.iter().copied().fold(0.0, f64::max);
        (NOISE_FACTOR * self.noise_n).max(PEAK_PART * peak_n)
    }

    /// Every drop, in order of depth.
    pub fn drops(&self) -> Vec<Drop> {
        let least_n = self.least_fall_n();
        let falls = self.falls(least_n);
        falls.into_iter().flat_map(|(top, bottom)| self.split(top, bottom, least_n)).collect()
    }

    /// Whether a drop may be one side of a lone sample that is off: behind it the force goes on as before. Friction and cutting
    /// that come back within a gap look the same.
    pub fn is_lone(&self, drop: &Drop) -> bool {
        self.goes_on(drop.gap) || self.goes_on(drop.gap + 1)
    }

    /// Whether the sample behind this one lies on the line of those before it.
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

    /// Stretches from a top to a bottom whose fall is large enough; a rise of as much ends a stretch.
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

    /// The drops within one fall: runs of steep steps, each a drop if it falls far enough; without one, the steepest step.
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
