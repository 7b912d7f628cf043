//! The measured curve: read, and refused where it cannot be one in metres and newtons.

use std::path::Path;

use attempt::trajectory::TrajectoryTable;
use law::axial::{AxialSpec, ParamError};
use tissue::calibrate::{Curve, TimedCurve, TimedSample, residual_rms_n, timed_residual_rms_n};

use crate::exit::Failure;

/// No needle goes deeper than this, in m.
const DEEPEST_M: f64 = 0.5;
/// A curve shorter than this, in m, shows no layers.
const SHORTEST_M: f64 = 1e-3;
/// No hand pushes a needle harder than this, in N.
const HARDEST_N: f64 = 200.0;
/// A curve whose largest force is less than this, in N, shows nothing that is felt.
const FAINTEST_N: f64 = 0.02;

/// What was measured: depth and force, or both with times.
pub enum MeasuredCurve {
    /// Without times: an insertion so slow that nothing depends on speed.
    Slow(Curve),
    /// With times.
    Timed(TimedCurve),
}

impl MeasuredCurve {
    /// How many samples the fit runs on.
    pub fn len(&self) -> usize {
        match self {
            Self::Slow(curve) => curve.len(),
            Self::Timed(curve) => curve.len(),
        }
    }

    /// How many samples were left out.
    pub fn left_out(&self) -> usize {
        match self {
            Self::Slow(curve) => curve.left_out(),
            Self::Timed(curve) => curve.left_out(),
        }
    }

    /// The largest force, in N.
    pub fn peak_n(&self) -> f64 {
        match self {
            Self::Slow(curve) => curve.peak_n(),
            Self::Timed(curve) => curve.peak_n(),
        }
    }

    /// Root mean square of the law's force less the measured, in N.
    pub fn residual_rms_n(&self, spec: &AxialSpec) -> Result<f64, ParamError> {
        match self {
            Self::Slow(curve) => Ok(residual_rms_n(spec, curve)),
            Self::Timed(curve) => timed_residual_rms_n(spec, curve),
        }
    }

    /// The same with every depth multiplied. One with times is never scaled.
    pub fn stretched(self, factor: f64) -> Self {
        match self {
            Self::Slow(curve) => Self::Slow(curve.stretched(factor)),
            timed => timed,
        }
    }
}

/// Reads the columns `depth_m` and `force_n`, and `t_s` where there is one and options are to be fitted.
pub fn read(path: &Path, is_optioned: bool) -> Result<MeasuredCurve, Failure> {
    let table = TrajectoryTable::read(path)?;
    let columns = table.columns(["depth_m", "force_n"])?;
    let rows = table.rows(columns)?;
    for (row, [depth_m, force_n]) in rows.iter().enumerate() {
        if depth_m.abs() > DEEPEST_M {
            let why =
                format!("depth_m = {depth_m} m; −{DEEPEST_M} m to {DEEPEST_M} m is allowed (is the column in mm?)");
            return Err(table.wrong(table.line(row), why).into());
        }
        if force_n.abs() > HARDEST_N {
            let why = format!(
                "force_n = {force_n} N; −{HARDEST_N} N to {HARDEST_N} N is allowed (is the column in mN or g?)"
            );
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

/// Depths and forces too small to be metres and newtons, and forces of the other sign.
fn check_size(samples: &[(f64, f64)]) -> Result<(), String> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (shallow_m, deep_m) = ends(&mut samples.iter().map(|sample| sample.0));
    let (low_n, high_n) = ends(&mut samples.iter().map(|sample| sample.1));
    let span_m = deep_m - shallow_m;
    if span_m < SHORTEST_M {
        return Err(format!("depth_m spans {span_m:e} m; at least {SHORTEST_M} m is allowed (is the column in km?)"));
    }
    let largest_n = high_n.max(-low_n);
    if largest_n < FAINTEST_N {
        return Err(format!(
            "force_n is at most {largest_n} N; at least {FAINTEST_N} N is allowed (is the column in kN?)"
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
