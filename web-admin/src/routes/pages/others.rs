//! What the metrics of an attempt are beside: those of the cohort's others, and the experts'.

use acts::error::Error;
use assessment::statistics::summary;
use model::corridor::FEWEST;
use model::{CurrentPerson, PersonKey};
use pages::judgement::{MetricSpread, OthersSpreads};
use store::scores::{self, MetricOfMany};
use store::sessions::Session;
use store::{experts, practice, schools};

use crate::AppState;

/// Most others of the cohort, and most experts: enough for quartiles, and cheap.
const MOST: u32 = 24;

/// The quartiles of each metric among others who tried the same exercise; none where they are fewer than five.
pub(super) async fn spreads_beside(
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
    let metrics = scores::metrics_of_many(reader, session.school_id, &asked).await?;
    Ok(OthersSpreads {
        cohort: metrics.iter().filter_map(|metric| spread_of(metric, |place| place < of_cohort)).collect(),
        experts: metrics.iter().filter_map(|metric| spread_of(metric, |place| place >= of_cohort)).collect(),
    })
}

fn spread_of(metric: &MetricOfMany, is_meant: impl Fn(usize) -> bool) -> Option<MetricSpread> {
    let meant = metric.found.iter().filter(|found| is_meant(found.0));
    let values: Vec<f64> = meant.filter_map(scores::FoundMetric::value).collect();
    if values.len() < FEWEST {
        return None;
    }
    let five = summary(&values).ok()?;
    let quartiles = [five.lower_quartile, five.median, five.upper_quartile];
    Some(MetricSpread { id: metric.id.clone(), version: metric.version, quartiles })
}
