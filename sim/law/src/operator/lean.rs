//! The line along which a hand aims: off the planned one by an error, which decreases with each
//! redirection.

use nalgebra::Vector3;

use super::gauss::Draw;
use super::occasion::Traits;

/// Inclination of a needle, and the lines between which it is turned. All of unit length, in the
/// patient frame.
#[derive(Clone, Debug)]
pub(super) struct Lean {
    planned: Vector3<f64>,
    from: Vector3<f64>,
    to: Vector3<f64>,
    /// The current axis.
    pub axis: Vector3<f64>,
}

impl Lean {
    /// An axis off the planned line by a random angle of the given standard deviation, in a random
    /// direction.
    pub fn new(planned: &Vector3<f64>, sd_rad: f64, traits: &mut Traits) -> Self {
        let axis = tilt_randomly(planned, sd_rad, || traits.z());
        Self { planned: *planned, from: axis, to: axis, axis }
    }

    /// The planned axis.
    pub fn planned(&self) -> &Vector3<f64> {
        &self.planned
    }

    /// Chooses another line: removes the fraction `correction` of the error, and adds a new one of
    /// the given standard deviation.
    pub fn choose(&mut self, correction: f64, sd_rad: f64, draw: &mut Draw) {
        let nearer = (self.axis + (self.planned - self.axis) * correction).normalize();
        self.from = self.axis;
        self.to = tilt_randomly(&nearer, sd_rad, || draw.normal(1.0));
    }

    /// Sets the axis after a fraction of the turn.
    pub fn turn(&mut self, share: f64) {
        self.axis = (self.from + (self.to - self.from) * share).normalize();
    }
}

/// Tilts an axis by a random angle of the given standard deviation, in a random direction. `z`
/// draws with mean 0 and deviation 1.
fn tilt_randomly(axis: &Vector3<f64>, sd_rad: f64, mut z: impl FnMut() -> f64) -> Vector3<f64> {
    let aside = if axis.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
    let u = axis.cross(&aside).normalize();
    let w = axis.cross(&u);
    let part_sd = sd_rad * core::f64::consts::FRAC_1_SQRT_2;
    (axis + u * (part_sd * z()) + w * (part_sd * z())).normalize()
}

#[cfg(test)]
mod tests {
    //! Fails if a redirecting hand does not approach the planned line on average, or a more skilled
    //! one does not approach it more closely.

    use super::super::{Occasion, Skill};
    use super::*;

    /// Mean angle to the planned line before and after a redirection, in degrees.
    fn errors_deg(skill: &Skill) -> [f64; 2] {
        const PEOPLE: u64 = 500;
        let planned = Vector3::new(0.0, 0.2, -1.0).normalize();
        let mut sums = [0.0; 2];
        for person in 0..PEOPLE {
            let mut traits = Traits::new(&Occasion::once(person));
            let mut lean = Lean::new(&planned, skill.angle_sd_rad, &mut traits);
            sums[0] += lean.axis.angle(&planned).to_degrees();
            lean.choose(skill.correction, skill.redirect_sd_rad(), &mut traits.into_chance());
            lean.turn(1.0);
            sums[1] += lean.axis.angle(&planned).to_degrees();
        }
        sums.map(|sum| sum / PEOPLE as f64)
    }

    #[test]
    fn who_redirects_comes_nearer_and_an_expert_most_of_all() {
        let [novice, expert] = [Skill::novice(), Skill::expert()].map(|skill| errors_deg(&skill));
        let left = |[before, after]: [f64; 2]| after / before;
        assert!(left(novice) < 0.95, "{novice:?}");
        assert!(left(expert) < 0.5 * left(novice), "{expert:?} against {novice:?}");
    }
}
