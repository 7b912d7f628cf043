//! Effect of the angle between a needle's edge and a sheet's fibres: the training scene's fascia
//! under a bevel along, oblique to and across the fibres.

use std::path::{Path, PathBuf};

use documents::{Scene, SceneFibres};
use law::axial::{AxialSpec, Contactor, ForceLaw};
use law::closed_form;
use law::puncture::PunctureEvent;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use plotters::prelude::*;

use super::chart::{self, Drawn, FONT, colour, key};
use super::sheet::ReportSheet;
use super::specimen;
use crate::error::BenchError;
use trials::needle::{DT, DrivenNeedle};

const SPEED_M_PER_S: f64 = 0.002;
/// Plotted range, in m: from the end of the fat to beyond the fascia.
const FROM_M: f64 = 0.010;
const TO_M: f64 = 0.0165;
/// Angles of the edge to the fibres, in degrees.
const ANGLES_DEG: [f64; 3] = [0.0, 45.0, 90.0];
/// Tensions of the sheet, in N/m.
const TENSIONS_N_PER_M: [f64; 2] = [0.0, 20.0];
/// Stiffness and thresholds of the fascia under an edge along the fibres, relative to an edge
/// across them (choice).
const ALONG_STIFFNESS: f64 = 0.8;
const ALONG_THRESHOLD: f64 = 0.3;
const SIZE: (u32, u32) = (960, 480);

/// An insertion with an edge at an angle.
struct TurnedInsertion {
    angle_deg: f64,
    tension_n_per_m: f64,
    /// The fascia's own force when it ruptured, in N, and the displacement of the tip, in m.
    found: Opening,
    /// The closed-form prediction.
    predicted: Opening,
    /// Displacement in m and axial force in N, tick by tick.
    ticks: Vec<(f64, f64)>,
}

#[derive(Clone, Copy)]
struct Opening {
    force_n: f64,
    x_m: f64,
}

/// Output of the measurement.
pub struct FibresReport {
    /// Files written.
    pub written: Vec<PathBuf>,
    /// Section of the report.
    pub markdown: String,
}

/// Measures the training scene with fibres in its fascia, under a bevel.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, training: &Scene) -> Result<FibresReport, BenchError> {
    let mut insertions = Vec::new();
    for tension_n_per_m in TENSIONS_N_PER_M {
        for angle_deg in ANGLES_DEG {
            insertions.push(insert(training, tension_n_per_m, angle_deg)?);
        }
    }
    let (plot, table) = (out.join("force-fibres.svg"), out.join("force-fibres.csv"));
    chart::finish(picture(&plot, &insertions[..ANGLES_DEG.len()]), &plot)?;
    let sheet = sheet(&insertions);
    sheet.write_csv(&table)?;
    Ok(FibresReport { written: vec![plot, table], markdown: markdown(&sheet) })
}

/// Returns the scene with fibres along the patient's x in its fascia, under a bevelled needle, and
/// the index of the fascia.
fn fibrous_spec(training: &Scene, tension_n_per_m: f64) -> Result<(AxialSpec, usize), BenchError> {
    let mut scene = training.clone();
    scene.law = scene.law.max(ForceLaw::Version3);
    (scene.needle.tip, scene.needle.tip_to_rim_mm) = ("bevel".to_owned(), 0.0);
    let fascia =
        scene.layers.iter().position(|layer| layer.name == "fascia").ok_or_else(|| BenchError::work("no fascia"))?;
    scene.layers[fascia].options.fibres = Some(SceneFibres {
        angle_deg: 0.0,
        along_stiffness: ALONG_STIFFNESS,
        along_threshold: ALONG_THRESHOLD,
        pretension_n_per_m: tension_n_per_m,
        held_radius_mm: 20.0,
    });
    Ok((specimen::nominal_axial_spec(&scene), fascia))
}

