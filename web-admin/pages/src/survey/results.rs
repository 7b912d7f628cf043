//! Results of a survey: every picture is a table, too.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::survey::Identity;
use model::survey::results::{
    ConfidenceInterval, FEWEST_FOR_ALPHA, ItemGroup, ItemResult, Results, ScoreGroup, ScoreResult, SurveyFigure,
};

use super::figures;
use crate::charts::{BoxRow, Extent, LikertBar, LikertItem};
use crate::{Shell, charts, format};

/// The results of a survey.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/results.html")]
pub struct ResultsPage {
    /// Frame.
    pub shell: Shell,
    /// The survey's title and page.
    pub survey: (String, String),
    /// The instrument's title.
    pub instrument: String,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// The answers were made by a program.
    pub generated: bool,
    /// The visitor owns the survey: nothing is hidden.
    pub owner: bool,
    /// Who was asked, and how many answered.
    pub asked: Vec<AskedLine>,
    /// What was found.
    pub results: Results,
    /// Scores split by something else than the role.
    pub split: SplitScores,
    /// Scores against a figure of the attempts.
    pub against: ScatteredScores,
    /// Comments.
    pub comments: Vec<CommentBlock>,
    /// Every theme, and how often.
    pub tags: Vec<(String, usize)>,
}

/// Who was asked, and how many answered.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedLine {
    /// Who.
    pub who: &'static str,
    /// How many were asked.
    pub asked: i64,
    /// How many answered.
    pub answered: i64,
}

impl AskedLine {
    /// The share that answered, in words.
    #[must_use]
    pub fn rate(&self) -> String {
        if self.asked == 0 {
            return "–".to_owned();
        }
        format::format_percent(self.answered as f64 / self.asked as f64)
    }
}

/// Scores split by something else than the role.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitScores {
    /// Word and title of what can be split by, and whether it is.
    pub ways: Vec<(&'static str, &'static str, bool)>,
    /// The scores.
    pub scores: Vec<SplitScore>,
    /// Answers in groups that are hidden.
    pub hidden: usize,
}

/// A score by groups.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitScore {
    /// Title.
    pub title: String,
    /// Least and greatest that it can be.
    pub range: Extent,
    /// The groups.
    pub groups: Vec<ScoreGroup>,
}

/// A score against another figure.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatteredScore {
    /// Title of the score.
    pub title: String,
    /// The figure and the score of each response; none where too few are to be shown.
    pub points: Vec<(f64, f64)>,
    /// Spearman's ρ.
    pub rho: SurveyFigure<ConfidenceInterval>,
}

/// Scores against a figure of the attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatteredScores {
    /// Word and title of each figure, and whether it is chosen.
    pub metrics: Vec<(&'static str, &'static str, bool)>,
    /// Each score; points only where there are enough to show.
    pub scores: Vec<ScatteredScore>,
}

/// The comments to an item.
#[derive(Clone, Debug, PartialEq)]
pub struct CommentBlock {
    /// The item's id.
    pub item: String,
    /// The question.
    pub text: String,
    /// The comments; none where they are hidden.
    pub comments: Option<Vec<SurveyComment>>,
}

/// A comment.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyComment {
    /// The response.
    pub response: String,
    /// Who, as the survey allows.
    pub who: String,
    /// As it was typed.
    pub text: String,
    /// Its themes.
    pub tags: Vec<String>,
}

/// Items of a section that share their points, drawn together.
#[derive(Clone, Debug, PartialEq)]
pub struct ItemBlock<'a> {
    /// The section's heading.
    pub heading: &'a str,
    /// The picture, where there is one.
    pub drawing: String,
    /// The items.
    pub items: Vec<&'a ItemResult>,
}

impl ItemBlock<'_> {
    /// Class and words of each point, where the picture has points.
    #[must_use]
    pub fn legend(&self) -> Vec<(&'static str, &str)> {
        let labels = match self.items.first() {
            Some(item) if item.kind == "likert" => item.labels.as_slice(),
            _ => &[],
        };
        labels
            .iter()
            .enumerate()
            .map(|(at, label)| (charts::class_of_point(at, labels.len()), label.as_str()))
            .collect()
    }

    /// Whether any of its items is judged for content.
    #[must_use]
    pub fn is_judged_for_content(&self) -> bool {
        self.items.iter().any(|item| !item.content_validity.is_empty())
    }
}

