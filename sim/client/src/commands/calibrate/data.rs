//! The measured curve: read, and refused where it cannot be one in metres and newtons.

use std::path::Path;

use attempt::trajectory::TrajectoryTable;
use tissue::calibrate::Curve;

use crate::exit::Failure;

/// No needle goes deeper than this, in m.
const DEEPEST_M: f64 = 0.5;
/// A curve shorter than this, in m, shows no layers.
const SHORTEST_M: f64 = 1e-3;
/// No hand pushes a needle harder than this, in N.
const HARDEST_N: f64 = 200.0;
/// A curve whose largest force is less than this, in N, shows nothing that is felt.
const FAINTEST_N: f64 = 0.02;

/// Reads the columns `depth_m` and `force_n`.
pub fn read(path: &Path) -> Result<Curve, Failure> {
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
    Curve::new(&samples).map_err(|error| Failure::refused(path, error))
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
