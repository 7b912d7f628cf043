//! What the picture promises, shown on whatever adapter this machine has; a software one will do.

#[cfg(test)]
mod golden;
#[cfg(test)]
mod governor;
#[cfg(test)]
mod painter;
#[cfg(test)]
mod refusals;
#[cfg(test)]
mod responds;
#[cfg(test)]
mod specimen;
