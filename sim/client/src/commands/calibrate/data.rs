//! Reads the measured curve, and rejects one that cannot be in metres and newtons.

use std::path::Path;

use attempt::trajectory::TrajectoryTable;
use law::axial::{AxialSpec, ParamError};
use tissue::calibrate::{Curve, TimedCurve, TimedSample, residual_rms_n, timed_residual_rms_n};

use crate::exit::Failure;

/// Maximum depth of a needle, in m.
const DEEPEST_M: f64 = 0.5;
/// Minimum length of a curve, in m, to show layers.
const SHORTEST_M: f64 = 1e-3;
/// Maximum force of a hand, in N.
const HARDEST_N: f64 = 200.0;
/// Minimum peak force of a curve, in N.
const FAINTEST_N: f64 = 0.02;

/// The measured curve: depth and force, optionally with times.
pub enum MeasuredCurve {
    /// Without times: an insertion so slow that speed has no effect.
    Slow(Curve),
    /// With times.
    Timed(TimedCurve),
}

impl MeasuredCurve {
    /// Number of samples in the fit.
    pub fn len(&self) -> usize {
        match self {
            Self::Slow(curve) => curve.len(),
            Self::Timed(curve) => curve.len(),
        }
    }

    /// Number of dropped samples.
    pub fn left_out(&self) -> usize {
        match self {
            Self::Slow(curve) => curve.left_out(),
            Self::Timed(curve) => curve.left_out(),
        }
    }

    /// The maximum force, in N.
    pub fn peak_n(&self) -> f64 {
        match self {
            Self::Slow(curve) => curve.peak_n(),
            Self::Timed(curve) => curve.peak_n(),
        }
    }

    /// Root mean square of the law's force minus the measured force, in N.
    pub fn residual_rms_n(&self, spec: &AxialSpec) -> Result<f64, ParamError> {
        match self {
            Self::Slow(curve) => Ok(residual_rms_n(spec, curve)),
            Self::Timed(curve) => timed_residual_rms_n(spec, curve),
        }
    }

    /// The same curve with every depth multiplied by a factor. A timed curve is never scaled.
    pub fn stretched(self, factor: f64) -> Self {
        match self {
            Self::Slow(curve) => Self::Slow(curve.stretched(factor)),
            timed => timed,
        }
    }
}

/// Reads the columns `depth_m` and `force_n`, and `t_s` if it exists and options are to be fitted.
pub fn read(path: &Path, is_optioned: bool) -> Result<MeasuredCurve, Failure> {
    let table = TrajectoryTable::read(path)?;
    let columns = table.columns(["depth_m", "force_n"])?;
    let rows = table.rows(columns)?;
    for (row, [depth_m, force_n]) in rows.iter().enumerate() {
        if depth_m.abs() > DEEPEST_M {
            let why = format!("depth_m = {depth_m} m; allowed: −{DEEPEST_M} m to {DEEPEST_M} m (is the column in mm?)");
            return Err(table.wrong(table.line(row), why).into());
        }
        if force_n.abs() > HARDEST_N {
            let why =
                format!("force_n = {force_n} N; allowed: −{HARDEST_N} N to {HARDEST_N} N (is the column in mN or g?)");
            return Err(table.wrong(table.line(row), why).into());
        }
    }
    let samples: Vec<(f64, f64)> = rows.into_iter().map(|[depth_m, force_n]| (depth_m, force_n)).collect();
    check_size(&samples).map_err(|why| Failure::refused(path, why))?;
    if !is_optioned || table.column("t_s")?.is_none() {
        let curve = Curve::new(&samples).map_err(|error| Failure::refused(path, error))?;
        return Ok(MeasuredCurve::Slow(curve));
    }
    let timed: Vec<TimedSample> = table
        .numbers(columns)?
        .into_iter()
        .map(|(t_s, [depth_m, force_n])| TimedSample { t_s, depth_m, force_n })
        .collect();
    let curve = TimedCurve::new(&timed).map_err(|error| Failure::refused(path, error))?;
    Ok(MeasuredCurve::Timed(curve))
}

/// Rejects depths and forces that are too small to be in metres and newtons, and forces of the
/// opposite sign.
fn check_size(samples: &[(f64, f64)]) -> Result<(), String> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (shallow_m, deep_m) = ends(&mut samples.iter().map(|sample| sample.0));
    let (low_n, high_n) = ends(&mut samples.iter().map(|sample| sample.1));
    let span_m = deep_m - shallow_m;
    if span_m < SHORTEST_M {
        return Err(format!("depth_m spans {span_m:e} m; allowed: at least {SHORTEST_M} m (is the column in km?)"));
    }
    let largest_n = high_n.max(-low_n);
    if largest_n < FAINTEST_N {
        return Err(format!(
            "force_n is at most {largest_n} N; allowed: a peak of at least {FAINTEST_N} N (is the column in kN?)"
        ));
    }
    if -low_n > high_n && advancing_mean_n(samples) < 0.0 {
        return Err(format!(
            "force_n goes down to {low_n} N while the tip advances; positive pushes the needle out: change the sign"
        ));
    }
    Ok(())
}

fn advancing_mean_n(samples: &[(f64, f64)]) -> f64 {
    samples.windows(2).filter(|pair| pair[1].0 > pair[0].0).map(|pair| pair[1].1).sum()
}
