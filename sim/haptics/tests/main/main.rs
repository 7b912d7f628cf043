//! What the devices and the servo promise, shown from outside.

#[cfg(test)]
mod openhaptics;
