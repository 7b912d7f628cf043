//! Groups of responses, with small groups hidden.
//!
//! A group with fewer than five responses is shown only to the survey's owner. If the hidden
//! responses are fewer than five in total, they could be inferred by subtracting the others from
//! the total; therefore the smallest shown group is hidden, too.

use std::collections::BTreeMap;

/// Minimum size of a group that is shown to everyone.
pub const LEAST: usize = 5;

/// Shown groups by name, and the number of responses in hidden groups.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseGroups<'a, T> {
    /// Name and responses.
    pub shown: Vec<(String, Vec<&'a T>)>,
    /// Number of responses in hidden groups.
    pub hidden: usize,
}

impl<'a, T> ResponseGroups<'a, T> {
    /// Groups responses by a name; responses without one are left out. With `whole`, nothing is
    /// hidden.
    pub fn new(rows: &[&'a T], name: impl Fn(&T) -> Option<String>, whole: bool) -> Self {
        let mut named: BTreeMap<String, Vec<&'a T>> = BTreeMap::new();
        for row in rows {
            if let Some(name) = name(row) {
                named.entry(name).or_default().push(row);
            }
        }
        let all: Vec<_> = named.into_iter().collect();
        if whole {
            return Self { shown: all, hidden: 0 };
        }
        let (mut shown, small): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, rows)| rows.len() >= LEAST);
        let mut hidden: usize = small.iter().map(|(_, rows)| rows.len()).sum();
        if (1..LEAST).contains(&hidden)
            && let Some(smallest) = (0..shown.len()).min_by_key(|at| shown[*at].1.len())
        {
            hidden += shown.remove(smallest).1.len();
        }
        Self { shown, hidden }
    }

    /// Returns all responses of the shown groups.
    #[must_use]
    pub fn all(&self) -> Vec<&'a T> {
        self.shown.iter().flat_map(|(_, rows)| rows.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    //! Checks that a group of four is not shown and cannot be inferred as a difference.

    use super::*;

    fn groups(sizes: &[(&'static str, usize)], whole: bool) -> (Vec<(String, usize)>, usize) {
        let rows: Vec<&str> = sizes.iter().flat_map(|(name, n)| vec![*name; *n]).collect();
        let rows: Vec<&&str> = rows.iter().collect();
        let groups = ResponseGroups::new(&rows, |name| Some((*name).to_owned()), whole);
        assert_eq!(groups.all().len() + groups.hidden, rows.len());
        (groups.shown.iter().map(|(name, rows)| (name.clone(), rows.len())).collect(), groups.hidden)
    }

    #[test]
    fn four_are_hidden_and_five_are_not() {
        assert_eq!(groups(&[("a", 5), ("b", 6)], false), (vec![("a".to_owned(), 5), ("b".to_owned(), 6)], 0));
        assert_eq!(groups(&[("a", 4)], false), (vec![], 4));
        assert_eq!(groups(&[("a", 4)], true), (vec![("a".to_owned(), 4)], 0));
    }

    #[test]
    fn what_is_hidden_cannot_be_had_by_subtraction() {
        assert_eq!(groups(&[("a", 9), ("b", 6), ("c", 4)], false), (vec![("a".to_owned(), 9)], 10));
        assert_eq!(
            groups(&[("a", 9), ("b", 3), ("c", 4)], false),
            (vec![("a".to_owned(), 9)], 7),
            "seven hide each other"
        );
    }
}
