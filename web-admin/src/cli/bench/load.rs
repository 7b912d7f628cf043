//! Requests at a steady rate.

use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use indicatif::ProgressBar;
use platform::clock::Clock;
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};

use super::pages::Page;
use super::visitor::BenchVisitor;

/// Step from each page to the next one requested. A prime, so that every page gets its turn, and
/// large, so that consecutive requests are far apart in the list, where neighbours are alike.
const STRIDE: usize = 7919;

/// Rate and duration of the load.
#[derive(Clone, Copy, Debug)]
pub(super) struct RequestPace {
    /// Requests per second.
    pub rate: u32,
    /// Duration, in s.
    pub seconds: u32,
}

/// A completed request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing {
    /// Index of the page.
    pub page: usize,
    /// Time from the moment the request was due until the response had arrived completely; a late
    /// start is included.
    pub took: Duration,
    /// Size of the compressed response, in bytes.
    pub bytes: usize,
}

/// Requests all pages in turn, each time with the next of its addresses, at a fixed rate that does
/// not wait for responses.
pub(super) async fn ask_steadily(
    visitors: &[BenchVisitor],
    pages: &[Page],
    pace: RequestPace,
) -> anyhow::Result<Vec<Timing>> {
    let requests = usize::try_from(u64::from(pace.rate) * u64::from(pace.seconds))?;
    let mut ticks = interval(Duration::from_secs(1) / pace.rate);
    // Delayed requests are made up for at once: the mean rate holds, and delays are measured.
    ticks.set_missed_tick_behavior(MissedTickBehavior::Burst);
    let progress = Arc::new(ProgressBar::new(requests as u64));
    let mut asked = JoinSet::new();
    for n in 0..requests {
        let page = n * STRIDE % pages.len();
        let (visitor, path) = &pages[page].asked[n / pages.len() % pages[page].asked.len()];
        let (visitor, path, progress) = (visitors[*visitor].clone(), path.clone(), Arc::clone(&progress));
        let due = ticks.tick().await;
        asked.spawn(async move {
            let bytes = size_of_answer(&visitor, &path).await?;
            progress.inc(1);
            Ok(Timing { page, took: due.elapsed(), bytes })
        });
    }
    let timings = asked.join_all().await.into_iter().collect();
    progress.finish_and_clear();
    timings
}

/// Requests one address repeatedly, each time after the previous response has arrived.
pub(super) async fn ask_repeatedly(visitor: &BenchVisitor, path: &str, times: usize) -> anyhow::Result<Vec<Timing>> {
    let clock = Clock::system();
    let mut timings = Vec::new();
    for _ in 0..times {
        let begun = clock.now();
        let bytes = size_of_answer(visitor, path).await?;
        let took_us = u64::try_from(clock.now().micros() - begun.micros())?;
        timings.push(Timing { page: 0, took: Duration::from_micros(took_us), bytes });
    }
    Ok(timings)
}

/// Returns the size of a page, compressed, in bytes; any status but 200 is an error.
async fn size_of_answer(visitor: &BenchVisitor, path: &str) -> anyhow::Result<usize> {
    let answer = visitor.ask(path, "gzip").await?;
    anyhow::ensure!(answer.status == StatusCode::OK, "{path}: {}", answer.status);
    Ok(answer.body.len())
}
