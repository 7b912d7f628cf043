//! Distribution of a cohort's latest attempts at an exercise, by metric.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Summary;
use time::OffsetDateTime;

use crate::metric::{GROUPS, theme_of_metric};
use crate::{Shell, StatusWord, charts, format};

/// The page of a cohort's metrics.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/progress/metrics.html")]
pub struct MetricsPage {
    /// Page frame.
    pub shell: Shell,
    /// Name and address of the cohort.
    pub cohort: (String, String),
    /// Title and address of the exercise.
    pub exercise: (String, String),
    /// Distribution of the scores of the latest attempts, 0–100.
    pub scores: Option<Summary>,
    /// Metrics by theme, those of the rubric first.
    pub themes: Vec<SpreadTheme>,
    /// The attempts considered, by the trainee's name.
    pub scored: Vec<ScoredRow>,
}

/// Metrics of one theme over the latest attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadTheme {
    /// Heading.
    pub title: &'static str,
    /// Whether these are the metrics of the rubric, which are shown expanded.
    pub judged: bool,
    /// The metrics.
    pub rows: Vec<MetricSpreadRow>,
}

impl SpreadTheme {
    /// Sorts metrics, given with their ids, into those of the rubric and the themes of the others.
    #[must_use]
    pub fn sort_metrics(metrics: Vec<(String, MetricSpreadRow)>, judged: &[&str]) -> Vec<Self> {
        let mut themes = vec![Self { title: tr!("Metrics of the rubric"), judged: true, rows: Vec::new() }];
        themes.extend(GROUPS.map(|(title, _)| Self { title: words::say(title), judged: false, rows: Vec::new() }));
        for (id, row) in metrics {
            let theme = if judged.contains(&id.as_str()) { 0 } else { theme_of_metric(&id) + 1 };
            themes[theme].rows.push(row);
        }
        themes.retain(|theme| !theme.rows.is_empty());
        themes
    }
}

/// A metric over the latest attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricSpreadRow {
    /// Name.
    pub label: String,
    /// Unit.
    pub unit: String,
    /// Minimum, quartiles and maximum.
    pub five: Summary,
}

impl MetricSpreadRow {
    /// Draws the distribution on the metric's own scale.
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
    /// Address of the attempt's page.
    pub href: String,
    /// Start of the attempt.
    pub at: OffsetDateTime,
    /// Score, 0–100.
    pub score: f64,
    /// Whether it was passed.
    pub passed: bool,
}

#[cfg(test)]
mod tests {
    //! Medians and quartiles are shown with their unit and the attempts behind them, never a pooled
    //! mean.

    use crate::samples;
    use crate::training::progress::samples as made;

    #[test]
    fn a_metric_is_shown_by_its_quartiles() {
        let html = samples::keep_page("cohort-metrics", &made::metrics_page());
        for words in ["Peak force", "Median", "/sessions/", "metrics.csv"] {
            assert!(html.contains(words), "{words}: {html}");
        }
        let at = |words: &str| html.find(words).unwrap_or_else(|| panic!("{words}: {html}"));
        assert!(at("Depth error") < at("<details class=\"theme\""), "what is judged stands open");
        assert!(at("Peak force") > at("<details class=\"theme\""), "the rest is folded");
    }
}
