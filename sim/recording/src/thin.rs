//! A long row of items as few of them, without losing a peak.

/// Returns the items of least and of greatest height in each of `most / 2` even stretches, in order; all items where there are no more
/// than `most`.
pub fn keep_extremes<T>(items: &[T], most: usize, height: impl Fn(&T) -> f64) -> Vec<&T> {
    if items.len() <= most {
        return items.iter().collect();
    }
    let stretches = most / 2;
    let by_height = |a: &&usize, b: &&usize| height(&items[**a]).total_cmp(&height(&items[**b]));
    let mut kept = Vec::with_capacity(most);
    for k in 0..stretches {
        let stretch: Vec<usize> = (k * items.len() / stretches..(k + 1) * items.len() / stretches).collect();
        let ends = stretch.iter().min_by(by_height).into_iter().chain(stretch.iter().max_by(by_height));
        let mut ends: Vec<usize> = ends.copied().collect();
        ends.sort_unstable();
        ends.dedup();
        kept.extend(ends.into_iter().map(|at| &items[at]));
    }
    kept
}
