//! Scores: the instrument's key, carried out.

use scene::instrument::{Combine, Instrument, Missing, ScoreKey};

use super::Answer;

/// Why there is no score.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoScore {
    /// Items without an answer, by id; the key does without none, or not without so many.
    #[error("no answer to {}", .0.join(", "))]
    Missing(Vec<String>),
}

/// What an item counts: its answer, reversed where the key says so, and shifted.
fn counts(instrument: &Instrument, key: &ScoreKey, id: &str, answers: &[Option<Answer>]) -> Option<f64> {
    let (at, item) = instrument.item(id)?;
    let answer = answers.get(at)?.as_ref()?.number()?;
    let (least, largest) = instrument.scale(item)?.range()?;
    let turned = if key.reversed.iter().any(|reversed| reversed == id) { least + largest - answer } else { answer };
    Some(turned + key.shift)
}

/// What each item of a score counts, in the order of the key: reversed where it says so, and shifted.
#[must_use]
pub fn item_counts(instrument: &Instrument, key: &ScoreKey, answers: &[Option<Answer>]) -> Vec<Option<f64>> {
    key.items.iter().map(|id| counts(instrument, key, id, answers)).collect()
}

/// A score of a response by its key, in the key's own unit.
///
/// # Errors
/// When an item is missing and the key's policy does not do without it.
pub fn score(instrument: &Instrument, key: &ScoreKey, answers: &[Option<Answer>]) -> Result<f64, NoScore> {
    let counted = item_counts(instrument, key, answers);
    let answered: Vec<f64> = counted.iter().flatten().copied().collect();
    let enough = match key.missing {
        Missing::NoScore => answered.len() == counted.len(),
        Missing::MeanOfAnswered => answered.len() >= key.least_answered.unwrap_or(counted.len()).max(1),
    };
    if !enough {
        let missing = key.items.iter().zip(&counted).filter(|(_, counts)| counts.is_none());
        return Err(NoScore::Missing(missing.map(|(id, _)| id.clone()).collect()));
    }
    let mean = answered.iter().sum::<f64>() / answered.len() as f64;
    let combined = match key.combine {
        Combine::Mean => mean,
        Combine::Sum => mean * counted.len() as f64,
        Combine::PairWeighted => pair_weighted(instrument, key, &answered, answers)?,
    };
    Ok(combined * key.factor + key.offset)
}

/// Σ w r / Σ w, where an item's weight is how often the pairs chose it.
fn pair_weighted(
    instrument: &Instrument,
    key: &ScoreKey,
    counted: &[f64],
    answers: &[Option<Answer>],
) -> Result<f64, NoScore> {
    let chosen = |pair: &String| match instrument.item(pair).and_then(|(at, _)| answers.get(at)?.as_ref()) {
        Some(Answer::Text(id)) => Ok(id.clone()),
        _ => Err(pair.clone()),
    };
    let (chosen, missing): (Vec<_>, Vec<_>) = key.pairs.iter().map(chosen).partition(Result::is_ok);
    if !missing.is_empty() {
        return Err(NoScore::Missing(missing.into_iter().filter_map(Result::err).collect()));
    }
    let chosen: Vec<String> = chosen.into_iter().flatten().collect();
    let weight = |id: &String| chosen.iter().filter(|one| *one == id).count() as f64;
    let weighted: f64 = key.items.iter().zip(counted).map(|(id, value)| weight(id) * value).sum();
    Ok(weighted / chosen.len() as f64)
}

/// The least and the largest that a score can be.
#[must_use]
pub fn range(instrument: &Instrument, key: &ScoreKey) -> (f64, f64) {
    let ranges = key.items.iter().filter_map(|id| instrument.scale(instrument.item(id)?.1)?.range());
    let (low, high) =
        ranges.fold((0.0, 0.0), |(low, high), (least, largest)| (low + least + key.shift, high + largest + key.shift));
    let items = if key.combine == Combine::Sum { 1.0 } else { key.items.len() as f64 };
    let ends = (low / items * key.factor + key.offset, high / items * key.factor + key.offset);
    if ends.0 <= ends.1 { ends } else { (ends.1, ends.0) }
}
