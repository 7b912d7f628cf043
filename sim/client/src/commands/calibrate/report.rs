//! The report of a fit, as text and as JSON.

use std::io::{self, Write};

use documents::Scene;
use law::axial::Contactor;
use law::soundness::Unsound;
use serde::Serialize;
use tissue::calibrate::{Fit, Misfit, ParameterEstimate, ParameterStanding, Quantity};

use super::{CalibrateArgs, WrittenScene};
use crate::output;

/// Number of samples in a fit, and number of dropped samples.
pub struct SampleCount {
    pub samples: usize,
    pub left_out: usize,
}

/// The report of a fit.
#[derive(Serialize)]
pub struct CalibrationReport {
    data: String,
    scene: String,
    samples: usize,
    samples_left_out: usize,
    noise_n: f64,
    steps: u32,
    /// Whether the fit reached a minimum, and left only noise.
    converged: bool,
    /// Structure of the residual beyond the curve's noise.
    misfit: Option<MisfitRow>,
    /// Of the written scene, on the curve.
    residual_rms_n: f64,
    residual_relative_to_peak: f64,
    peak_n: f64,
    /// Ratio of the written scene's depths to those of the curve; 1 without --weight-kg.
    depth_scale: f64,
    peaks: Vec<PeakRow>,
    unexplained_drops: Vec<DropRow>,
    /// Effective values for this needle, at the depths of the curve.
    parameters: Vec<ParameterRow>,
    undetermined: Vec<String>,
    /// The fit of the data alone, if it is unsound.
    unsound_without_constraint: Option<AskedRow>,
}

#[derive(Serialize)]
struct PeakRow {
    layer: String,
    contactor: Contactor,
    boundary: usize,
    depth_mm: f64,
    force_n: f64,
    measured_depth_mm: Option<f64>,
    measured_force_n: Option<f64>,
    depth_error_mm: Option<f64>,
    force_error_relative: Option<f64>,
}

#[derive(Serialize)]
struct DropRow {
    depth_mm: f64,
    fall_n: f64,
}

#[derive(Serialize)]
struct ParameterRow {
    layer: String,
    parameter: &'static str,
    value: f64,
    /// The ends of the 95 % interval; null if the parameter is not determined.
    interval_95: Option<[f64; 2]>,
    unit: &'static str,
    /// `free`, `lower bound`, `upper bound` or `kept`.
    state: &'static str,
}

#[derive(Serialize)]
struct MisfitRow {
    rms_n: f64,
    noise_n: f64,
    worst_depth_mm: f64,
    neighbour_correlation: f64,
    #[serde(skip)]
    words: String,
}

#[derive(Serialize)]
struct AskedRow {
    residual_rms_n: f64,
    ruptures: Vec<RiseRow>,
}

/// A rupture that would create force or energy.
#[derive(Serialize)]
struct RiseRow {
    layer: String,
    contactor: Contactor,
    threshold_n: f64,
    force_rise_n: f64,
    energy_rise_mj: f64,
}

impl CalibrationReport {
    /// Gathers the content of the report.
    pub fn new(args: &CalibrateArgs, count: SampleCount, fit: &Fit, written: &WrittenScene) -> Self {
        let name =
            |layer: usize| written.scene.layers.get(layer).map_or_else(|| "needle".to_owned(), |l| l.name.clone());
        Self {
            data: args.data.display().to_string(),
            scene: args.out.display().to_string(),
            samples: count.samples,
            samples_left_out: count.left_out,
            noise_n: fit.noise_n,
            steps: fit.iterations,
            converged: fit.converged,
            misfit: fit.misfit.as_ref().map(MisfitRow::new),
            residual_rms_n: written.rms_n,
            residual_relative_to_peak: written.rms_n / fit.peak_n,
            peak_n: fit.peak_n,
            depth_scale: written.depth_scale,
            peaks: peaks(fit, &written.scene),
            unexplained_drops: fit
                .unexplained
                .iter()
                .map(|&(x, fall_n)| DropRow { depth_mm: x * 1e3, fall_n })
                .collect(),
            parameters: fit.estimates.iter().map(|estimate| parameter(estimate, name(estimate.layer))).collect(),
            undetermined: fit.undetermined.clone(),
            unsound_without_constraint: fit.asked.as_ref().map(|asked| AskedRow {
                residual_rms_n: asked.rms_n,
                ruptures: asked.unsound.iter().map(RiseRow::new).collect(),
            }),
        }
    }

    /// Prints warnings that matter before using the scene, on standard error.
    pub fn warn(&self) {
        if let Some(asked) = &self.unsound_without_constraint {
            output::print_warning(format_args!(
                "{}: the data alone would require a rupture that creates force or energy: {}; the scene is sound and \
                 fits with {:.3} N rms instead of {:.3} N",
                self.data,
                asked.ruptures.iter().map(RiseRow::words).collect::<Vec<_>>().join("; "),
                self.residual_rms_n,
                asked.residual_rms_n
            ));
        }
        for drop in &self.unexplained_drops {
            output::print_warning(format_args!(
                "{}: no rupture explains the drop of {:.3} N at {:.2} mm; another layer might be needed (--layers)",
                self.data, drop.fall_n, drop.depth_mm
            ));
        }
        if let Some(misfit) = &self.misfit {
            output::print_warning(format_args!("{}: {}", self.data, misfit.words));
        } else if !self.converged {
            output::print_warning(format_args!("{}: the fit did not converge within {} steps", self.data, self.steps));
        }
    }

