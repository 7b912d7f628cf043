//! What the devices and the servo promise, shown from outside.

#[cfg(test)]
mod encoder;
#[cfg(test)]
mod exits;
#[cfg(test)]
mod free_handle;
#[cfg(test)]
mod inverse3;
#[cfg(test)]
mod inverse3_faults;
#[cfg(test)]
mod openhaptics;
#[cfg(test)]
mod passivity;
#[cfg(test)]
mod safety;
#[cfg(test)]
mod servo;
#[cfg(test)]
mod support;
#[cfg(test)]
mod test_wall;
#[cfg(test)]
mod throws;
#[cfg(test)]
mod vendors;
