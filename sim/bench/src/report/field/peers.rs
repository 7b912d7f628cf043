//! Other solvers on the same cases: reads the results of `tests/peers/run` and compares their times
//! with ours.
//!
//! Solvers that `tests/peers` does not run are quoted from an independent comparison: measured on
//! two cores, one thread, no GPU, for one static solution after set-up, on another machine.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use csv::{DeserializeErrorKind, ErrorKind, StringRecord};
use serde::Deserialize;

use super::{Axis, FieldRow, cases, human_time, percent};
use crate::error::BenchError;
use crate::machine::Machine;
use crate::report::chart::ChartCurve;
use crate::report::sheet::ReportSheet;

/// A result of another solver: a line of the file, with fields named after its columns. The load is
/// at the surface.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Peer {
    /// Name in the package registry.
    solver: String,
    version: String,
    /// Elements and solver.
    model: String,
    /// 2 with axial symmetry, 3 without; a 3-D result is compared with our 3-D model, too.
    dimensions: u32,
    /// Name of a reference case.
    pub case: String,
    unknowns: usize,
    /// As in [`FieldRow`].
    relative_error: f64,
    /// Time for mesh, matrix and factorisation, in s.
    setup_s: f64,
    /// Time of a solution after set-up, in s.
    solve_s: f64,
    /// As formatted by [`Machine::in_words`].
    machine: String,
}

/// Reads the results of other solvers.
///
/// # Errors
/// If the file cannot be read, or if a line is not in the format of `tests/peers/measure`: names
/// the place, the value and the allowed values.
pub fn read(file: &Path) -> Result<Vec<Peer>, BenchError> {
    let name = file.display().to_string();
    parse(&name, &fs::read_to_string(file).map_err(|error| BenchError::input(format_args!("{name}: {error}")))?)
}

fn parse(name: &str, text: &str) -> Result<Vec<Peer>, BenchError> {
    let mut peers: Vec<Peer> = Vec::new();
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let columns = table.headers().map_err(|error| BenchError::input(format_args!("{name}: {error}")))?.clone();
    for (at, row) in table.records().enumerate() {
        let place = format!("{name}:{}", at + 2);
        let row = row.map_err(|error| BenchError::input(format_args!("{place}: {error}")))?;
        let read = row.deserialize(Some(&columns));
        let peer: Peer =
            read.map_err(|error| BenchError::input(format_args!("{place}: {}", explain(&error, &columns, &row))))?;
        if let Some(wrong) = peer.wrong() {
            return Err(BenchError::input(format_args!("{place}: {wrong}")));
        }
        peers.push(peer);
    }
    let machines: BTreeSet<&str> = peers.iter().map(|peer| peer.machine.as_str()).collect();
    match machines.len() {
        0 => Err(BenchError::input(format_args!("{name}: no line; at least one solver is needed"))),
        1 => Ok(peers),
        _ => Err(BenchError::input(format_args!(
            "{name}: machine: {machines:?}; all lines must be of one run on one machine"
        ))),
    }
}

/// Returns why a line cannot be parsed: for an invalid number, the column and its value.
fn explain(error: &csv::Error, columns: &StringRecord, row: &StringRecord) -> String {
    let number = match error.kind() {
        ErrorKind::Deserialize { err, .. } => {
            let is_number =
                matches!(err.kind(), DeserializeErrorKind::ParseFloat(_) | DeserializeErrorKind::ParseInt(_));
            err.field().filter(|_| is_number)
        }
        _ => None,
    };
    match number.and_then(|at| Some((columns.get(at as usize)?, row.get(at as usize)?))) {
        Some((column, value)) => format!("{column}: '{value}'; a number is needed"),
        None => error.to_string(),
    }
}

impl Peer {
    /// Returns why a result is impossible, if it is.
    fn wrong(&self) -> Option<String> {
        for (name, word) in [("solver", &self.solver), ("version", &self.version), ("model", &self.model)] {
            if word.trim().is_empty() {
                return Some(format!("{name}: empty; a name is needed"));
            }
        }
        if !(2..=3).contains(&self.dimensions) {
            return Some(format!("dimensions: {}; 2 or 3", self.dimensions));
        }
        if !cases::NAMES.contains(&self.case.as_str()) {
            return Some(format!("case: '{}'; one of {}", self.case, cases::NAMES.join(", ")));
        }
        if self.unknowns == 0 {
            return Some("unknowns: 0; 1 at least".to_owned());
        }
        let figures = [
            ("relative_error", self.relative_error, 10.0),
            ("setup_s", self.setup_s, 3600.0),
            ("solve_s", self.solve_s, 3600.0),
        ];
        let wrong = figures.into_iter().find(|&(_, figure, most)| !(figure > 0.0 && figure <= most));
        wrong.map(|(name, figure, most)| format!("{name}: {figure}; more than 0, at most {most}"))
    }

