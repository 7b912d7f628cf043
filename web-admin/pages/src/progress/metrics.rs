//! How a cohort's latest attempts at an exercise are distributed, metric by metric.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Summary;
use time::OffsetDateTime;

use crate::judgement::{GROUPS, theme_of_metric};
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
    /// Metrics by theme; those that the rubric judges first.
    pub themes: Vec<SpreadTheme>,
    /// The attempts it is made of, by the trainee's name.
    pub scored: Vec<ScoredRow>,
}

/// Metrics of one theme over the latest attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadTheme {
    /// Heading.
    pub title: &'static str,
    /// What the rubric judges stands open.
    pub judged: bool,
    /// The metrics.
    pub rows: Vec<MetricSpreadRow>,
}

impl SpreadTheme {
    /// Sorts metrics, each with its id, into the judged ones and the themes of the others.
    #[must_use]
    pub fn sort_metrics(metrics: Vec<(String, MetricSpreadRow)>, judged: &[&str]) -> Vec<Self> {
        let mut themes = vec![Self { title: tr!("What the rubric judges"), judged: true, rows: Vec::new() }];
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
        let at = |words: &str| html.find(words).unwrap_or_else(|| panic!("{words}: {html}"));
        assert!(at("Depth error") < at("<details class=\"theme\""), "what is judged stands open");
        assert!(at("Peak force") > at("<details class=\"theme\""), "the rest is folded");
    }
}
