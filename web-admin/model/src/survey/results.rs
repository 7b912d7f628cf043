//! What a survey found: distributions, scores, reliability, agreement and content validity, group by group.
//!
//! Answers of different roles are never pooled into one mean. Only what measures the instrument itself (α, agreement,
//! content validity) is computed over all groups, too.

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

/// A response, as it is analysed.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRow<'a> {
    /// The response: random, and all that is known of an anonymous one.
    pub id: ResponseId,
    /// `professional`, or the person's role.
    pub role: &'a str,
    /// The attempt's exercise, device and simulator.
    pub attempt: [Option<&'a str>; 3],
    /// Year and month in which it was sent.
    pub month: String,
    /// In the order of the instrument's items.
    pub answers: &'a [Option<Answer>],
    /// In the order of the instrument's scores.
    pub scores: Vec<Option<f64>>,
}

impl ResponseRow<'_> {
    fn number_at(&self, item: usize) -> Option<f64> {
        self.answers.get(item)?.as_ref()?.number()
    }
}

/// A figure, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SurveyFigure<T> {
    /// It.
    Value(T),
    /// Why there is none.
    None {
        /// In words.
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

    /// The figure, where there is one.
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

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConfidenceInterval {
    /// The value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How many it rests on.
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

/// The group of those who judge content: whoever knows the procedure (Lynn 1986; Polit and Beck 2006).
pub const EXPERTS: &str = "experts";

/// The roles that make it up.
const EXPERT_ROLES: [&str; 3] = ["expert", "professional", "instructor"];

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Results {
    /// Roles and how many answered.
    pub groups: Vec<(String, usize)>,
    /// Answers in groups that are hidden.
    pub hidden: usize,
    /// Every item but texts.
    pub items: Vec<ItemResult>,
    /// Every score.
    pub scores: Vec<ScoreResult>,
    /// Mean of the items' content validity (S-CVI/Ave): of the experts alone, then of every other group; empty where no item is
    /// judged for it.
    pub scale_content_validity: Vec<GroupValidity>,
}

/// How an item was answered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemResult {
    /// Its id.
    pub id: String,
    /// Its short name, or the question.
    pub name: String,
    /// The question.
    pub text: String,
    /// How it is answered.
    pub kind: &'static str,
    /// Its section's heading.
    pub section: String,
    /// What can be answered, where that is a list.
    pub labels: Vec<String>,
    /// Role by role.
    pub groups: Vec<ItemGroup>,
    /// Share that calls it relevant (I-CVI): of the experts alone, then of every other group; empty where it is not judged for it.
    pub content_validity: Vec<GroupValidity>,
}

/// Content validity as a group judged it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupValidity {
    /// [`EXPERTS`], or the role.
    pub group: String,
    /// The share with Wilson's interval; of a whole instrument the mean of its shares, without one.
    pub validity: SurveyFigure<ConfidenceInterval>,
}

/// How a group answered an item.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemGroup {
    /// The role.
    pub group: String,
    /// Answers.
    pub n: usize,
    /// People who left it out.
    pub missing: usize,
    /// How often each label was given.
    pub counts: Vec<usize>,
    /// Of answers that are numbers.
    pub quartiles: SurveyFigure<Quartiles>,
}

/// How a score came out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreResult {
    /// Its id.
    pub id: String,
    /// Its title.
    pub title: String,
    /// The least and the largest it can be.
    pub range: (f64, f64),
    /// Role by role.
    pub groups: Vec<ScoreGroup>,
    /// Cronbach's α: of each role, then of all.
    pub alpha: Vec<(String, SurveyFigure<Alpha>)>,
    /// What each item does to the scale, over all shown.
    pub scale_items: SurveyFigure<Vec<ScaleItem>>,
    /// Agreement of all who answered every item about the items.
    pub agreement: SurveyFigure<RaterAgreement>,
}

/// The scores of a group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreGroup {
    /// The role, or what else the group is.
    pub group: String,
    /// Scores.
    pub n: usize,
    /// Responses without a score.
    pub without: usize,
    /// Mean with its interval.
    pub mean: SurveyFigure<ConfidenceInterval>,
    /// Median and quartiles.
    pub quartiles: SurveyFigure<Quartiles>,
}

impl Results {
    /// What the rows of a survey say, small groups hidden unless the reader may see the whole.
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

/// What can be answered, where that is a list: id and label.
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

/// The item's distribution; none for a text.
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
                // Points count from 1; what is no list has no counts.
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

/// Ratings as the index counts them: 4 for relevant, 1 for not.
fn ratings(rows: &[&ResponseRow<'_>], at: usize, from: f64) -> Vec<Option<u8>> {
    rows.iter().map(|row| row.number_at(at).map(|number| if number >= from { 4 } else { 1 })).collect()
}

/// A share with Wilson's interval.
fn interval_of_share(share: f64, n: usize) -> ConfidenceInterval {
    let relevant = (share * n as f64).round() as usize;
    match statistics::wilson(relevant, n) {
        Ok(estimate) => ConfidenceInterval { value: share, ..estimate.into() },
        Err(_) => ConfidenceInterval { value: share, low: share, high: share, n },
    }
}

/// A figure of the experts alone, and of every other group for itself.
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
        // A mean of shares: it has no interval of its own.
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

/// The scores of a group, by the place of the score in the instrument.
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

/// Spearman's ρ of scores with a figure of the attempts behind them.
#[must_use]
pub fn correlation(pairs: &[(f64, f64)]) -> SurveyFigure<ConfidenceInterval> {
    SurveyFigure::of(statistics::rank_correlation(pairs), ConfidenceInterval::from)
}
