//! Fits of timed curves with known parameters: how often a 95 % interval of an option contains the
//! truth.

use law::axial::ParamError;
use tissue::calibrate::{CalibrateError, Quantity};

use super::calibrate::{IntervalTally, full, percent, rows_of_numbers};
use super::sheet::ReportSheet;
use super::threads::each_seed;
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::timed_calibration::{SampledTimedCurve, TimedTissue, TimedTrial, sample_timed, try_timed_fit};

/// First seed; no setting of the fit was tuned on these seeds.
pub(super) const FIRST_SEED: u64 = 20_000;
/// Smallest and largest share of all intervals that may contain the truth.
const COVERAGE: [f64; 2] = [0.93, 0.97];
/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.96;
/// Quantities that a timed curve can determine, in the order of the table.
const FITTED: [Quantity; 12] = [
    Quantity::Thickness,
    Quantity::Stiffness,
    Quantity::Friction,
    Quantity::StaticFriction,
    Quantity::Cutting,
    Quantity::TipThreshold,
    Quantity::Damping,
    Quantity::Stiffening,
    Quantity::BranchShare(0),
    Quantity::BranchTime(0),
    Quantity::Presliding,
    Quantity::Breakaway,
];

/// The result of a curve.
pub(super) struct TimedRow {
    seed: u64,
    sampled: SampledTimedCurve,
    outcome: Result<TimedTrial, CalibrateError>,
}

impl TimedRow {
    /// Returns the fit if it reports convergence.
    fn settled(&self) -> Option<&TimedTrial> {
        self.outcome.as_ref().ok().filter(|trial| trial.fit.converged)
    }
}

/// Fits the curves in parallel; returns them in the order of their seeds.
///
/// # Errors
/// If a thread panicked.
pub(super) fn fit_all(curves: u64, progress: &MeasurementProgress) -> Result<Vec<TimedRow>, BenchError> {
    let row = |seed| {
        let sampled = sample_timed(seed)?;
        let outcome = try_timed_fit(&sampled);
        progress.advance(1);
        Ok::<_, ParamError>(TimedRow { seed, sampled, outcome })
    };
    each_seed(FIRST_SEED..FIRST_SEED + curves, row)?.into_iter().collect::<Result<_, _>>().map_err(BenchError::work)
}

/// Returns a table of every parameter of every curve.
pub(super) fn csv(rows: &[TimedRow]) -> ReportSheet {
    let of_curve = ["tissue", "seed", "noise_n", "converged"];
    let of_number = ["layer", "parameter", "truth", "value", "low_95", "high_95", "holds"];
    let mut sheet = ReportSheet::new(of_curve.into_iter().chain(of_number));
    for TimedRow { seed, sampled, outcome } in rows {
        let Ok(trial) = outcome else { continue };
        let converged = trial.fit.converged.to_string();
        let of_curve = [sampled.tissue.words().to_owned(), seed.to_string(), full(sampled.noise_n), converged];
        for of_number in rows_of_numbers(&trial.parameters) {
            sheet.row(of_curve.iter().cloned().chain(of_number));
        }
    }
    sheet
}

/// Returns the section of the report.
pub(super) fn markdown(rows: &[TimedRow]) -> String {
    format!(
        "\n## Curves with times\n\nA needle goes 10 mm in at 4 mm/s, rests for 4 s and comes out; the law makes the curve in ticks of 1 ms, and every \
         30th is a sample, with white noise of 5, 10, 20 or 40 mN. It stops and turns between samples. The layers are drawn at random, and the fit \
         starts with every number changed by up to a fifth. *Held* and *not determined* are as above. *Band*: where the share that holds lies in 95 \
         of 100 such measurements, if each interval by itself holds the truth in 95 %; those of one curve depend on each other, which makes it wider.\n\n{}\n\
         By parameter, over all of them:\n\n{}",
        tissues(rows).markdown(),
        parameters(rows).markdown()
    )
}

/// Returns a failure if the intervals' coverage is not about 95 %.
pub(super) fn failures(rows: &[TimedRow]) -> Vec<String> {
    let [least, most] = COVERAGE;
    let share = tally(rows.iter(), |_| true).coverage();
    match share {
        Some(share) if (least..=most).contains(&share) => Vec::new(),
        Some(share) => {
            let (share, least, most) = (percent(share), percent(least), percent(most));
            vec![format!("curves with times: {share} of the intervals hold the truth; {least} to {most} are asked for")]
        }
        None => vec!["curves with times: no interval was given".to_owned()],
    }
}

fn tally<'r>(rows: impl Iterator<Item = &'r TimedRow>, is_counted: impl Fn(Quantity) -> bool) -> IntervalTally {
    let mut tally = IntervalTally::default();
    let judged = rows.filter_map(TimedRow::settled).flat_map(|trial| &trial.parameters);
    judged.filter(|judged| is_counted(judged.estimate.quantity)).for_each(|judged| tally.count(judged));
    tally
}

/// Returns number of intervals, share that contains the truth, its band, and share of parameters
/// without an interval.
fn cells(tally: &IntervalTally) -> [String; 4] {
    let given = tally.given();
    let half = NORMAL_95 * (0.95 * 0.05 / given.max(1) as f64).sqrt();
    let band = format!("{} to {}", percent(0.95 - half), percent((0.95 + half).min(1.0)));
    let held = tally.coverage().map_or_else(|| "none given".to_owned(), percent);
    let open = percent(tally.open() as f64 / tally.seen().max(1) as f64);
    [given.to_string(), held, band, open]
}

fn tissues(rows: &[TimedRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["tissue", "curves", "refused", "intervals", "held", "band", "not determined"]);
    let mut line = |name: &str, is_of: &dyn Fn(&TimedRow) -> bool| {
        let of = || rows.iter().filter(|row| is_of(row));
        let refused = of().filter(|row| row.settled().is_none()).count();
        let head = [name.to_owned(), of().count().to_string(), refused.to_string()];
        sheet.row(head.into_iter().chain(cells(&tally(of(), |_| true))));
    };
    for tissue in TimedTissue::ALL {
        line(tissue.words(), &|row| row.sampled.tissue == tissue);
    }
    line("all", &|_| true);
    sheet
}

fn parameters(rows: &[TimedRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["parameter", "intervals", "held", "band", "not determined"]);
    for quantity in FITTED {
        let tally = tally(rows.iter(), |other| other == quantity);
        if tally.seen() > 0 {
            sheet.row([quantity.words().to_owned()].into_iter().chain(cells(&tally)));
        }
    }
    sheet
}
