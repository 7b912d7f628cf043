//! A motion that is known beforehand: read from a file, or given as columns in memory.

use std::path::Path;

use law::operator::{Felt, Motion, Plan, needle_pose};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::simulate::MotionSource;
use crate::trajectory::{self, AxialSample, NumberColumn, TrajectoryError, TrajectoryTable, check_columns};

/// Tolerance of a quaternion's length around 1: allows for rounding in a file, but not for a
/// mistake.
const QUATERNION_TOLERANCE: f64 = 1e-3;

/// Poses at times, played back with linear interpolation of the position and shortest-arc
/// interpolation of the orientation. The first row is the first tick.
pub struct Playback {
    rows: Vec<(f64, Isometry3<f64>)>,
    next: usize,
    elapsed_s: f64,
}

impl Playback {
    /// Reads `t_s,x_m` along the planned axis, or `t_s,px_m,py_m,pz_m` with optional `qx,qy,qz,qw`
    /// in the patient frame.
    ///
    /// # Errors
    /// If the file is no such table.
    pub fn read(path: &Path, plan: &Plan) -> Result<Self, TrajectoryError> {
        let table = TrajectoryTable::read(path)?;
        let rows = match (table.column("x_m")?, table.column("px_m")?) {
            (Some(_), _) => along_axis(&trajectory::read_axial(path)?, plan),
            (None, Some(_)) => poses(&table, plan)?,
            (None, None) => {
                return Err(
                    table.wrong_header("needs the column x_m, or px_m, py_m and pz_m (optionally qx, qy, qz, qw)")
                );
            }
        };
        Ok(Self::new(rows))
    }

    /// Builds the same from columns in memory: times, then either the advance along the planned
    /// axis, or the position's three components and optionally the orientation's four.
    ///
    /// # Errors
    /// If there are not 2, 4 or 8 columns, or one of their numbers is not allowed.
    pub fn of_columns(columns: &[NumberColumn<'_>], plan: &Plan) -> Result<Self, TrajectoryError> {
        check_columns(columns)?;
        let row = |columns: &[NumberColumn<'_>], at: usize| columns.iter().map(|c| c.values[at]).collect::<Vec<_>>();
        let rows = 0..columns.first().map_or(0, |times| times.values.len());
        let rows = rows.map(|at| match *row(columns, at) {
            [t_s, x_m] => Ok((t_s, pose_on_axis(x_m, plan))),
            [t_s, x, y, z] => Ok((t_s, Isometry3::from_parts(Translation3::new(x, y, z), planned_rotation(plan)))),
            [t_s, x, y, z, qx, qy, qz, qw] => {
                let refuse = |why| TrajectoryError::Refused { place: format!("row {at}"), why };
                let rotation = unit_quaternion([qx, qy, qz, qw]).map_err(refuse)?;
                Ok((t_s, Isometry3::from_parts(Translation3::new(x, y, z), rotation)))
            }
            ref row => Err(TrajectoryError::Refused {
                place: "columns".to_owned(),
                why: format!("{}; allowed: 2 (t, x), 4 (t, px, py, pz) or 8 (and qx, qy, qz, qw)", row.len()),
            }),
        });
        Ok(Self::new(rows.collect::<Result<_, _>>()?))
    }

    fn new(rows: Vec<(f64, Isometry3<f64>)>) -> Self {
        Self { rows, next: 0, elapsed_s: 0.0 }
    }

    /// Duration of the motion, in s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some((first_s, _)), Some((last_s, _))) => last_s - first_s,
            _ => 0.0,
        }
    }

    /// Returns the pose at a time after the first row, in s. Times must not decrease between calls.
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
    fn step(&mut self, dt_s: f64, _felt: &Felt) -> Motion {
        self.elapsed_s += dt_s;
        let patient_from_needle = self.pose(self.elapsed_s);
        // Half a tick of slack: the sum of many ticks is not exactly the last row's time.
        let done = self.elapsed_s + 0.5 * dt_s >= self.duration_s();
        Motion { patient_from_needle, confirm: false, done }
    }
}

/// Normalised linear interpolation along the shorter arc. It uses only products and sums, so that
/// every platform yields the same bits.
fn nlerp(before: &UnitQuaternion<f64>, after: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    let after = if before.coords.dot(&after.coords) < 0.0 { -after.into_inner() } else { after.into_inner() };
    UnitQuaternion::new_normalize(before.into_inner().lerp(&after, share))
}

fn pose_on_axis(x_m: f64, plan: &Plan) -> Isometry3<f64> {
    needle_pose(&(plan.entry_m + plan.axis * x_m), &plan.axis)
}

fn planned_rotation(plan: &Plan) -> UnitQuaternion<f64> {
    needle_pose(&plan.entry_m, &plan.axis).rotation
}

fn along_axis(samples: &[AxialSample], plan: &Plan) -> Vec<(f64, Isometry3<f64>)> {
    samples.iter().map(|sample| (sample.t_s, pose_on_axis(sample.x_m, plan))).collect()
}

fn poses(table: &TrajectoryTable, plan: &Plan) -> Result<Vec<(f64, Isometry3<f64>)>, TrajectoryError> {
    let positions = table.numbers(table.columns(["px_m", "py_m", "pz_m"])?)?;
    let orientations = match table.column("qx")? {
        Some(_) => quaternions(table)?,
        None => vec![planned_rotation(plan); positions.len()],
    };
    Ok(positions
        .into_iter()
        .zip(orientations)
        .map(|((t_s, [x, y, z]), rotation)| (t_s, Isometry3::from_parts(Translation3::new(x, y, z), rotation)))
        .collect())
}

fn quaternions(table: &TrajectoryTable) -> Result<Vec<UnitQuaternion<f64>>, TrajectoryError> {
    let rows = table.numbers(table.columns(["qx", "qy", "qz", "qw"])?)?;
    let rotations = rows
        .into_iter()
        .enumerate()
        .map(|(index, (_, components))| unit_quaternion(components).map_err(|why| table.wrong(table.line(index), why)));
    rotations.collect()
}

/// Builds a rotation from its components x, y, z, w.
///
/// # Errors
/// If their length is not 1.
fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Result<UnitQuaternion<f64>, String> {
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(format!("qx,qy,qz,qw has length {length}; allowed: 1 ± {QUATERNION_TOLERANCE}"));
    }
    Ok(UnitQuaternion::new_normalize(quaternion))
}
