//! Time per tick of the force law.

use law::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState};

use super::quantile;
use super::sheet::ReportSheet;
use crate::clock;
use crate::error::BenchError;

/// Ticks timed together: long enough that reading the clock, tens of nanoseconds, does not count.
const BATCH: u32 = 100;
/// Batches timed.
const BATCHES: u32 = 20_000;
/// The motion repeats after this many ticks: in, hold and out again.
const PERIOD: u32 = 40_000;
/// Deepest displacement of the motion, in m.
const DEEPEST_M: f64 = 0.03;

/// Time per tick, in ns.
pub struct TickPace {
    layers: usize,
    median_ns: f64,
    p99_ns: f64,
    reserve_kept: bool,
}

/// Times the law on an in–hold–out motion.
///
/// # Errors
/// When the specification is refused.
pub fn measure(spec: &AxialSpec, quick: bool) -> Result<TickPace, BenchError> {
    let params = AxialParams::new(spec.clone()).map_err(BenchError::work)?;
    let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
    let reserve = scratch.ruptures.capacity();
    let batches = if quick { BATCHES / 100 } else { BATCHES };
    let mut tick = 0;
    let ns_per_tick: Vec<f64> = (0..batches)
        .map(|_| {
            let start = clock::instant();
            for _ in 0..BATCH {
                let input = AxialInput { t_s: f64::from(tick) * 1e-3, x_m: motion_m(tick), path_factor: 1.0 };
                std::hint::black_box(axial::step(&params, &mut state, &mut scratch, &input));
                tick += 1;
            }
            start.elapsed().as_secs_f64() * 1e9 / f64::from(BATCH)
        })
        .collect();
    Ok(TickPace {
        layers: spec.layers.len(),
        median_ns: quantile(&ns_per_tick, 0.5),
        p99_ns: quantile(&ns_per_tick, 0.99),
        reserve_kept: scratch.ruptures.capacity() == reserve,
    })
}

/// In for two fifths of the period, held for one, out for two.
fn motion_m(tick: u32) -> f64 {
    let share = f64::from(tick % PERIOD) / f64::from(PERIOD);
    let depth = (share / 0.4).min(1.0).min((1.0 - share) / 0.4);
    DEEPEST_M * depth - 0.001
}

impl TickPace {
    /// For people.
    pub fn markdown(&self) -> String {
        let mut sheet = ReportSheet::new(["what", "ns per tick"]);
        sheet.row(["median".to_owned(), format!("{:.0}", self.median_ns)]);
        sheet.row(["p99".to_owned(), format!("{:.0}", self.p99_ns)]);
        let allocation = match self.reserve_kept {
            true => "The room reserved for a tick's ruptures never grew.",
            false => "**The room reserved for a tick's ruptures had to grow.**",
        };
        format!(
            "Training scene, {} layers, two contactors; {BATCHES} means over {BATCH} ticks each, so that reading the clock \
             does not count. {allocation} That a tick allocates nothing is shown by a test that counts.\n\n{}",
            self.layers,
            sheet.markdown()
        )
    }
}
