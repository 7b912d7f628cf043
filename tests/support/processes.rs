//! What the programs share that start others: ports, and what a command has printed.

use std::net::TcpListener;
use std::process::Output;

use anyhow::{Context, ensure};

/// A port that was free a moment ago: the service asks for it again after each death. It lies below those that systems give to whoever
/// connects: while nobody listens, one of the many who ask for the service would sooner or later be given the service's own port, and
/// keep it.
///
/// # Errors
/// When none is free.
pub fn free_port() -> anyhow::Result<u16> {
    free_ports(1)?.pop().context("one was asked for")
}

/// So many different ports, as [`free_port`] has them.
///
/// # Errors
/// When there are fewer.
pub fn free_ports(count: usize) -> anyhow::Result<Vec<u16>> {
    let below = (10_000..30_000).rev();
    let free: Vec<u16> = below.filter(|port| TcpListener::bind(("127.0.0.1", *port)).is_ok()).take(count).collect();
    ensure!(free.len() == count, "{} ports from 10000 to 29999 are free, and {count} are needed", free.len());
    Ok(free)
}

/// What a command printed that must succeed.
///
/// # Errors
/// When it failed; they hold all that it said.
pub fn said(output: &Output) -> anyhow::Result<String> {
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    ensure!(output.status.success(), "{}: {out}{err}", output.status);
    Ok(out)
}