    fn title(&self) -> String {
        format!("{}, {}", self.solver, self.model)
    }

    /// Returns a row of the table of every mesh.
    pub fn cells(&self) -> [String; 7] {
        let [setup, solve] = [self.setup_s, self.solve_s].map(human_time);
        let unknowns = self.unknowns.to_string();
        [self.case.clone(), self.title(), unknowns, percent(self.relative_error), setup, solve, "–".to_owned()]
    }
}

/// Returns a curve for each model of each solver on a case, error in % against an axis.
pub fn curves(peers: &[Peer], case: &str, axis: Axis) -> Vec<ChartCurve> {
    let mut curves: Vec<ChartCurve> = Vec::new();
    for peer in peers.iter().filter(|peer| peer.case == case) {
        let point = (axis.place(peer.unknowns, peer.solve_s), peer.relative_error * 1e2);
        match curves.iter_mut().find(|curve| curve.name == peer.title()) {
            Some(curve) => curve.points.push(point),
            None => curves.push(ChartCurve { name: peer.title(), points: vec![point] }),
        }
    }
    curves
}

/// A quoted result on `lower_back`: solver, model, unknowns, error and time in s.
type Quote = (&'static str, &'static str, usize, f64, f64);

const PUBLISHED: [Quote; 9] = [
    ("CalculiX", "CAX8, whole process", 280, 0.022, 26e-3),
    ("CalculiX", "CAX8, whole process", 2360, 0.0011, 106e-3),
    ("dolfinx", "3-D P2 tetrahedra, Cholesky re-solve", 7840, 0.056, 4.8e-3),
    ("dolfinx", "3-D P2 tetrahedra, Cholesky re-solve", 23200, 0.029, 21e-3),
    ("dolfinx", "3-D P2 tetrahedra, Cholesky re-solve", 47424, 0.020, 52e-3),
    ("warp.fem", "3-D hexahedra degree 2, CG", 2800, 0.048, 2.7),
    ("warp.fem", "3-D hexahedra degree 2, CG", 7840, 0.016, 6.7),
    ("springs", "3-D, Van Gelder, static", 6734, 0.12, 1.9e-3),
    ("springs", "3-D, cubic lattice, static", 22040, 0.16, 49e-3),
];

/// Returns the results published with the cases, of solvers that are not measured here.
fn published() -> Vec<Peer> {
    let quoted = |(solver, model, unknowns, relative_error, solve_s): Quote| Peer {
        solver: solver.to_owned(),
        version: String::new(),
        model: model.to_owned(),
        dimensions: if model.starts_with("3-D") { 3 } else { 2 },
        case: "lower_back".to_owned(),
        unknowns,
        relative_error,
        setup_s: f64::NAN,
        solve_s,
        machine: String::new(),
    };
    PUBLISHED.into_iter().map(quoted).collect()
}

/// Compares each result with our cheapest solution that is at least as accurate, of any model and
/// of the 3-D model.
fn compared(rows: &[FieldRow], peers: &[Peer]) -> ReportSheet {
    let ours = ["our best model: re-solve", "superposed", "our volumetric: re-solve"];
    let mut sheet = ReportSheet::new(["case", "solver", "unknowns", "error", "its time"].into_iter().chain(ours));
    for peer in peers {
        let good = |volumetric: bool| {
            let no_worse = |row: &&FieldRow| row.is_surface_load_on(&peer.case) && row.error <= peer.relative_error;
            let fits = rows.iter().filter(no_worse).filter(|row| !volumetric || row.model == "volumetric");
            fits.min_by(|a, b| a.solve_s.total_cmp(&b.solve_s))
        };
        let times = |time_s: f64| format!("{} ({} ×)", human_time(time_s), ratio(peer.solve_s / time_s));
        let best = good(false);
        let volumetric = if peer.dimensions == 3 { good(true) } else { None };
        let told = [best.map(|row| row.solve_s), best.map(|row| row.answer_s), volumetric.map(|row| row.solve_s)];
        let told = told.map(|time_s| time_s.map_or_else(|| "–".to_owned(), times));
        let [case, title, unknowns, error, _, solve, _] = peer.cells();
        sheet.row([case, title, unknowns, error, solve].into_iter().chain(told));
    }
    sheet
}

