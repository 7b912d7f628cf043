//! Computing time per tick of the force law.

use law::Incidence;
use law::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState};

use super::quantile;
use super::sheet::ReportSheet;
use crate::clock;
use crate::error::BenchError;

/// Ticks timed together, so that reading the clock, which takes tens of nanoseconds, is negligible.
const BATCH: u32 = 100;
/// Number of batches.
const BATCHES: u32 = 20_000;
/// Ticks after which the motion repeats: in, hold and out again.
const PERIOD: u32 = 40_000;
/// Largest displacement of the motion, in m.
const DEEPEST_M: f64 = 0.03;

/// Time per tick, in ns.
pub struct TickPace {
    median_ns: f64,
    p99_ns: f64,
    reserve_kept: bool,
}

/// Times the law on an in–hold–out motion, each time on a new track.
///
/// # Errors
/// If the specification is refused.
pub fn measure(spec: &AxialSpec, quick: bool) -> Result<TickPace, BenchError> {
    let params = AxialParams::new(spec.clone()).map_err(BenchError::work)?;
    let untouched = AxialState::new(&params);
    let (mut state, mut scratch) = (untouched.clone(), AxialScratch::new(&params));
    let reserve = scratch.ruptures.capacity();
    let batches = if quick { BATCHES / 100 } else { BATCHES };
    let mut tick = 0;
    let ns_per_tick: Vec<f64> = (0..batches)
        .map(|_| {
            if tick % PERIOD == 0 {
                state = untouched.clone();
            }
            let start = clock::instant();
            for _ in 0..BATCH {
                let input =
                    AxialInput { t_s: f64::from(tick) * 1e-3, x_m: motion_m(tick), incidence: Incidence::UPRIGHT };
                std::hint::black_box(axial::step(&params, &mut state, &mut scratch, &input));
                tick += 1;
            }
            start.elapsed().as_secs_f64() * 1e9 / f64::from(BATCH)
        })
        .collect();
    Ok(TickPace {
        median_ns: quantile(&ns_per_tick, 0.5),
        p99_ns: quantile(&ns_per_tick, 0.99),
        reserve_kept: scratch.ruptures.capacity() == reserve,
    })
}

/// In for two fifths of the period, held for one fifth, out for two fifths.
fn motion_m(tick: u32) -> f64 {
    let share = f64::from(tick % PERIOD) / f64::from(PERIOD);
    let depth = (share / 0.4).min(1.0).min((1.0 - share) / 0.4);
    DEEPEST_M * depth - 0.001
}

/// Formats the times of both laws: version 2, and version 3 with every option in every layer.
pub fn markdown(layers: usize, plain: &TickPace, optioned: &TickPace) -> String {
    let mut sheet = ReportSheet::new(["ns per tick", "median", "p99"]);
    for (what, pace) in [("version 2", plain), ("version 3, every option in every layer", optioned)] {
        sheet.row([what.to_owned(), format!("{:.0}", pace.median_ns), format!("{:.0}", pace.p99_ns)]);
    }
    let allocation = match plain.reserve_kept && optioned.reserve_kept {
        true => "The room reserved for a tick's ruptures never grew.",
        false => "**The room reserved for a tick's ruptures had to grow.**",
    };
    format!(
        "Training scene, {layers} layers, two contactors, in, hold and out on a new track each time; {BATCHES} means over {BATCH} ticks \
         each, so that reading the clock does not count. {allocation} That a tick allocates nothing is shown by a test that counts. With \
         every option a tick is to take 500 ns at most in the median.\n\n{}",
        sheet.markdown()
    )
}
