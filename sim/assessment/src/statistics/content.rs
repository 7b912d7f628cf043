//! Content validity: the share of experts who rate an item as relevant (Lynn 1986; Polit and Beck
//! 2006).

use super::{NotComputable, count_as_number};

/// Content validity of an item or a scale, a share 0–1.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ContentValidity {
    /// The share.
    pub value: f64,
    /// For an item the number of experts who rated it; for a scale the number of its items.
    pub n: usize,
    /// Number of missing ratings (for a scale: unrated items).
    pub missing: usize,
}

/// I-CVI: the share of experts who rate an item 3 or 4 of 4.
///
/// # Errors
/// Without a rating, or with one outside 1–4.
pub fn content_validity(ratings: &[Option<u8>]) -> Result<ContentValidity, NotComputable> {
    let given: Vec<u8> = ratings.iter().flatten().copied().collect();
    if given.is_empty() {
        return Err(NotComputable::TooFew { found: 0, needed: 1 });
    }
    if given.iter().any(|rating| !(1..=4).contains(rating)) {
        return Err(NotComputable::OutOfRange);
    }
    let relevant = given.iter().filter(|rating| **rating >= 3).count();
    let value = count_as_number(relevant) / count_as_number(given.len());
    Ok(ContentValidity { value, n: given.len(), missing: ratings.len() - given.len() })
}

/// S-CVI/Ave: the mean of the items' I-CVI. An item without ratings is left out and counted as
/// missing.
///
/// # Errors
/// Without a rated item, or with a rating outside 1–4.
pub fn scale_content_validity(items: &[Vec<Option<u8>>]) -> Result<ContentValidity, NotComputable> {
    let mut values = Vec::new();
    for item in items {
        match content_validity(item) {
            Ok(item) => values.push(item.value),
            Err(NotComputable::TooFew { .. }) => {}
            Err(why) => return Err(why),
        }
    }
    if values.is_empty() {
        return Err(NotComputable::TooFewItems { found: 0, needed: 1 });
    }
    let value = values.iter().sum::<f64>() / count_as_number(values.len());
    Ok(ContentValidity { value, n: values.len(), missing: items.len() - values.len() })
}
