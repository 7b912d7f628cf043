//! Results of a survey: distributions, scores, reliability, agreement and content validity, by
//! group.
//!
//! Answers of different roles are never pooled into one mean. Only properties of the instrument
//! itself (α, agreement, content validity) are also computed over all groups.

use assessment::questionnaire::{self, Answer, Scorer};
use assessment::statistics::{self, NotComputable};
use documents::Instrument;
use documents::instrument::{Item, ScaleKind, ScoreKey};
use phrase::Phrase;
use serde::Serialize;

use super::groups::ResponseGroups;
use super::scales;
pub use super::scales::{Alpha, AlphaRemark, FEWEST_FOR_ALPHA, RaterAgreement, ScaleItem};
use crate::ids::ResponseId;

/// A response for the analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRow<'a> {
    /// Random id of the response, the only identification of an anonymous one.
    pub id: ResponseId,
    /// `professional`, or the person's role.
    pub role: &'a str,
    /// Exercise, device and simulator version of the attempt.
    pub attempt: [Option<&'a str>; 3],
    /// Year and month of the submission.
    pub month: String,
    /// Answers, in the order of the instrument's items.
    pub answers: &'a [Option<Answer>],
    /// Scores, in the order of the instrument's scores.
    pub scores: Vec<Option<f64>>,
}

impl ResponseRow<'_> {
    fn number_at(&self, item: usize) -> Option<f64> {
        self.answers.get(item)?.as_ref()?.number()
    }
}

/// A figure, or the reason why it cannot be computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SurveyFigure<T> {
    /// The figure.
    Value(T),
    /// It cannot be computed.
    None {
        /// Reason, as text.
        not_computable: Phrase,
    },
}

impl<T> SurveyFigure<T> {
    pub(super) fn of<U>(found: Result<U, NotComputable>, take: impl FnOnce(U) -> T) -> Self {
        match found {
            Ok(value) => Self::Value(take(value)),
            Err(why) => Self::None { not_computable: why.in_words() },
        }
    }

    /// Returns the figure, if there is one.
    #[must_use]
    pub const fn value(&self) -> Option<&T> {
        match self {
            Self::Value(value) => Some(value),
            Self::None { .. } => None,
        }
    }
}

/// Median and quartiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quartiles {
    /// Lower quartile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// Upper quartile.
    pub upper: f64,
}

/// A value with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConfidenceInterval {
    /// Value.
    pub value: f64,
    /// Lower limit.
    pub low: f64,
    /// Upper limit.
    pub high: f64,
    /// Number of observations.
    pub n: usize,
}

impl From<statistics::Estimate> for ConfidenceInterval {
    fn from(e: statistics::Estimate) -> Self {
        Self { value: e.value, low: e.low, high: e.high, n: e.n }
    }
}

fn quartiles(values: &[f64]) -> SurveyFigure<Quartiles> {
    SurveyFigure::of(statistics::summary(values), |s| Quartiles {
        lower: s.lower_quartile,
        median: s.median,
        upper: s.upper_quartile,
    })
}

/// Name of the group that judges content validity: people who know the procedure (Lynn 1986; Polit
/// and Beck 2006).
pub const EXPERTS: &str = "experts";

/// Roles in this group.
const EXPERT_ROLES: [&str; 3] = ["expert", "professional", "instructor"];

/// Results of a survey.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Results {
    /// Roles and numbers of responses.
    pub groups: Vec<(String, usize)>,
    /// Number of responses in hidden groups.
    pub hidden: usize,
    /// All items except texts.
    pub items: Vec<ItemResult>,
    /// All scores.
    pub scores: Vec<ScoreResult>,
    /// Mean content validity of the items (S-CVI/Ave): first of the experts alone, then of each
    /// other group. Empty if no item is rated for relevance.
    pub scale_content_validity: Vec<GroupValidity>,
}

/// Results of an item.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemResult {
    /// Id.
    pub id: String,
    /// Short name, or the question.
    pub name: String,
    /// The question.
    pub text: String,
    /// Kind of scale.
    pub kind: &'static str,
    /// Heading of its section.
    pub section: String,
    /// Possible answers, if they are a list.
    pub labels: Vec<String>,
    /// Results by role.
    pub groups: Vec<ItemGroup>,
    /// Proportion that rates it relevant (I-CVI): first of the experts alone, then of each other
    /// group. Empty if it is not rated for relevance.
    pub content_validity: Vec<GroupValidity>,
}

/// Content validity as judged by one group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupValidity {
    /// [`EXPERTS`], or the role.
    pub group: String,
    /// Proportion with Wilson's interval; for a whole instrument the mean proportion, without
    /// interval.
    pub validity: SurveyFigure<ConfidenceInterval>,
}

/// Answers of a group to an item.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemGroup {
    /// Role.
    pub group: String,
    /// Number of answers.
    pub n: usize,
    /// Number of responses without an answer.
    pub missing: usize,
    /// Count of each possible answer.
    pub counts: Vec<usize>,
    /// Quartiles of numeric answers.
    pub quartiles: SurveyFigure<Quartiles>,
}

