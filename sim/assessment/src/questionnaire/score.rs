//! Computes scores by the instrument's key.

use documents::instrument::{Combine, Instrument, Missing, ScoreKey};

use super::Answer;

/// The reason why there is no score.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoScore {
    /// Ids of items without an answer that the key requires.
    #[error("no answer to {}", .0.join(", "))]
    Missing(Vec<String>),
}

/// An item of a score: the index of its answer, and its reversal.
struct Counted<'a> {
    id: &'a str,
    /// Index of the item; `None` if its scale is not numeric.
    at: Option<usize>,
    /// If the key reverses the item, it counts as `turn` − answer.
    turn: Option<f64>,
}

/// A scoring key with its items resolved, for any number of responses.
pub struct Scorer<'a> {
    key: &'a ScoreKey,
    items: Vec<Counted<'a>>,
    /// Id and index of each pair.
    pairs: Vec<(&'a String, Option<usize>)>,
}

impl<'a> Scorer<'a> {
    /// Resolves the key's items.
    #[must_use]
    pub fn new(instrument: &'a Instrument, key: &'a ScoreKey) -> Self {
        let counted = |id: &'a String| {
            let found = instrument.item(id).and_then(|(at, item)| Some((at, instrument.scale(item)?.range()?)));
            let reversed = key.reversed.contains(id);
            let turn = found.filter(|_| reversed).map(|(_, (least, largest))| least + largest);
            Counted { id, at: found.map(|(at, _)| at), turn }
        };
        let place = |id: &'a String| (id, instrument.item(id).map(|(at, _)| at));
        Self { key, items: key.items.iter().map(counted).collect(), pairs: key.pairs.iter().map(place).collect() }
    }

    /// Returns the scorers of an instrument, in the order of its scores.
    #[must_use]
    pub fn all(instrument: &'a Instrument) -> Vec<Self> {
        instrument.scores.iter().map(|key| Self::new(instrument, key)).collect()
    }

    fn count(&self, item: &Counted<'_>, answers: &[Option<Answer>]) -> Option<f64> {
        let answer = answers.get(item.at?)?.as_ref()?.number()?;
        Some(item.turn.map_or(answer, |turn| turn - answer) + self.key.shift)
    }

    /// Returns the contribution of each item, in the order of the key: reversed if the key demands
    /// it, and shifted.
    #[must_use]
    pub fn item_counts(&self, answers: &[Option<Answer>]) -> Vec<Option<f64>> {
        self.items.iter().map(|item| self.count(item, answers)).collect()
    }

    /// Computes the score of a response, in the key's unit.
    ///
    /// # Errors
    /// If an item is missing that the key's policy requires.
    pub fn score(&self, answers: &[Option<Answer>]) -> Result<f64, NoScore> {
        let key = self.key;
        let counted = self.item_counts(answers);
        let answered: Vec<f64> = counted.iter().flatten().copied().collect();
        let enough = match key.missing {
            Missing::NoScore => answered.len() == counted.len(),
            Missing::MeanOfAnswered => answered.len() >= key.least_answered.unwrap_or(counted.len()).max(1),
        };
        if !enough {
            let missing = self.items.iter().zip(&counted).filter(|(_, counts)| counts.is_none());
            return Err(NoScore::Missing(missing.map(|(item, _)| item.id.to_owned()).collect()));
        }
        let mean = answered.iter().sum::<f64>() / answered.len() as f64;
        let combined = match key.combine {
            Combine::Mean => mean,
            Combine::Sum => mean * counted.len() as f64,
            Combine::PairWeighted => self.pair_weighted(&answered, answers)?,
        };
        Ok(combined * key.factor + key.offset)
    }

    /// Computes Σ w r / Σ w, where an item's weight is the number of pairs in which it was chosen.
    fn pair_weighted(&self, counted: &[f64], answers: &[Option<Answer>]) -> Result<f64, NoScore> {
        let mut chosen: Vec<&String> = Vec::new();
        let mut missing = Vec::new();
        for (pair, at) in &self.pairs {
            match at.and_then(|at| answers.get(at)?.as_ref()) {
                Some(Answer::Text(id)) => chosen.push(id),
                _ => missing.push((*pair).clone()),
            }
        }
        if !missing.is_empty() {
            return Err(NoScore::Missing(missing));
        }
        let weight = |id: &str| chosen.iter().filter(|one| **one == id).count() as f64;
        let weighted: f64 = self.items.iter().zip(counted).map(|(item, value)| weight(item.id) * value).sum();
        Ok(weighted / chosen.len() as f64)
    }
}

/// Computes the score of one response by its key, in the key's unit.
///
/// # Errors
/// If an item is missing that the key's policy requires.
pub fn score_response(instrument: &Instrument, key: &ScoreKey, answers: &[Option<Answer>]) -> Result<f64, NoScore> {
    Scorer::new(instrument, key).score(answers)
}

/// Returns the smallest and largest possible score.
#[must_use]
pub fn score_range(instrument: &Instrument, key: &ScoreKey) -> (f64, f64) {
    let ranges = key.items.iter().filter_map(|id| instrument.scale(instrument.item(id)?.1)?.range());
    let (low, high) =
        ranges.fold((0.0, 0.0), |(low, high), (least, largest)| (low + least + key.shift, high + largest + key.shift));
    let items = if key.combine == Combine::Sum { 1.0 } else { key.items.len() as f64 };
    let ends = (low / items * key.factor + key.offset, high / items * key.factor + key.offset);
    if ends.0 <= ends.1 { ends } else { (ends.1, ends.0) }
}
