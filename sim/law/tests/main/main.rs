//! What the law promises, shown from outside.

#[cfg(test)]
mod allocation;
#[cfg(test)]
mod beam;
#[cfg(test)]
mod cells;
#[cfg(test)]
mod damping;
#[cfg(test)]
mod energy;
#[cfg(test)]
mod hub;
#[cfg(test)]
mod operators;
#[cfg(test)]
mod options;
#[cfg(test)]
mod properties;
#[cfg(test)]
mod puncture;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod ruptures;
#[cfg(test)]
mod skin;
#[cfg(test)]
mod soak;
#[cfg(test)]
mod structures;
#[cfg(test)]
mod structures_hard;
