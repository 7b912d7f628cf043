//! The thermal budget: what the force has heated the motors by stays within what they bear for ever.
//!
//! A motor warms and cools like a body of one time constant τ: dh/dt = (F² − h)/τ, with h in N² and the force that can be held for ever
//! at h = F². When h, or the temperature that the device itself reports, comes near the limit, the largest force goes down, to nothing
//! at the limit, so that the limit is never exceeded.

use nalgebra::Vector3;

/// Time constant of a motor, in s (choice): between that of the winding of a small motor, some ten seconds, and that of its housing, some
/// ten minutes.
const TIME_CONSTANT_S: f64 = 120.0;
/// Part of the limit at which the largest force begins to go down.
const WARM: f64 = 0.8;

/// Thermal limits of the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalParams {
    /// Tick period, in s.
    pub period_s: f64,
    /// Maximum force, in N.
    pub max_force_n: f64,
    /// Force that can be held for ever, in N. If it is not below the largest there is no limit to keep.
    pub continuous_force_n: f64,
}

/// The heat of the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThermalState {
    /// In N²: the square of the force that would hold it.
    heat_n2: f64,
}

/// The force that the motors bear, in N, and whether it is less than the one wanted. `motor_heat` is the temperature that the device
/// reports, from 0 (cold) to 1 (too hot).
pub fn step(
    params: &ThermalParams,
    state: &mut ThermalState,
    motor_heat: f64,
    wanted_n: &Vector3<f64>,
) -> (Vector3<f64>, bool) {
    let ThermalParams { period_s, max_force_n, continuous_force_n } = *params;
    if continuous_force_n >= max_force_n {
        return (*wanted_n, false);
    }
    // A motor that bears nothing for ever has used up all of it.
    let warmed = if continuous_force_n > 0.0 { state.heat_n2 / (continuous_force_n * continuous_force_n) } else { 1.0 };
    let used = warmed.max(motor_heat);
    let left = if used < 1.0 { ((1.0 - used) / (1.0 - WARM)).min(1.0) } else { 0.0 };
    let (force_n, reduced) = super::clamp::norm(wanted_n, max_force_n * left);
    state.heat_n2 += (force_n.norm_squared() - state.heat_n2) * (period_s / TIME_CONSTANT_S);
    (force_n, reduced)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! A model that cools too soon, or a reduction that comes too late, would cook the motors over minutes and be felt by nobody.

    use super::*;

    const TOUCH: ThermalParams = ThermalParams { period_s: 1e-3, max_force_n: 3.3, continuous_force_n: 0.88 };

    /// Forces sent over `seconds` for a wanted force as a function of time, in N, by motors of a reported temperature.
    fn sent(seconds: u32, motor_heat: f64, wanted_n: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut state = ThermalState::default();
        let ticks = 0..seconds * 1000;
        ticks
            .map(|tick| {
                let wanted_n = Vector3::new(0.0, wanted_n(f64::from(tick) * 1e-3), 0.0);
                step(&TOUCH, &mut state, motor_heat, &wanted_n).0.y
            })
            .collect()
    }

    /// The largest heat of a body of the time constant under the forces, in N².
    fn hottest_n2(sent: &[f64]) -> f64 {
        let warmed = sent.iter().scan(0.0, |heat_n2, force_n| {
            *heat_n2 += (force_n * force_n - *heat_n2) * 1e-3 / TIME_CONSTANT_S;
            Some(*heat_n2)
        });
        warmed.fold(0.0, f64::max)
    }

    #[test]
    fn motors_never_exceed_the_heat_of_their_continuous_force() {
        for (name, sent) in [
            ("all the time", sent(400, 0.0, |_| 3.3)),
            ("late", sent(400, 0.0, |t| if t < 55.0 { 0.0 } else { 3.3 })),
            ("in bursts", sent(400, 0.0, |t| if t % 20.0 < 3.0 { 3.3 } else { 0.1 })),
        ] {
            let share = hottest_n2(&sent) / (0.88 * 0.88);
            assert!(share < 1.0 && share > 0.5, "{name}: {share} of what they bear");
        }
    }

    #[test]
    fn forces_below_the_rating_and_short_pops_are_unchanged() {
        assert!(sent(600, 0.0, |_| 0.75).iter().all(|&f| f == 0.75));
        assert!(sent(6, 0.0, |_| 3.3).iter().all(|&f| f == 3.3), "six seconds of the largest force warm them little");
    }

    #[test]
    fn motors_that_report_heat_get_less_force() {
        assert_eq!(sent(1, 0.79, |_| 3.3)[999], 3.3);
        assert!((sent(1, 0.9, |_| 3.3)[999] - 1.65).abs() < 1e-12, "half of what is left above 0.8");
        assert_eq!(sent(1, 1.0, |_| 3.3)[999], 0.0);
    }

    #[test]
    fn without_a_rating_there_is_no_force() {
        let params = ThermalParams { continuous_force_n: 0.0, ..TOUCH };
        let mut state = ThermalState::default();
        assert_eq!(step(&params, &mut state, 0.0, &Vector3::x()).0, Vector3::zeros());
    }
}
