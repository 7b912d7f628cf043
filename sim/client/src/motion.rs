//! Sources of motion for the simulation: one read from a file, and one that shows how far another has come.

use std::path::Path;

use attempt::simulate::{Clock, MotionSource};
use law::operator::{Motion, Plan, needle_pose};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::exit::Failure;
use crate::progress::Progress;
use crate::trajectory::{self, TrajectoryTable};

/// How many ticks pass between two looks at the progress bar.
const TICKS_PER_UPDATE: u64 = 1000;
/// How far a quaternion's length may be from 1: rounding in a file, but not a mistake.
const QUATERNION_TOLERANCE: f64 = 1e-3;

/// Poses at times, played back with linear interpolation of the position and shortest-arc interpolation of the
/// orientation. The first row is the first tick.
pub struct Playback {
    rows: Vec<(f64, Isometry3<f64>)>,
    next: usize,
    elapsed_s: f64,
}

impl Playback {
    /// Reads `t_s,x_m` along the planned axis, or `t_s,px_m,py_m,pz_m` with optional `qx,qy,qz,qw` in the patient frame.
    ///
    /// # Errors
    /// When the file is no such table.
    pub fn read(path: &Path, plan: &Plan) -> Result<Self, Failure> {
        let table = TrajectoryTable::read(path)?;
        let rows = match (table.column("x_m")?, table.column("px_m")?) {
            (Some(_), _) => along_axis(path, plan)?,
            (None, Some(_)) => poses(&table, plan)?,
            (None, None) => {
                return Err(
                    table.wrong_header("needs the column x_m, or px_m, py_m and pz_m (optionally qx, qy, qz, qw)")
                );
            }
        };
        Ok(Self { rows, next: 0, elapsed_s: 0.0 })
    }

    /// Length of the motion, in s.
    pub fn duration_s(&self) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some((first_s, _)), Some((last_s, _))) => last_s - first_s,
            _ => 0.0,
        }
    }

    /// The pose at a time after the first row, in s. Times must not decrease between calls.
    fn pose(&mut self, elapsed_s: f64) -> Isometry3<f64> {
        let t_s = self.rows[0].0 + elapsed_s;
        while self.next + 1 < self.rows.len() && self.rows[self.next].0 < t_s {
            self.next += 1;
        }
        let (after_s, after) = self.rows[self.next];
        let (before_s, before) = self.rows[self.next.saturating_sub(1)];
        if t_s >= after_s || before_s >= after_s {
            return after;
        }
        let share = ((t_s - before_s) / (after_s - before_s)).clamp(0.0, 1.0);
        let position = before.translation.vector.lerp(&after.translation.vector, share);
        Isometry3::from_parts(position.into(), nlerp(&before.rotation, &after.rotation, share))
    }
}

impl MotionSource for Playback {
    fn step(&mut self, dt_s: f64, _force_n: &Vector3<f64>) -> Motion {
        self.elapsed_s += dt_s;
        let patient_from_needle = self.pose(self.elapsed_s);
        // Half a tick of slack: the sum of many ticks is not exactly the last row's time.
        let done = self.elapsed_s + 0.5 * dt_s >= self.duration_s();
        Motion { patient_from_needle, confirm: false, done }
    }
}

/// Normalised linear interpolation along the shorter arc. Only products and sums, so the same bits on every platform.
fn nlerp(before: &UnitQuaternion<f64>, after: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    let after = if before.coords.dot(&after.coords) < 0.0 { -after.into_inner() } else { after.into_inner() };
    UnitQuaternion::new_normalize(before.into_inner().lerp(&after, share))
}

fn along_axis(path: &Path, plan: &Plan) -> Result<Vec<(f64, Isometry3<f64>)>, Failure> {
    let pose = |x_m: f64| needle_pose(&(plan.entry_m + plan.axis * x_m), &plan.axis);
    Ok(trajectory::read_axial(path)?.iter().map(|sample| (sample.t_s, pose(sample.x_m))).collect())
}

fn poses(table: &TrajectoryTable, plan: &Plan) -> Result<Vec<(f64, Isometry3<f64>)>, Failure> {
    let positions = table.numbers(table.columns(["px_m", "py_m", "pz_m"])?)?;
    let orientations = match table.column("qx")? {
        Some(_) => quaternions(table)?,
        None => vec![needle_pose(&plan.entry_m, &plan.axis).rotation; positions.len()],
    };
    Ok(positions
        .into_iter()
        .zip(orientations)
        .map(|((t_s, [x, y, z]), rotation)| (t_s, Isometry3::from_parts(Translation3::new(x, y, z), rotation)))
        .collect())
}

fn quaternions(table: &TrajectoryTable) -> Result<Vec<UnitQuaternion<f64>>, Failure> {
    let rows = table.numbers(table.columns(["qx", "qy", "qz", "qw"])?)?;
    rows.into_iter()
        .enumerate()
        .map(|(index, (_, [x, y, z, w]))| {
            let quaternion = Quaternion::new(w, x, y, z);
            let length = quaternion.norm();
            if (length - 1.0).abs() > QUATERNION_TOLERANCE {
                let why = format_args!("qx,qy,qz,qw has length {length}; 1 ± {QUATERNION_TOLERANCE} is allowed");
                return Err(table.wrong(table.line(index), why));
            }
            Ok(UnitQuaternion::new_normalize(quaternion))
        })
        .collect()
}

/// A source of motion that moves a progress bar.
pub struct WatchedSource {
    source: Box<dyn MotionSource>,
    progress: Progress,
    ticks: u64,
}

impl WatchedSource {
    /// Watches a source that may take as long as the clock allows.
    pub fn new(source: Box<dyn MotionSource>, clock: &Clock) -> Self {
        let most = (clock.time_limit_s * clock.tick_hz) as u64;
        Self { source, progress: Progress::new(most, "simulating"), ticks: 0 }
    }
}

impl MotionSource for WatchedSource {
    fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion {
        self.ticks += 1;
        if self.ticks.is_multiple_of(TICKS_PER_UPDATE) {
            self.progress.set(self.ticks);
        }
        self.source.step(dt_s, force_n)
    }
}
