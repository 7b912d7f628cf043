//! Curved skins and inclusions: the planner's choice, its estimated error, and its true error.

use std::path::{Path, PathBuf};

use law::Skin;
use tissue::Model;
use tissue::follow::{Field, TissueSpec};
use tissue::volumetric::Inclusion;

use super::field::{human_time, percent};
use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use crate::timing;
use trials::lumps::{lower_back_with, make_ball, push_everywhere_m, worst_push_error};

/// Size of the reference's elements near the load, in m.
const NEAR_M: f64 = 1.2e-3;

/// A skin and inclusions below it, under a needle.
struct LumpCase {
    name: &'static str,
    tilt_deg: f64,
    skin: Skin,
    lumps: Vec<Inclusion>,
}

/// A case with its result.
struct LumpRow {
    case: LumpCase,
    model: Model,
    claim: f64,
    error: f64,
    /// Error of flat layers without inclusions.
    flat_error: f64,
    setup_s: f64,
    bytes: usize,
}

fn list_cases() -> Vec<LumpCase> {
    let case = |name, tilt_deg, skin, lumps: &[Inclusion]| LumpCase { name, tilt_deg, skin, lumps: lumps.to_vec() };
    let sphere = |radius_m| Skin::Sphere { radius_m };
    let stiff = 1000.0;
    vec![
        case("flat", 12.0, Skin::Flat, &[]),
        case("ball of 65 mm, 12° slope", 12.0, sphere(0.065), &[]),
        case("ball of 120 mm, 12° slope", 12.0, sphere(0.12), &[]),
        case("ball of 2 m, 12° slope", 12.0, sphere(2.0), &[]),
        case("cylinder of 65 mm", 0.0, Skin::cylinder_along_y(0.065), &[]),
        case("cylinder of 110 mm, 30° across", 30.0, Skin::cylinder_along_y(0.11), &[]),
        case("cylinder of 110 mm, 30° along", 30.0, Skin::Cylinder { radius_m: 0.11, along_rad: 0.0 }, &[]),
        case("cylinder of 110 mm, 30° aslant", 30.0, Skin::Cylinder { radius_m: 0.11, along_rad: 0.8 }, &[]),
        case(
            "hard, r 5, 3 mm under the muscle's boundary",
            0.0,
            Skin::Flat,
            &[make_ball([0.0, 0.0, -17.2], 5.0, stiff)],
        ),
        case("hard, r 5, touching it", 0.0, Skin::Flat, &[make_ball([0.0, 0.0, -14.3], 5.0, stiff)]),
        case("soft, r 5, 3 mm under it", 0.0, Skin::Flat, &[make_ball([0.0, 0.0, -17.2], 5.0, 3.0)]),
        case("hard, r 5, 4 mm beside the needle", 0.0, Skin::Flat, &[make_ball([10.0, 0.0, -14.0], 5.0, stiff)]),
        case("hard, r 4, 20 mm deep, far aside", 0.0, Skin::Flat, &[make_ball([30.0, 0.0, -24.0], 4.0, stiff)]),
        case("hard, r 3, in the fat, pierced", 15.0, Skin::Flat, &[make_ball([1.3, 0.0, -5.0], 3.0, 300.0)]),
        case(
            "two, beside the needle's plane",
            15.0,
            Skin::Flat,
            &[make_ball([4.0, 6.0, -18.0], 5.0, stiff), make_ball([0.0, -9.0, -16.0], 4.0, 10.0)],
        ),
        case("hard, r 6, ball of 110 mm, 12° slope", 12.0, sphere(0.11), &[make_ball([5.0, 0.0, -24.0], 6.0, 400.0)]),
    ]
}

/// Measures and writes `lumps.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error, or if a tissue has no field.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let cases = list_cases();
    let count = if quick { 2 } else { cases.len() };
    let progress = MeasurementProgress::new(count as u64, "lumps");
    let mut rows = Vec::new();
    for case in cases.into_iter().take(count) {
        rows.push(measure_case(case)?);
        progress.advance(1);
    }
    let table = out.join("lumps.csv");
    sheet(&rows).write_csv(&table)?;
    let text = format!(
        "# Skins that bend, and lumps\n\n{}\n\nThe lower back of physics section 4 under a needle of 2 mm, to a tolerance of 5 %. *Error*: relative L2 \
         error of the displacement along the needle at every boundary, under the push at a boundary for which it is largest, against hexahedra of order 3 and \
         {:.1} mm made for each push alone. *Flat*: the error of flat layers without anything in them. *Claim*: what the plan says of any load. Times are of one \
         thread and once; 2 s and 64 MiB are what a set-up may take.\n\n{}",
        measured_on(Subject::Lumps, quick),
        NEAR_M * 1e3,
        sheet(&rows).markdown()
    );
    Ok(vec![table, sheet::write_text(out.join("lumps.md"), &text)?])
}

fn measure_case(case: LumpCase) -> Result<LumpRow, BenchError> {
    let tissue = lower_back_with(case.tilt_deg, case.skin, &case.lumps);
    let (field, setup_s) = timing::once(|| Field::new(&tissue));
    let field = field.map_err(BenchError::work)?;
    let wanted_m = push_everywhere_m(&tissue, NEAR_M).map_err(BenchError::work)?;
    let flat = Field::new(&TissueSpec { tilt_rad: tissue.tilt_rad, ..tissue.leveled() }).map_err(BenchError::work)?;
    let plan = field.plan();
    Ok(LumpRow {
        model: plan.model,
        claim: plan.expected_relative_error,
        error: worst_push_error(&field, &wanted_m),
        flat_error: worst_push_error(&flat, &wanted_m),
        setup_s,
        bytes: plan.bytes,
        case,
    })
}

fn sheet(rows: &[LumpRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["case", "model", "error", "claim", "flat", "set-up", "memory"]);
    for row in rows {
        sheet.row([
            row.case.name.to_owned(),
            row.model.name().to_owned(),
            percent(row.error),
            percent(row.claim),
            percent(row.flat_error),
            human_time(row.setup_s),
            format!("{:.1} MB", row.bytes as f64 / 1e6),
        ]);
    }
    sheet
}
