//! The measurements of each page, as a file that later measurements are compared with.

use std::path::Path;

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};

/// Name of the row that covers all pages together.
pub(super) const ALL_PAGES: &str = "all pages";

/// Response times of one page, or of all pages, on one school.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PageFigures {
    /// Database engine.
    pub engine: String,
    /// Number of attempts in the school.
    pub attempts: u32,
    /// The page's route, or [`ALL_PAGES`].
    pub page: String,
    /// Role of the visitor; empty for all pages.
    pub seen_by: String,
    /// Number of requests.
    pub requests: usize,
    /// Mean size of a compressed response, in kB.
    pub kilobytes: f64,
    /// Median response time, in ms.
    pub p50_ms: f64,
    /// 99th percentile of the response time, in ms.
    pub p99_ms: f64,
}

impl PageFigures {
    /// Whether both measure the same page on schools of the same size.
    pub(super) fn matches(&self, other: &Self) -> bool {
        self.attempts == other.attempts && self.is_same_page(other)
    }

    /// Whether both measure the same page, on schools of any size.
    pub(super) fn is_same_page(&self, other: &Self) -> bool {
        self.page == other.page && self.seen_by == other.seen_by
    }
}

/// Writes the figures to a CSV file.
pub(super) fn write_figures(file: &Path, figures: &[PageFigures]) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_path(file).with_context(|| file.display().to_string())?;
    for figure in figures {
        writer.serialize(figure)?;
    }
    Ok(writer.flush()?)
}

/// Reads a CSV file of figures.
///
/// # Errors
/// When the file cannot be read or parsed, or contains no figures.
pub(super) fn read_figures(file: &Path) -> anyhow::Result<Vec<PageFigures>> {
    let place = || file.display().to_string();
    let mut reader = csv::Reader::from_path(file).with_context(place)?;
    let figures: Vec<PageFigures> = reader.deserialize().collect::<Result<_, _>>().with_context(place)?;
    ensure!(!figures.is_empty(), "{} holds no figures", place());
    Ok(figures)
}

/// Returns the factor by which the median grows when the number of attempts grows tenfold: the
/// power law fitted to all figures by least squares of the logarithms. `None` for fewer than two
/// sizes.
pub(super) fn growth_per_decade(figures: &[&PageFigures]) -> Option<f64> {
    let points: Vec<_> =
        figures.iter().map(|figure| (libm::log10(figure.attempts.into()), libm::log10(figure.p50_ms))).collect();
    let count = points.len() as f64;
    let (mean_x, mean_y) =
        (points.iter().map(|at| at.0).sum::<f64>() / count, points.iter().map(|at| at.1).sum::<f64>() / count);
    let spread: f64 = points.iter().map(|at| (at.0 - mean_x).powi(2)).sum();
    let common: f64 = points.iter().map(|at| (at.0 - mean_x) * (at.1 - mean_y)).sum();
    (spread > 0.0).then(|| libm::pow(10.0, common / spread))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(attempts: u32, p50_ms: f64) -> PageFigures {
        let (engine, page, seen_by) = ("SQLite 3".to_owned(), "/people".to_owned(), "administrator".to_owned());
        PageFigures { engine, attempts, page, seen_by, requests: 37, kilobytes: 1.5, p50_ms, p99_ms: 9.0 }
    }

    #[test]
    fn growth_is_that_of_the_power_law_the_times_follow() {
        let times = [figure(10_000, 3.0), figure(100_000, 6.0), figure(1_000_000, 12.0)];
        let grown = growth_per_decade(&times.iter().collect::<Vec<_>>()).unwrap();
        assert!((grown - 2.0).abs() < 1e-9, "{grown}");
        assert_eq!(growth_per_decade(&[&times[0]]), None, "one size says nothing of growth");
        assert_eq!(growth_per_decade(&[&times[0], &times[0]]), None);
    }

    #[test]
    fn figures_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("pages.csv");
        let figures = [figure(10_000, 3.25), figure(1_000_000, 12.5)];
        write_figures(&file, &figures).unwrap();
        assert_eq!(read_figures(&file).unwrap(), figures);
        std::fs::write(&file, "engine,attempts\nSQLite 3,many\n").unwrap();
        let refused = format!("{:#}", read_figures(&file).unwrap_err());
        assert!(refused.contains("pages.csv"), "{refused}");
    }
}
