//! What the mechanics promise, shown from outside.

#[cfg(test)]
mod cells;
#[cfg(test)]
mod operators;
#[cfg(test)]
mod puncture;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod ruptures;
#[cfg(test)]
mod scenes;
