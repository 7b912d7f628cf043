//! Internal consistency of scores, and agreement between people.

use assessment::questionnaire::Scorer;
use assessment::statistics;
use documents::Instrument;
use documents::instrument::ScoreKey;
use serde::Serialize;

use super::results::{ResponseRow, SurveyFigure};

/// An item in comparison with the others of its scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScaleItem {
    /// Id.
    pub id: String,
    /// Short name, or the question.
    pub name: String,
    /// Correlation with the sum of the other items.
    pub rest_correlation: SurveyFigure<f64>,
    /// α of the scale without this item.
    pub alpha_without: SurveyFigure<f64>,
}

/// Limitation of an α.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AlphaRemark {
    /// It is negative: items contradict each other.
    Negative,
    /// It is based on fewer than [`FEWEST_FOR_ALPHA`] responses.
    FewResponses,
}

/// Number of complete responses from which an α has no remark (Yurdugül 2008, "Minimum sample size
/// for Cronbach's coefficient alpha", Hacettepe Journal of Education 35, 397–405: 30 for scales
/// with high internal consistency).
pub const FEWEST_FOR_ALPHA: usize = 30;

/// Cronbach's α.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alpha {
    /// α.
    pub alpha: f64,
    /// Lower limit of the 95 % confidence interval.
    pub low: f64,
    /// Upper limit of the 95 % confidence interval.
    pub high: f64,
    /// Most serious limitation.
    pub remark: Option<AlphaRemark>,
    /// Number of items.
    pub items: usize,
    /// Number of complete responses.
    pub n: usize,
    /// Number of incomplete responses.
    pub missing: usize,
}

/// Intraclass correlations with items as objects and people as raters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RaterAgreement {
    /// ICC(2,1).
    pub icc_2_1: f64,
    /// ICC(2,k), if it can be computed.
    pub icc_2_k: Option<f64>,
    /// ICC(3,1).
    pub icc_3_1: f64,
    /// ICC(3,k).
    pub icc_3_k: f64,
    /// Number of items.
    pub items: usize,
    /// Number of people who answered all items.
    pub raters: usize,
    /// Number of people who did not.
    pub missing: usize,
}

/// Returns the value of each response for each item of a score.
fn counts_table(scorer: &Scorer<'_>, rows: &[&ResponseRow<'_>]) -> Vec<Vec<Option<f64>>> {
    rows.iter().map(|row| scorer.item_counts(row.answers)).collect()
}

/// Computes the item analysis of a score.
pub(super) fn scale_items(
    instrument: &Instrument,
    key: &ScoreKey,
    scorer: &Scorer<'_>,
    rows: &[&ResponseRow<'_>],
) -> SurveyFigure<Vec<ScaleItem>> {
    let name = |id: &String| {
        instrument
            .item(id)
            .map_or_else(|| id.clone(), |(_, item)| item.short().in_language(words::current().code()).to_owned())
    };
    SurveyFigure::of(statistics::item_analysis(&counts_table(scorer, rows)), |found| {
        let items = key.items.iter().zip(found);
        let scale_item = |(id, analysis): (&String, statistics::ItemAnalysis)| ScaleItem {
            id: id.clone(),
            name: name(id),
            rest_correlation: SurveyFigure::of(analysis.rest_correlation, |r| r),
            alpha_without: SurveyFigure::of(analysis.alpha_without, |alpha| alpha),
        };
        items.map(scale_item).collect()
    })
}

/// Computes Cronbach's α of a score.
pub(super) fn alpha_of(scorer: &Scorer<'_>, rows: &[&ResponseRow<'_>]) -> SurveyFigure<Alpha> {
    SurveyFigure::of(statistics::cronbach_alpha(&counts_table(scorer, rows)), |found| Alpha {
        alpha: found.alpha,
        low: found.low,
        high: found.high,
        remark: match (found.alpha, found.n) {
            (..0.0, _) => Some(AlphaRemark::Negative),
            (_, ..FEWEST_FOR_ALPHA) => Some(AlphaRemark::FewResponses),
            _ => None,
        },
        items: found.items,
        n: found.n,
        missing: found.missing,
    })
}

/// Computes the agreement of people about the items of a score.
pub(super) fn agreement_of_people(
    scorer: &Scorer<'_>,
    items: usize,
    rows: &[&ResponseRow<'_>],
) -> SurveyFigure<RaterAgreement> {
    let given = rows.iter().map(|row| scorer.item_counts(row.answers));
    let complete: Vec<Vec<Option<f64>>> = given.filter(|counts| counts.iter().all(Option::is_some)).collect();
    let by_item: Vec<Vec<Option<f64>>> =
        (0..items).map(|item| complete.iter().map(|counts| counts[item]).collect()).collect();
    SurveyFigure::of(statistics::intraclass_correlation(&by_item), |found| RaterAgreement {
        icc_2_1: found.single_random,
        icc_2_k: found.average_random,
        icc_3_1: found.single_fixed,
        icc_3_k: found.average_fixed,
        items: found.n,
        raters: found.raters,
        missing: rows.len() - complete.len(),
    })
}