/// Results of a score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreResult {
    /// Id.
    pub id: String,
    /// Title.
    pub title: String,
    /// Smallest and largest possible value.
    pub range: (f64, f64),
    /// Results by role.
    pub groups: Vec<ScoreGroup>,
    /// Cronbach's α of each role, then of all.
    pub alpha: Vec<(String, SurveyFigure<Alpha>)>,
    /// Item analysis, over all shown responses.
    pub scale_items: SurveyFigure<Vec<ScaleItem>>,
    /// Agreement about the items between all people who answered every item.
    pub agreement: SurveyFigure<RaterAgreement>,
}

/// Scores of a group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreGroup {
    /// Role, or name of another group.
    pub group: String,
    /// Number of scores.
    pub n: usize,
    /// Number of responses without a score.
    pub without: usize,
    /// Mean with its confidence interval.
    pub mean: SurveyFigure<ConfidenceInterval>,
    /// Median and quartiles.
    pub quartiles: SurveyFigure<Quartiles>,
}

impl Results {
    /// Computes the results of a survey. Small groups are hidden unless the reader may see
    /// everything.
    #[must_use]
    pub fn new(instrument: &Instrument, rows: &[&ResponseRow<'_>], whole: bool) -> Self {
        let groups = ResponseGroups::new(rows, |row: &ResponseRow<'_>| Some(row.role.to_owned()), whole);
        let pages = instrument.pages();
        let headed = pages.iter().flat_map(|(section, items)| items.iter().map(move |at| (*section, *at)));
        let items: Vec<ItemResult> = headed
            .filter_map(|(section, at)| {
                let heading = section.map_or("", |section| section.title.in_language(words::current().code()));
                item(instrument, at, heading, &groups)
            })
            .collect();
        Self {
            groups: groups.shown.iter().map(|(name, rows)| (name.clone(), rows.len())).collect(),
            hidden: groups.hidden,
            scale_content_validity: scale_content_validity(instrument, &groups),
            scores: instrument.scores.iter().enumerate().map(|(at, key)| score(instrument, at, key, &groups)).collect(),
            items,
        }
    }
}

/// Returns the possible answers, if they are a list: id and label.
#[must_use]
pub fn answers_of(instrument: &Instrument, item: &Item) -> Vec<(String, String)> {
    match instrument.scale(item) {
        Some(ScaleKind::Likert { points, labels, first, last, .. }) => (1..=*points)
            .zip(labels.iter().map(Some).chain(std::iter::repeat(None)))
            .map(|(point, label)| {
                let end = || first.as_ref().filter(|_| point == 1).or(last.as_ref().filter(|_| point == *points));
                let words = label.or_else(end).map(|words| words.in_language(words::current().code()));
                (point.to_string(), words.map_or_else(|| point.to_string(), |words| format!("{point} {words}")))
            })
            .collect(),
        Some(ScaleKind::Pair) => {
            let named = |id: &String| {
                instrument
                    .item(id)
                    .map(|(_, item)| (id.clone(), item.short().in_language(words::current().code()).to_owned()))
            };
            item.pair.iter().filter_map(named).collect()
        }
        Some(scale) => scale
            .options()
            .iter()
            .map(|o| (o.id.clone(), o.text.in_language(words::current().code()).to_owned()))
            .collect(),
        None => Vec::new(),
    }
}

/// Returns the distribution of an item; `None` for a text.
fn item(
    instrument: &Instrument,
    at: usize,
    section: &str,
    groups: &ResponseGroups<'_, ResponseRow<'_>>,
) -> Option<ItemResult> {
    let item = &instrument.items[at];
    let scale = instrument.scale(item)?;
    if matches!(scale, ScaleKind::Text { .. }) {
        return None;
    }
    let answers = answers_of(instrument, item);
    let ids: Vec<&str> = answers.iter().map(|(id, _)| id.as_str()).collect();
    Some(ItemResult {
        id: item.id.clone(),
        name: item.short().in_language(words::current().code()).to_owned(),
        text: item.text.in_language(words::current().code()).to_owned(),
        kind: scale.word(),
        section: section.to_owned(),
        groups: groups.shown.iter().map(|(name, rows)| item_group(name, rows, at, &ids)).collect(),
        content_validity: relevant_from(scale).map_or_else(Vec::new, |from| {
            validity_by_group(groups, |rows| {
                let found = statistics::content_validity(&ratings(rows, at, from));
                SurveyFigure::of(found, |found| interval_of_share(found.value, found.n))
            })
        }),
        labels: answers.into_iter().map(|(_, label)| label).collect(),
    })
}

fn item_group(name: &str, rows: &[&ResponseRow<'_>], at: usize, ids: &[&str]) -> ItemGroup {
    let mut counts = vec![0; ids.len()];
    let mut numbers = Vec::new();
    let mut n = 0;
    for answer in rows.iter().filter_map(|row| row.answers.get(at)?.as_ref()) {
        n += 1;
        match answer {
            Answer::Number(number) => {
                numbers.push(*number);
                // Points count from 1; scales without a list of answers have no counts.
                if let Some(count) = counts.get_mut((*number as usize).wrapping_sub(1)) {
                    *count += 1;
                }
            }
            Answer::Text(id) => count(&mut counts, ids, id),
            Answer::Several(chosen) => chosen.iter().for_each(|id| count(&mut counts, ids, id)),
        }
    }
    ItemGroup { group: name.to_owned(), n, missing: rows.len() - n, counts, quartiles: quartiles(&numbers) }
}

fn count(counts: &mut [usize], ids: &[&str], id: &str) {
    if let Some(at) = ids.iter().position(|known| *known == id) {
        counts[at] += 1;
    }
}

fn relevant_from(scale: &ScaleKind) -> Option<f64> {
    match scale {
        ScaleKind::Likert { relevant_from, .. } => relevant_from.map(f64::from),
        _ => None,
    }
}

/// Returns ratings in the form expected by the index: 4 for relevant, 1 for not relevant.
fn ratings(rows: &[&ResponseRow<'_>], at: usize, from: f64) -> Vec<Option<u8>> {
    rows.iter().map(|row| row.number_at(at).map(|number| if number >= from { 4 } else { 1 })).collect()
}

/// Returns a proportion with Wilson's interval.
fn interval_of_share(share: f64, n: usize) -> ConfidenceInterval {
    let relevant = (share * n as f64).round() as usize;
    match statistics::wilson(relevant, n) {
        Ok(estimate) => ConfidenceInterval { value: share, ..estimate.into() },
        Err(_) => ConfidenceInterval { value: share, low: share, high: share, n },
    }
}

/// Returns a figure of the experts alone, and of each other group.
fn validity_by_group(
    groups: &ResponseGroups<'_, ResponseRow<'_>>,
    validity: impl Fn(&[&ResponseRow<'_>]) -> SurveyFigure<ConfidenceInterval>,
) -> Vec<GroupValidity> {
    let all = groups.all();
    let experts: Vec<_> = all.into_iter().filter(|row| EXPERT_ROLES.contains(&row.role)).collect();
    let others = groups.shown.iter().filter(|(name, _)| !EXPERT_ROLES.contains(&name.as_str()));
    let first = (!experts.is_empty()).then_some((EXPERTS, experts.as_slice()));
    first
        .into_iter()
        .chain(others.map(|(name, rows)| (name.as_str(), rows.as_slice())))
        .map(|(name, rows)| GroupValidity { group: name.to_owned(), validity: validity(rows) })
        .collect()
}

fn scale_content_validity(instrument: &Instrument, groups: &ResponseGroups<'_, ResponseRow<'_>>) -> Vec<GroupValidity> {
    let items = instrument.items.iter().enumerate();
    let judged: Vec<(usize, f64)> =
        items.filter_map(|(at, item)| Some((at, relevant_from(instrument.scale(item)?)?))).collect();
    if judged.is_empty() {
        return Vec::new();
    }
    validity_by_group(groups, |rows| {
        let items: Vec<Vec<Option<u8>>> = judged.iter().map(|(at, from)| ratings(rows, *at, *from)).collect();
        // A mean of proportions has no interval of its own.
        SurveyFigure::of(statistics::scale_content_validity(&items), |found| ConfidenceInterval {
            value: found.value,
            low: found.value,
            high: found.value,
            n: found.n,
        })
    })
}

fn score(
    instrument: &Instrument,
    at: usize,
    key: &ScoreKey,
    groups: &ResponseGroups<'_, ResponseRow<'_>>,
) -> ScoreResult {
    let (all, scorer) = (groups.all(), Scorer::new(instrument, key));
    let mut alpha: Vec<(String, SurveyFigure<Alpha>)> =
        groups.shown.iter().map(|(name, rows)| (name.clone(), scales::alpha_of(&scorer, rows))).collect();
    if groups.shown.len() != 1 {
        alpha.push(("all".to_owned(), scales::alpha_of(&scorer, &all)));
    }
    ScoreResult {
        id: key.id.clone(),
        title: key.title.in_language(words::current().code()).to_owned(),
        range: questionnaire::score_range(instrument, key),
        groups: groups.shown.iter().map(|(name, rows)| score_group(name, rows, at)).collect(),
        alpha,
        scale_items: scales::scale_items(instrument, key, &scorer, &all),
        agreement: scales::agreement_of_people(&scorer, key.items.len(), &all),
    }
}

/// Returns the scores of a group, by the index of the score in the instrument.
#[must_use]
pub fn score_group(name: &str, rows: &[&ResponseRow<'_>], at: usize) -> ScoreGroup {
    let values: Vec<f64> = rows.iter().filter_map(|row| row.scores[at]).collect();
    ScoreGroup {
        group: name.to_owned(),
        n: values.len(),
        without: rows.len() - values.len(),
        mean: SurveyFigure::of(statistics::mean(&values), ConfidenceInterval::from),
        quartiles: quartiles(&values),
    }
}

/// Returns Spearman's ρ between scores and a metric of their attempts.
#[must_use]
pub fn correlation(pairs: &[(f64, f64)]) -> SurveyFigure<ConfidenceInterval> {
    SurveyFigure::of(statistics::rank_correlation(pairs), ConfidenceInterval::from)
}
