//! Effect of an encoder's resolution on the force: several versions of the law on the same
//! insertion, ideal and quantised.

use std::path::{Path, PathBuf};

use law::Incidence;
use law::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState, ForceLaw};
use plotters::prelude::*;

use super::chart::{self, Drawn, FONT, colour, key};
use super::sheet::ReportSheet;
use crate::error::BenchError;

const SPEED_M_PER_S: f64 = 0.002;
const TICK_S: f64 = 1e-3;
/// Range in which the forces are compared: in the muscle of the training scene, after its last pop
/// and before the target.
const FROM_M: f64 = 0.0185;
const TO_M: f64 = 0.027;
/// End of the plotted range.
const DRAWN_TO_M: f64 = 0.0205;
/// Resolution of the position, in µm: ideal, a fine encoder, a Phantom Omni.
const STEPS_UM: [f64; 3] = [0.0, 10.0, 55.0];
/// Change of force between two ticks that a hand feels, in N.
const JUMP_N: f64 = 0.05;
/// Version 1: cutting depends on whether a tick moved. Version 2: cutting by displacement, and
/// speed over a window. Version 5: damping by a spring and a dashpot.
const DRAWN_LAWS: [ForceLaw; 3] = [ForceLaw::Version1, ForceLaw::Version2, ForceLaw::Version5];
const SIZE: (u32, u32) = (960, 1080);

/// An insertion with the resulting forces.
struct FeltInsertion {
    law: ForceLaw,
    step_um: f64,
    /// Displacement in m, axial force and cutting force in N, tick by tick.
    ticks: Vec<FeltTick>,
}

struct FeltTick {
    x_m: f64,
    force_n: f64,
    cutting_n: f64,
}

impl FeltInsertion {
    /// Simulates an insertion under a version of the law, without the options that it does not
    /// support, with the position quantised to `step_um`.
    fn insert(spec: &AxialSpec, law: ForceLaw, step_um: f64) -> Result<Self, BenchError> {
        let speed_window_s = if law == ForceLaw::Version1 { 0.0 } else { spec.speed_window_s };
        let damping_time_s = if law < ForceLaw::Version5 { 0.0 } else { spec.damping_time_s };
        let spec = AxialSpec { law, speed_window_s, damping_time_s, ..spec.clone() };
        let params = AxialParams::new(spec).map_err(BenchError::work)?;
        let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
        let mut ticks = Vec::new();
        for tick in 0..(TO_M / (SPEED_M_PER_S * TICK_S)) as u32 {
            let (t_s, true_m) = (f64::from(tick) * TICK_S, f64::from(tick) * TICK_S * SPEED_M_PER_S);
            let step_m = step_um * 1e-6;
            let x_m = if step_m > 0.0 { (true_m / step_m).floor() * step_m } else { true_m };
            let output =
                axial::step(&params, &mut state, &mut scratch, &AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT });
            if true_m >= FROM_M {
                ticks.push(FeltTick { x_m: true_m, force_n: output.total_n(), cutting_n: output.cutting_n });
            }
        }
        Ok(Self { law, step_um, ticks })
    }

    fn cutting_share(&self) -> f64 {
        self.ticks.iter().filter(|tick| tick.cutting_n > 0.0).count() as f64 / self.ticks.len() as f64
    }

    fn mean_n(&self) -> f64 {
        self.ticks.iter().map(|tick| tick.force_n).sum::<f64>() / self.ticks.len() as f64
    }

    fn jumps_per_s(&self) -> f64 {
        let jumps = self.ticks.windows(2).filter(|pair| (pair[1].force_n - pair[0].force_n).abs() > JUMP_N).count();
        jumps as f64 / (self.ticks.len() as f64 * TICK_S)
    }

    fn name(&self) -> String {
        if self.step_um > 0.0 { format!("steps of {} µm", self.step_um) } else { "ideal".to_owned() }
    }
}

/// Output of the measurement.
pub struct EncoderReport {
    /// Files written.
    pub written: Vec<PathBuf>,
    /// Section of the report.
    pub markdown: String,
}

/// Measures the training scene.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, spec: &AxialSpec) -> Result<EncoderReport, BenchError> {
    let mut felt = Vec::new();
    for law in DRAWN_LAWS {
        for step_um in STEPS_UM {
            felt.push(FeltInsertion::insert(spec, law, step_um)?);
        }
    }
    let (plot, table) = (out.join("force-encoder.svg"), out.join("force-encoder.csv"));
    chart::finish(picture(&plot, &felt), &plot)?;
    let sheet = sheet(&felt);
    sheet.write_csv(&table)?;
    Ok(EncoderReport { written: vec![plot, table], markdown: markdown(&sheet) })
}

fn sheet(felt: &[FeltInsertion]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["law", "step_um", "cutting_share", "mean_force_n", "jumps_per_s"]);
    for felt in felt {
        sheet.row([
            u32::from(felt.law).to_string(),
            felt.step_um.to_string(),
            format!("{:.3}", felt.cutting_share()),
            format!("{:.4}", felt.mean_n()),
            format!("{:.1}", felt.jumps_per_s()),
        ]);
    }
    sheet
}

fn markdown(sheet: &ReportSheet) -> String {
    format!(
        "\n## On an encoder\n\nThe training scene's muscle at 2 mm/s and 1 kHz, by three versions of the law: the share of ticks that cut, the \
         mean axial force, and how often a second it jumps by more than {JUMP_N} N.\n\n{}\n![force against depth in steps](force-encoder.svg)\n",
        sheet.markdown()
    )
}

fn picture(path: &Path, felt: &[FeltInsertion]) -> Drawn {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let panels = root.split_evenly((DRAWN_LAWS.len(), 1));
    for (panel, law) in panels.iter().zip(DRAWN_LAWS) {
        let lines: Vec<&FeltInsertion> = felt.iter().filter(|felt| felt.law == law).collect();
        let most_n = felt.iter().flat_map(|felt| &felt.ticks).map(|tick| tick.force_n).fold(0.0, f64::max);
        let mut canvas = ChartBuilder::on(panel)
            .caption(format!("Version {} of the law, 2 mm/s in muscle", u32::from(law)), (FONT, 20))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(56)
            .build_cartesian_2d(FROM_M * 1e3..DRAWN_TO_M * 1e3, 0.0..most_n * 1.15)?;
        canvas
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("displacement of the hand from the skin, mm")
            .y_desc("axial force, N")
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .draw()?;
        // Draw the ideal curve last, so that the noisy ones do not hide it.
        for (index, felt) in lines.iter().enumerate().rev() {
            let drawn =
                felt.ticks.iter().filter(|tick| tick.x_m <= DRAWN_TO_M).map(|tick| (tick.x_m * 1e3, tick.force_n));
            let width = if index == 0 { 2 } else { 1 };
            canvas
                .draw_series(LineSeries::new(drawn, colour(index).stroke_width(width)))?
                .label(felt.name())
                .legend(key(index));
        }
        canvas
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.9))
            .label_font((FONT, 14))
            .draw()?;
    }
    root.present()?;
    Ok(())
}
