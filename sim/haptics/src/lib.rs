//! Haptic devices behind one trait, the servo loop that reads and drives them, and the safety chain between force law and motors.

mod clock;
pub mod device;
pub mod openhaptics;
