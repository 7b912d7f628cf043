//! What the mechanics promise, shown from outside.

mod cells;
mod reference;
mod ruptures;
mod scenes;
