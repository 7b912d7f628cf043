//! The picture: a frame of plain data goes in, pixels come out.

pub mod frame;