fn insert(training: &Scene, tension_n_per_m: f64, angle_deg: f64) -> Result<TurnedInsertion, BenchError> {
    let (spec, fascia) = fibrous_spec(training, tension_n_per_m)?;
    let predicted = predict(&spec, fascia, angle_deg)?;
    let mut needle = DrivenNeedle::new(spec, vec![]).map_err(BenchError::work)?;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_deg.to_radians()) * down;
    let (mut found, mut ticks) = (None, Vec::new());
    for tick in 0..=(TO_M / (SPEED_M_PER_S * DT)) as u32 {
        let x_m = f64::from(tick) * SPEED_M_PER_S * DT;
        let output = needle.pose(Isometry3::from_parts(Translation3::new(0.0, 0.0, -x_m), turned));
        for event in &needle.scratch.events {
            if let PunctureEvent::Rupture(rupture) = event
                && rupture.boundary == fascia
            {
                found = Some(Opening { force_n: rupture.force_n, x_m: rupture.x_m });
            }
        }
        if x_m >= FROM_M {
            ticks.push((x_m, output.axial.total_n()));
        }
    }
    let found = found.ok_or_else(|| BenchError::work("the fascia did not open"))?;
    Ok(TurnedInsertion { angle_deg, tension_n_per_m, found, predicted, ticks })
}

/// Predicts the fascia's rupture in closed form.
fn predict(spec: &AxialSpec, fascia: usize, angle_deg: f64) -> Result<Opening, BenchError> {
    let turned = spec.under_edge([libm::cos(angle_deg.to_radians()), libm::sin(angle_deg.to_radians())]);
    let ruptures = closed_form::predict_ruptures(&turned);
    let of_fascia = ruptures.iter().find(|rupture| (rupture.contactor, rupture.boundary) == (Contactor::Tip, fascia));
    let x_m = of_fascia.ok_or_else(|| BenchError::work("the fascia has no rupture"))?.x_m;
    Ok(Opening { force_n: turned.layers[fascia].tip_rupture_n, x_m })
}

fn sheet(insertions: &[TurnedInsertion]) -> ReportSheet {
    let columns = ["edge_to_fibres_deg", "tension_n_per_m", "opens_at_n", "tip_at_mm", "predicted_n", "predicted_mm"];
    let mut sheet = ReportSheet::new(columns);
    for TurnedInsertion { angle_deg, tension_n_per_m, found, predicted, .. } in insertions {
        let [found_mm, predicted_mm] = [found, predicted].map(|opening| opening.x_m * 1e3);
        let measured = [found.force_n, found_mm, predicted.force_n, predicted_mm].map(|n| format!("{n:.3}"));
        sheet.row([angle_deg.to_string(), tension_n_per_m.to_string()].into_iter().chain(measured));
    }
    sheet
}

fn markdown(sheet: &ReportSheet) -> String {
    format!(
        "\n## Fibres and the needle's edge\n\nThe training scene's fascia with fibres, whose stiffness under an edge along them is \
         {ALONG_STIFFNESS} and whose threshold {ALONG_THRESHOLD} of that across (choices), under a bevel of 2 mm at 2 mm/s. Where and at which force \
         of its own the fascia opens, and the same in closed form; a tick is 0.002 mm. Tension stiffens the sheet and so opens it \
         sooner, at the same force.\n\n{}\n![force against depth by the angle of the edge](force-fibres.svg)\n",
        sheet.markdown()
    )
}

fn picture(path: &Path, insertions: &[TurnedInsertion]) -> Drawn {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let most_n = insertions.iter().flat_map(|turned| &turned.ticks).map(|tick| tick.1).fold(0.0, f64::max);
    let mut canvas = ChartBuilder::on(&root)
        .caption("A fascia under a bevel, by the angle of its edge to the fibres", (FONT, 22))
        .margin(16)
        .x_label_area_size(46)
        .y_label_area_size(60)
        .build_cartesian_2d(FROM_M * 1e3..TO_M * 1e3, 0.0..most_n * 1.1)?;
    canvas
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("displacement of the tip from the skin, mm")
        .y_desc("axial force on the hand, N")
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 16))
        .draw()?;
    for (index, turned) in insertions.iter().enumerate() {
        let points = turned.ticks.iter().map(|&(x_m, force_n)| (x_m * 1e3, force_n));
        canvas
            .draw_series(LineSeries::new(points, colour(index).stroke_width(2)))?
            .label(format!("edge at {}° to the fibres", turned.angle_deg))
            .legend(key(index));
    }
    let legend = SeriesLabelPosition::UpperLeft;
    canvas.configure_series_labels().position(legend).background_style(WHITE.mix(0.9)).label_font((FONT, 14)).draw()?;
    root.present()?;
    Ok(())
}