    /// Writes the human-readable form.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let (samples, left_out, steps) = (self.samples, self.samples_left_out, self.steps);
        writeln!(
            out,
            "{}: fitted to {samples} samples of {} ({left_out} omitted) in {steps} steps",
            self.scene, self.data
        )?;
        let percent = 100.0 * self.residual_relative_to_peak;
        let (rms_n, peak_n, noise_n) = (self.residual_rms_n, self.peak_n, self.noise_n);
        writeln!(
            out,
            "  residual {rms_n:.4} N rms, {percent:.2} % of the peak of {peak_n:.3} N; noise of the curve {noise_n:.4} N"
        )?;
        if self.weighted() {
            writeln!(out, "  depths written × {:.4}; the depths below are those of the curve", self.depth_scale)?;
        }
        self.write_peaks(out)?;
        self.write_parameters(out)?;
        writeln!(out, "  the curve cannot determine:")?;
        self.undetermined.iter().try_for_each(|line| writeln!(out, "    {line}"))
    }

    fn weighted(&self) -> bool {
        (self.depth_scale - 1.0).abs() > f64::EPSILON
    }

    fn write_peaks(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "\n  {:36} {:>9} {:>9} {:>9} {:>8}", "peak", "depth mm", "error mm", "force N", "error %")?;
        for peak in &self.peaks {
            let title = peak.contactor.into_layer(&peak.layer).to_string();
            let depth = peak.depth_error_mm.map_or_else(|| "–".to_owned(), |mm| format!("{mm:+.3}"));
            let force =
                peak.force_error_relative.map_or_else(|| "–".to_owned(), |part| format!("{:+.2}", part * 100.0));
            writeln!(out, "  {title:36} {:>9.3} {depth:>9} {:>9.3} {force:>8}", peak.depth_mm, peak.force_n)?;
        }
        writeln!(out, "  (– where the curve has no drop of its own)")
    }

    fn write_parameters(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "\n  {:24} {:19} {:>10} {:>10} {:>10} {:4} state",
            "layer", "parameter", "value", "95 % from", "to", "unit"
        )?;
        for row in &self.parameters {
            let ParameterRow { layer, parameter, value, unit, state, .. } = row;
            let end = |at: usize| row.interval_95.map_or_else(|| "–".to_owned(), |ends| format!("{:.3}", ends[at]));
            let (low, high) = (end(0), end(1));
            writeln!(out, "  {layer:24} {parameter:19} {value:>10.3} {low:>10} {high:>10} {unit:4} {state}")?;
        }
        writeln!(
            out,
            "  (– not determined; as this needle meets them, the scene states them for the reference needle, 2 mm with a diamond tip)\n"
        )
    }
}

impl MisfitRow {
    fn new(misfit: &Misfit) -> Self {
        Self {
            rms_n: misfit.rms_n,
            noise_n: misfit.noise_n,
            worst_depth_mm: misfit.worst_m * 1e3,
            neighbour_correlation: misfit.correlation,
            words: misfit.words(),
        }
    }
}

impl RiseRow {
    fn new(unsound: &Unsound) -> Self {
        Self {
            layer: unsound.layer.clone(),
            contactor: unsound.contactor,
            threshold_n: unsound.threshold_n,
            force_rise_n: unsound.force_rise_n,
            energy_rise_mj: unsound.energy_rise_mj,
        }
    }

    fn words(&self) -> String {
        format!(
            "{} at {:.3} N, force +{:.3} N, energy +{:.3} mJ",
            self.contactor.into_layer(&self.layer),
            self.threshold_n,
            self.force_rise_n,
            self.energy_rise_mj
        )
    }
}

fn peaks(fit: &Fit, scene: &Scene) -> Vec<PeakRow> {
    let row = |peak: &tissue::calibrate::Peak| PeakRow {
        layer: scene.layers.get(peak.boundary).map_or_else(String::new, |layer| layer.name.clone()),
        contactor: peak.contactor,
        boundary: peak.boundary,
        depth_mm: peak.depth_m * 1e3,
        force_n: peak.force_n,
        measured_depth_mm: peak.measured.map(|(x, _)| x * 1e3),
        measured_force_n: peak.measured.map(|(_, force_n)| force_n),
        depth_error_mm: peak.measured.map(|(x, _)| (peak.depth_m - x) * 1e3),
        force_error_relative: peak.measured.map(|(_, force_n)| peak.force_n / force_n - 1.0),
    };
    fit.peaks.iter().map(row).collect()
}

fn parameter(estimate: &ParameterEstimate, layer: String) -> ParameterRow {
    let (unit, scale) = match estimate.quantity {
        Quantity::Thickness | Quantity::Breakaway => ("mm", 1e3),
        Quantity::Stiffness | Quantity::Friction | Quantity::StaticFriction | Quantity::Presliding => ("N/m", 1.0),
        Quantity::Stiffening => ("N/m²", 1.0),
        Quantity::Damping => ("Ns/m²", 1.0),
        Quantity::BranchShare(_) => ("", 1.0),
        Quantity::BranchTime(_) => ("s", 1.0),
        Quantity::Cutting | Quantity::TipThreshold | Quantity::RimThreshold => ("N", 1.0),
    };
    let state = match estimate.standing {
        ParameterStanding::Free => "free",
        ParameterStanding::AtLower => "lower bound",
        ParameterStanding::AtUpper => "upper bound",
        ParameterStanding::Kept => "kept",
    };
    ParameterRow {
        layer,
        parameter: estimate.quantity.words(),
        value: estimate.value * scale,
        interval_95: estimate.interval.map(|interval| [interval.low * scale, interval.high * scale]),
        unit,
        state,
    }
}
