//! How a cohort's latest attempts at an exercise are distributed, metric by metric.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Summary;
use time::OffsetDateTime;

use crate::{Shell, StatusWord, charts, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "progress/metrics.html")]
pub struct MetricsPage {
    /// Frame.
    pub shell: Shell,
    /// The cohort's name and page.
    pub cohort: (String, String),
    /// The exercise's title and page.
    pub exercise: (String, String),
    /// Scores of the latest attempts, 0–100.
    pub scores: Option<Summary>,
    /// Each metric.
    pub metrics: Vec<MetricSpreadRow>,
    /// The attempts it is made of, by the trainee's name.
    pub scored: Vec<ScoredRow>,
}

/// A metric over the latest attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricSpreadRow {
    /// Name in words.
    pub label: String,
    /// Unit.
    pub unit: String,
    /// Least, quartiles, greatest.
    pub five: Summary,
}

impl MetricSpreadRow {
    /// The box, on the metric's own scale.
    #[must_use]
    pub fn drawing(&self) -> String {
        charts::draw_spread(&self.five, charts::Extent::new(self.five.min, self.five.max))
    }
}

/// A trainee's scored attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredRow {
    /// Name.
    pub name: String,
    /// Title of the exercise.
    pub exercise: String,
    /// The attempt's page.
    pub href: String,
    /// When it began.
    pub at: OffsetDateTime,
    /// 0–100.
    pub score: f64,
    /// Passed.
    pub passed: bool,
}

#[cfg(test)]
mod tests {
    //! Medians and quartiles with their unit, never one pooled mean, and the attempts behind them.

    use crate::progress::samples as made;
    use crate::samples;

    #[test]
    fn a_metric_is_shown_by_its_quartiles() {
        let html = samples::keep_page("cohort-metrics", &made::metrics_page());
        for words in ["Peak force", "Median", "/sessions/", "metrics.csv"] {
            assert!(html.contains(words), "{words}: {html}");
        }
    }
}
