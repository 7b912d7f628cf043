//! Soak test: ten minutes of random needle motion at 1 kHz on every shipped scene.

use std::path::{Path, PathBuf};

use documents::Patient;
use tissue::Specimen;

use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::Soaked;

/// Ten minutes at 1 kHz.
const TICKS: u32 = 600_000;

const SEED: u64 = 1;

/// A scene with the result of its soak test.
struct SoakRow {
    scene: String,
    seen: Soaked,
}

/// Runs the soak tests and writes `soak.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error, and, after the report has been written, if a bound is exceeded: each scene is
/// named.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let ticks = if quick { TICKS / 100 } else { TICKS };
    let scenes = dossier::read_shipped_scenes()?;
    let progress = MeasurementProgress::new(scenes.len() as u64, "soak");
    let mut rows = Vec::with_capacity(scenes.len());
    for scene in scenes {
        let spec = scene.specimen_spec(&Patient::nominal(&scene), 0.0);
        let specimen = Specimen::new(spec).map_err(BenchError::work)?;
        rows.push(SoakRow { seen: trials::soak(specimen.law(), specimen.field(), ticks, SEED), scene: scene.id });
        progress.advance(1);
    }
    let table = out.join("soak.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("soak.md"), &markdown(&rows, quick))?;
    let failed: Vec<String> =
        rows.iter().filter(|row| !row.seen.passes()).map(|row| format!("{}: {:?}", row.scene, row.seen)).collect();
    if failed.is_empty() { Ok(vec![table, text]) } else { Err(BenchError::Work(failed)) }
}

fn csv(rows: &[SoakRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "scene",
        "ticks",
        "tracks",
        "ruptures",
        "largest_force_n",
        "force_bound_n",
        "largest_ledger_error",
        "largest_undone_dissipation_j",
        "largest_tent_m",
        "largest_tent_to_bound",
        "ticks_not_finite",
        "pass",
    ]);
    for SoakRow { scene, seen } in rows {
        let numbers = [seen.force_n, seen.force_bound_n, seen.closure, seen.undone_j, seen.tent_m, seen.tent_share]
            .map(|number| format!("{number:?}"));
        let [force, bound, closure, undone, tent, share] = numbers;
        let counts = [seen.ticks.to_string(), seen.tracks.to_string(), seen.ruptures.to_string()];
        let [ticks, tracks, ruptures] = counts;
        let (broken, pass) = (seen.not_finite.to_string(), yes(seen));
        sheet.row([scene.clone(), ticks, tracks, ruptures, force, bound, closure, undone, tent, share, broken, pass]);
    }
    sheet
}

fn yes(seen: &Soaked) -> String {
    if seen.passes() { "yes" } else { "**no**" }.to_owned()
}

fn markdown(rows: &[SoakRow], quick: bool) -> String {
    let mut sheet = ReportSheet::new([
        "scene",
        "tracks",
        "ruptures",
        "largest force",
        "bound",
        "largest ledger error",
        "largest tent",
        "of its bound",
        "not finite",
        "pass",
    ]);
    for SoakRow { scene, seen } in rows {
        sheet.row([
            scene.clone(),
            seen.tracks.to_string(),
            seen.ruptures.to_string(),
            format!("{:.2} N", seen.force_n),
            format!("{:.2} N", seen.force_bound_n),
            format!("{:.1e}", seen.closure),
            format!("{:.1} mm", 1e3 * seen.tent_m),
            format!("{:.0} %", 100.0 * seen.tent_share),
            seen.not_finite.to_string(),
            yes(seen),
        ]);
    }
    let minutes = rows.first().map_or(0.0, |row| f64::from(row.seen.ticks) / 60_000.0);
    format!(
        "# Soak\n\n{}\n\n{minutes} minutes at 1 kHz on every shipped scene: insertions, withdrawals, stabs at 1 m/s, teleports of \
         50 mm, re-entries up to 60° off the normal, rests, samples that are no numbers and a clock that stands still, drawn \
         from a seed. The force is its elastic, friction and cutting part; its bound follows from the scene's thresholds, \
         friction and cutting force. The ledger must close to 1e-3 of the input, dissipation never decreases, and the field that follows the \
         needle at 125 Hz stays finite and inside the body: a boundary is dented no farther than the law dents it or half of the body along \
         the needle, and an opened one is never at the tip. A teleport is 50 m/s for a tick, whose viscous drag moves the tissue most.\n\n{}",
        measured_on(Subject::Soak, quick),
        sheet.markdown()
    )
}
