//! What the devices and the servo promise, shown from outside.

#[cfg(test)]
mod inverse3;
#[cfg(test)]
mod inverse3_faults;
#[cfg(test)]
mod openhaptics;
