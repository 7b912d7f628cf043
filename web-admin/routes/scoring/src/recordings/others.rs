//! The metrics of others to compare an attempt with: the rest of the cohort, and the experts.

use std::collections::BTreeMap;

use acts::error::Error;
use assessment::statistics::summary;
use model::scoring::corridor::FEWEST;
use model::{CurrentPerson, PersonKey};
use pages::scoring::judgement::{MetricSpread, OthersSpreads};
use routes_base::AppState;
use store::operations::schools;
use store::privacy::experts;
use store::recordings::sessions::Session;
use store::scoring::scores;
use store::scoring::scores::ValueOfMany;
use store::training::practice;

/// Maximum number of others of the cohort, and of experts: enough for quartiles, and cheap.
const MOST: u32 = 24;

/// Returns the quartiles of each metric among others who attempted the same exercise; none for
/// fewer than five.
pub(crate) async fn spreads_beside(
    state: &AppState,
    viewer: &CurrentPerson,
    session: &Session,
) -> Result<OthersSpreads, Error> {
    let (reader, exercise) = (state.db.reader(), session.exercise_id.as_str());
    let whose = PersonKey { school_id: session.school_id, person_id: session.trainee_id };
    let mut asked = match schools::sees_others(reader, viewer).await? {
        true => practice::list_latest_of_others(reader, whose, exercise, MOST).await?,
        false => Vec::new(),
    };
    if asked.len() < FEWEST {
        asked.clear();
    }
    let of_cohort = asked.len();
    let expert = experts::list_expert_attempts(reader, whose, exercise, MOST).await?;
    if expert.len() >= FEWEST {
        asked.extend(expert);
    }
    if asked.is_empty() {
        return Ok(OthersSpreads::default());
    }
    let mut values: BTreeMap<(String, u32), ValuesBeside> = BTreeMap::new();
    for ValueOfMany(place, id, version, value) in scores::list_values_of_many(reader, session.school_id, &asked).await?
    {
        let beside = values.entry((id, version)).or_default();
        if place < of_cohort { beside.cohort.push(value) } else { beside.experts.push(value) }
    }
    let mut spreads = OthersSpreads::default();
    for ((id, version), beside) in &values {
        let spread = |quartiles| MetricSpread { id: id.clone(), version: *version, quartiles };
        spreads.cohort.extend(quartiles_of(&beside.cohort).map(spread));
        spreads.experts.extend(quartiles_of(&beside.experts).map(spread));
    }
    Ok(spreads)
}

/// Values of a metric in the attempts of others, in its unit.
#[derive(Default)]
struct ValuesBeside {
    cohort: Vec<f64>,
    experts: Vec<f64>,
}

fn quartiles_of(values: &[f64]) -> Option<[f64; 3]> {
    if values.len() < FEWEST {
        return None;
    }
    let five = summary(values).ok()?;
    Some([five.lower_quartile, five.median, five.upper_quartile])
}
