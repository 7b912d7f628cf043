//! Plots of fits over their curves.

use std::path::Path;

use law::axial::AxialSpec;
use law::operator::Draw;
use law::quasistatic::quasistatic_forces_n;
use plotters::prelude::*;

use super::chart::{self, Drawn, FONT, INK, colour};
use super::specimen;
use super::{calibrate, calibrate_timed};
use crate::error::BenchError;
use trials::calibration::{Disturbance, Measurement, Origin, sample, try_fit};
use trials::timed_calibration::{
    DEEPEST_M, HOLD_S, SampledTimedCurve, TimedNoise, TimedTissue, insertion, sample_timed, try_timed_fit,
};

/// A published profile of an epidural insertion, and the shipped scene that was fitted to it.
const PROFILE: &str = include_str!("../../../../tests/data/calibrate/epidural-71kg.csv");
const PROFILED: &str = "epidural-71kg";
/// Panels per row, and their size.
const COLUMNS: usize = 3;
const PANEL: (u32, u32) = (420, 330);
/// Number of timed curves searched for one to plot.
const SEARCHED: usize = 96;
/// Maximum number of samples plotted for a curve.
const SHOWN: usize = 300;

/// A curve, and the fitted law's force along it.
struct FitPanel {
    title: String,
    x: &'static str,
    measured: Vec<(f64, f64)>,
    fitted: Vec<(f64, f64)>,
}

/// Plots one curve of every kind.
///
/// # Errors
/// If a curve cannot be fitted, or on an I/O error.
pub(super) fn draw(path: &Path) -> Result<(), BenchError> {
    let mut panels = vec![random("random layers, needle", 0.0)?, random("random layers, trocar", 0.002)?, profile()?];
    for tissue in TimedTissue::ALL {
        panels.push(timed(tissue)?);
    }
    chart::finish(picture(path, &panels), path)
}

/// Returns the panel of two random layers under a needle or a trocar.
fn random(name: &str, tip_to_rim_m: f64) -> Result<FitPanel, BenchError> {
    let measurement = Measurement { noise_n: 0.04, spacing_m: 0.1e-3, withdraws: true, disturbance: Disturbance::None };
    let sampled = sample(Origin::Blind { layers: 2, tip_to_rim_m }, measurement, calibrate::FIRST_SEED)
        .ok_or_else(|| BenchError::work("no random layers serve"))?;
    let spec = try_fit(&sampled).map_err(BenchError::work)?.fit.spec;
    Ok(along_depth(format!("{name}, noise 40 mN"), sampled.samples, &spec))
}

/// Returns the panel of the epidural profile with the shipped scene.
fn profile() -> Result<FitPanel, BenchError> {
    let scene = dossier::read_shipped_scenes()?.into_iter().find(|scene| scene.id == PROFILED);
    let scene = scene.ok_or_else(|| BenchError::work(format_args!("{PROFILED} is not shipped")))?;
    let samples = PROFILE.lines().filter_map(|line| {
        let (depth_m, force_n) = line.split_once(',')?;
        Some((depth_m.parse().ok()?, force_n.parse().ok()?))
    });
    let title = "epidural profile, the shipped scene".to_owned();
    Ok(along_depth(title, samples.collect(), &specimen::nominal_axial_spec(&scene)))
}

fn along_depth(title: String, samples: Vec<(f64, f64)>, spec: &AxialSpec) -> FitPanel {
    let track_m: Vec<f64> = samples.iter().map(|sample| sample.0).collect();
    let fitted_n = quasistatic_forces_n(spec, &track_m);
    let fitted = track_m.iter().map(|depth_m| depth_m * 1e3).zip(fitted_n).collect();
    let measured = samples.into_iter().map(|(depth_m, force_n)| (depth_m * 1e3, force_n)).collect();
    FitPanel { title, x: "depth, mm", measured, fitted }
}

/// Returns the panel of the first curve of a tissue, at its largest noise, whose fit yields a sound
/// scene.
fn timed(tissue: TimedTissue) -> Result<FitPanel, BenchError> {
    let seeds = calibrate_timed::FIRST_SEED..;
    let of = |seed| sample_timed(seed).ok().filter(|sampled| sampled.tissue == tissue && sampled.noise_n > 0.03);
    let fitted = |sampled: SampledTimedCurve| {
        let fit = try_timed_fit(&sampled).ok()?.fit;
        (fit.converged && fit.asked.is_none()).then_some((sampled, fit.spec))
    };
    let found = seeds.take(SEARCHED).filter_map(of).find_map(fitted);
    let (sampled, spec) = found.ok_or_else(|| BenchError::work("no curve of this tissue is fitted"))?;
    let noise = TimedNoise { draw: &mut Draw::new(0), deviation_n: 0.0 };
    let fitted = insertion(&spec, DEEPEST_M, HOLD_S, noise).map_err(BenchError::work)?;
    let points = |samples: &[tissue::calibrate::TimedSample]| samples.iter().map(|s| (s.t_s, s.force_n)).collect();
    Ok(FitPanel {
        title: format!("{}, noise 40 mN", sampled.tissue.words()),
        x: "time, s",
        measured: points(&sampled.samples),
        fitted: points(&fitted),
    })
}

fn picture(path: &Path, panels: &[FitPanel]) -> Drawn {
    let rows = panels.len().div_ceil(COLUMNS);
    let size = (PANEL.0 * COLUMNS as u32, PANEL.1 * rows as u32 + 60);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let titled = root.titled("Curves (points) and their fits (lines), axial force in N", (FONT, 22))?;
    for (panel, area) in panels.iter().zip(titled.margin(0, 24, 0, 0).split_evenly((rows, COLUMNS))) {
        let points = || panel.measured.iter().chain(&panel.fitted);
        let (low, high) = points().fold((0.0_f64, 0.0_f64), |(low, high), point| (low.min(point.1), high.max(point.1)));
        let most = points().fold(0.0_f64, |most, point| most.max(point.0));
        let mut canvas = ChartBuilder::on(&area)
            .caption(&panel.title, (FONT, 16))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(46)
            .build_cartesian_2d(0.0..most, 1.05 * low..1.05 * high)?;
        canvas
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(panel.x)
            .label_style((FONT, 13))
            .axis_desc_style((FONT, 14))
            .draw()?;
        let every = panel.measured.len().div_ceil(SHOWN).max(1);
        let point = |point: &(f64, f64)| Circle::new(*point, 2, INK.mix(0.5).filled());
        canvas.draw_series(panel.measured.iter().step_by(every).map(point))?;
        canvas.draw_series(LineSeries::new(panel.fitted.iter().copied(), colour(1).stroke_width(2)))?;
    }
    root.present()?;
    Ok(())
}
