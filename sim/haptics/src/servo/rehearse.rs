//! An attempt of a virtual operator with the limits of a real device, without the device: whether its motors bear the exercise.

use std::sync::atomic::Ordering;

use law::operator::Operator;

use super::{Engine, Setup, StartError, TickMoment};
use crate::device::Device;
use crate::devices::operator::OperatorDevice;
use crate::mapping::Mapping;
use crate::safety::flags;

/// How long the thermal budget reduced the force in a rehearsed attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rehearsal {
    /// Length of the attempt, in s.
    pub duration_s: f64,
    /// Time with a reduced force, in s.
    pub cooled_s: f64,
}

/// Lets an operator make an attempt of at most `limit_s` seconds.
///
/// # Errors
/// As [`Engine::new`].
pub fn rehearse(setup: Setup, operator: Operator, limit_s: f64) -> Result<Rehearsal, StartError> {
    let rate_hz = setup.rate_hz;
    let (mut engine, mut records, _latest) = Engine::new(Setup { mapping: Mapping::in_patient_frame(), ..setup })?;
    let mut device = OperatorDevice::new("rehearsal", operator, rate_hz);
    let done = device.done();
    let (mut ticks, mut cooled) = (0_u32, 0_u32);
    while !done.load(Ordering::Relaxed) && f64::from(ticks) < limit_s * rate_hz {
        let now_s = f64::from(ticks) / rate_hz;
        let moment = TickMoment { now_s, late_s: 0.0 };
        let Some(force_n) = engine.tick(device.read(), &moment, &|| now_s) else { break };
        engine.wrote(device.write(&force_n));
        let records = std::iter::from_fn(|| records.pop());
        cooled += u32::from(records.fold(0, |all, record| all | record.flags) & flags::THERMAL != 0);
        ticks += 1;
    }
    Ok(Rehearsal { duration_s: f64::from(ticks) / rate_hz, cooled_s: f64::from(cooled) / rate_hz })
}