impl ResultsPage {
    /// Items by section and by points.
    #[must_use]
    pub fn blocks(&self) -> Vec<ItemBlock<'_>> {
        let alike = |a: &ItemResult, b: &ItemResult| (&a.section, a.kind, &a.labels) == (&b.section, b.kind, &b.labels);
        self.results.items.chunk_by(alike).enumerate().map(|(at, items)| make_item_block(at, items)).collect()
    }

    /// The scores of the groups as boxes.
    #[must_use]
    pub fn score_boxes(&self, score: &ScoreResult) -> String {
        let key = format!("score-{}", score.id);
        let (least, greatest) = score.range;
        draw_score_boxes(&score.groups, Extent::new(least, greatest), &key, &score.title)
    }

    /// Whether an α rests on so few responses that its interval says more than itself.
    #[must_use]
    pub fn has_alpha_of_few(&self) -> bool {
        let mut alphas =
            self.results.scores.iter().flat_map(|score| &score.alpha).filter_map(|(_, alpha)| alpha.value());
        alphas.any(|alpha| alpha.n < FEWEST_FOR_ALPHA)
    }

    /// The scores of another split as boxes.
    #[must_use]
    pub fn split_boxes(&self, score: &SplitScore, at: impl Borrow<usize>) -> String {
        draw_score_boxes(&score.groups, score.range, &format!("split-{}", at.borrow()), &score.title)
    }

    /// Scores against the chosen figure as points.
    #[must_use]
    pub fn points(&self, score: &ScatteredScore, at: impl Borrow<usize>) -> String {
        let metric = self.against.metrics.iter().find(|(.., chosen)| *chosen).map_or("", |(_, title, _)| title);
        let key = format!("against-{}", at.borrow());
        charts::draw_both_widths(|size| charts::draw_scatter(&score.points, metric, &score.title, &key, size))
    }
}

fn make_item_block(at: usize, items: &[ItemResult]) -> ItemBlock<'_> {
    let key = format!("items-{at}");
    let heading = items.first().map_or("", |item| item.section.as_str());
    let drawing = match items.first().map(|item| item.kind) {
        Some("likert") => draw_likert_items(items, &key, heading),
        Some("slider") => draw_profile(items, &key, heading),
        _ => String::new(),
    };
    ItemBlock { heading, drawing, items: items.iter().collect() }
}

fn draw_likert_items(items: &[ItemResult], key: &str, title: &str) -> String {
    let bars =
        |item: &ItemResult| LikertItem { text: item.text.clone(), bars: item.groups.iter().map(likert_bar).collect() };
    let rows: Vec<LikertItem> = items.iter().map(bars).filter(|item| !item.bars.is_empty()).collect();
    if rows.is_empty() {
        String::new()
    } else {
        charts::draw_both_widths(|size| charts::draw_diverging_bars(&rows, key, title, size))
    }
}

fn likert_bar(group: &ItemGroup) -> LikertBar {
    LikertBar { label: format!("{} ({})", words::known(&group.group), group.n), counts: group.counts.clone() }
}

/// Sliders side by side: the profile of a workload.
fn draw_profile(items: &[ItemResult], key: &str, title: &str) -> String {
    let mut rows = Vec::new();
    let mut range = Extent::new(0.0, 100.0);
    for (item, group) in items.iter().flat_map(|item| item.groups.iter().map(move |group| (item, group))) {
        let quartiles = group.quartiles.value().map(|q| (q.lower, q.median, q.upper));
        if let Some((lower, _, upper)) = quartiles {
            range = Extent::new(range.from.min(lower), range.to.max(upper));
        }
        rows.push(BoxRow {
            label: format!("{} · {} ({})", item.name, words::known(&group.group), group.n),
            quartiles,
            ends: None,
            mean: None,
        });
    }
    if rows.is_empty() {
        return String::new();
    }
    charts::draw_both_widths(|size| charts::draw_boxes(&rows, range, key, title, size))
}

fn draw_score_boxes(groups: &[ScoreGroup], range: Extent, key: &str, title: &str) -> String {
    let row = |group: &ScoreGroup| BoxRow {
        label: format!("{} ({})", words::known(&group.group), group.n),
        quartiles: group.quartiles.value().map(|q| (q.lower, q.median, q.upper)),
        ends: None,
        mean: group.mean.value().map(|m| (m.value, m.low, m.high)),
    };
    let rows: Vec<BoxRow> = groups.iter().map(row).collect();
    if rows.is_empty() {
        String::new()
    } else {
        charts::draw_both_widths(|size| charts::draw_boxes(&rows, range, key, title, size))
    }
}
