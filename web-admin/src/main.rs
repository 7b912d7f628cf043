//! The program `web-admin`.

fn main() {}