/// Returns the section of the report.
pub fn markdown(rows: &[FieldRow], peers: &[Peer]) -> String {
    let bracket = "In brackets: their time over ours, our cheapest answer that is no less accurate.";
    let quoted = format!(
        "As published with the cases, on another machine, of solvers that are not measured here. {bracket}\n\n{}",
        compared(rows, &published()).markdown()
    );
    let Some(first) = peers.first() else {
        return format!("`tests/peers/run` measures other solvers in the same run.\n\n{quoted}");
    };
    let packages: BTreeSet<String> = peers.iter().map(|peer| format!("{} {}", peer.solver, peer.version)).collect();
    let elsewhere =
        if first.machine == Machine::this().in_words() { "" } else { " **Not the machine of our figures.**" };
    format!(
        "Measured by `tests/peers/run` right before ours, with {} on {}.{elsewhere} Load at the surface, one thread. `tests/peers` \
         describes what each solves and what it cannot represent: MuJoCo comes to rest by explicit steps, the others \
         back-substitute. {bracket}\n\n{}\n{quoted}",
        packages.into_iter().collect::<Vec<_>>().join(", "),
        first.machine,
        compared(rows, peers).markdown()
    )
}

/// Formats a ratio with its significant digits.
fn ratio(ratio: f64) -> String {
    match ratio {
        r if r < 10.0 => format!("{r:.1}"),
        r if r < 1e4 => format!("{r:.0}"),
        r => format!("{r:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "solver,version,model,dimensions,case,unknowns,relative_error,setup_s,solve_s,machine\n";
    const GOOD: &str = "mujoco,4.0.0,flex,3,lower_back,900,0.3,0.1,2.5,\"AMD EPYC, 2 threads, linux x86_64\"\n";

    #[test]
    fn committed_peers_cover_every_case_and_improve_when_refined() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/field-peers.csv");
        let peers = read(&file).expect("as it is written");
        for case in cases::NAMES {
            let curves = curves(&peers, case, Axis::Unknowns);
            let solvers: BTreeSet<&str> =
                curves.iter().map(|curve| curve.name.split(',').next().unwrap_or_default()).collect();
            assert_eq!(solvers, ["mujoco", "ngsolve", "scikit-fem"].into(), "{case}");
            for curve in curves {
                assert!(curve.points.len() >= 3, "{case}, {}: a curve", curve.name);
                let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
                assert!(last.0 > first.0 && last.1 < first.1, "{case}, {}: finer and no better", curve.name);
            }
        }
    }

    #[test]
    fn malformed_peer_line_is_rejected_with_place_value_and_rule() {
        assert_eq!(parse("p.csv", &format!("{HEAD}{GOOD}")).map(|peers| peers.len()).ok(), Some(1));
        let other = GOOD.replace("EPYC", "Ryzen");
        for (text, said) in [
            (format!("{HEAD}{GOOD}{}", GOOD.replace("0.3", "NaN")), ["p.csv:3", "relative_error: NaN", "more than 0"]),
            (format!("{HEAD}{}", GOOD.replace("2.5", "-1")), ["p.csv:2", "solve_s: -1", "more than 0"]),
            (format!("{HEAD}{}", GOOD.replace("900", "0")), ["p.csv:2", "unknowns: 0", "1 at least"]),
            (format!("{HEAD}{}", GOOD.replace("lower_back", "knee")), ["p.csv:2", "case: 'knee'", "lower_back"]),
            (format!("{HEAD}{}", GOOD.replace(",3,", ",4,")), ["p.csv:2", "dimensions: 4", "2 or 3"]),
            (format!("{HEAD}{}", GOOD.replace("4.0.0", " ")), ["p.csv:2", "version", "empty"]),
            (format!("{HEAD}{}", GOOD.replace("0.1", "fast")), ["p.csv:2", "setup_s: 'fast'", "a number"]),
            (format!("{HEAD}mujoco,4\n"), ["p.csv:2", "2 fields", "10 fields"]),
            (HEAD.replace("solve_s", "time_s") + GOOD, ["p.csv:2", "time_s", "solve_s"]),
            (format!("{HEAD}{GOOD}{other}"), ["p.csv", "machine", "one machine"]),
            (HEAD.to_owned(), ["p.csv", "no line", "at least one"]),
        ] {
            let refused = parse("p.csv", &text).expect_err(&text);
            let told = format!("{refused:?}");
            assert!(said.iter().all(|said| told.contains(said)), "{said:?} in {told}");
        }
    }

    #[test]
    fn ratios_have_the_digits_that_count() {
        assert_eq!([3.44, 168.2, 41_000.0].map(ratio), ["3.4", "168", "4e4"]);
    }
}
