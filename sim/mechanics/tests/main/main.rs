//! What the mechanics promise, shown from outside.

mod cells;
mod puncture;
mod reference;
mod ruptures;
mod scenes;
