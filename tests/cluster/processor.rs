//! The processor: its name, the time that programs have had of it, and the time that it was taken from this machine.

use std::collections::BTreeMap;
use std::fs;

use anyhow::Context;

/// Units of the system's times in a second, on every Linux that this runs on (`USER_HZ`).
const TICKS: f64 = 100.0;

/// The processor's name, as the system tells it.
pub fn name_processor() -> String {
    let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    name.unwrap_or("an unknown processor").to_owned()
}

/// The time of all threads since the machine began, in ticks: `proc(5)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineTime {
    all: u64,
    /// What whoever runs this machine gave to others while something here wanted it.
    stolen: u64,
}

impl MachineTime {
    /// Until now.
    pub fn look() -> anyhow::Result<Self> {
        let told = fs::read_to_string("/proc/stat")?;
        Self::read(&told).with_context(|| format!("/proc/stat: {told}"))
    }

    fn read(told: &str) -> Option<Self> {
        let fields = told.lines().next()?.strip_prefix("cpu ")?.split_whitespace();
        // What guests of this machine had is in the first of them once more.
        let ticks: Vec<u64> = fields.take(8).map(|field| field.parse().ok()).collect::<Option<_>>()?;
        Some(Self { all: ticks.iter().sum(), stolen: *ticks.get(7)? })
    }

    /// The share that was stolen since then.
    pub fn share_stolen_since(self, before: Self) -> f64 {
        (self.stolen - before.stolen) as f64 / (self.all - before.all).max(1) as f64
    }
}

/// A process that lives.
#[derive(Clone, Copy, Debug)]
struct Living {
    parent: u32,
    /// What it has used, and those of its children that have ended, in s.
    used_s: f64,
}

/// What a process, and all that it has started, have used so far, in s: `proc(5)`.
pub fn sum_processor_time(of: u32) -> anyhow::Result<f64> {
    let mut living = BTreeMap::new();
    for entry in fs::read_dir("/proc")? {
        let Some(id) = entry?.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
        // It may have ended since.
        let Ok(told) = fs::read_to_string(format!("/proc/{id}/stat")) else { continue };
        living.insert(id, read_stat(&told).with_context(|| format!("/proc/{id}/stat: {told}"))?);
    }
    let is_ours = |mut id: u32| {
        while id != of {
            let Some(Living { parent, .. }) = living.get(&id) else { return false };
            id = *parent;
        }
        true
    };
    Ok(living.iter().filter(|(id, _)| is_ours(**id)).map(|(_, living)| living.used_s).sum())
}

fn read_stat(told: &str) -> Option<Living> {
    // The name, in parentheses, may hold anything.
    let fields: Vec<&str> = told.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: Option<Vec<f64>> = fields.get(11..15)?.iter().map(|field| field.parse().ok()).collect();
    Some(Living { parent: fields.get(1)?.parse().ok()?, used_s: ticks?.iter().sum::<f64>() / TICKS })
}

#[cfg(test)]
mod tests {
    //! Fails when a name with spaces and parentheses shifts the fields, or when what a child has used is lost.

    use std::process::{Command, id};

    use super::*;

    #[test]
    fn a_process_is_read_whatever_its_name() {
        let told = "7 (a) (b c) S 3 7 7 0 -1 4194304 1 0 0 0 10 20 30 40 20 0 1 0 5 0 0";
        let found = read_stat(told).unwrap();
        assert_eq!((found.parent, found.used_s), (3, 1.0));
    }

    #[test]
    fn what_was_stolen_is_a_share_of_everything() {
        let [before, now] = ["cpu  10 0 5 80 1 0 0 4 7 0\ncpu0 1", "cpu  60 0 15 110 1 0 0 14 9 0\ncpu0 1"]
            .map(|told| MachineTime::read(told).unwrap());
        assert!((now.share_stolen_since(before) - 0.1).abs() < 1e-12);
        assert_eq!(MachineTime::read("cpu 1 2 3"), None);
    }

    #[test]
    fn what_a_child_has_used_counts() {
        let before = sum_processor_time(id()).unwrap();
        let busy = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done";
        assert!(Command::new("sh").args(["-c", busy]).status().unwrap().success());
        assert!(sum_processor_time(id()).unwrap() > before + 0.05);
    }
}
