//! Groups of answers, small ones hidden.
//!
//! A group of fewer than five is shown to nobody but the survey's owner. One that is hidden alone could be had by taking
//! the others from the whole, so the smallest that would be shown goes with it.

use std::collections::BTreeMap;

/// Fewest answers of a group that is shown to everybody.
pub const LEAST: usize = 5;

/// Groups by name, and how many answers are in those that are hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseGroups<'a, T> {
    /// Name and answers.
    pub shown: Vec<(String, Vec<&'a T>)>,
    /// Answers in hidden groups.
    pub hidden: usize,
}

impl<'a, T> ResponseGroups<'a, T> {
    /// Answers by a name that each has; those without one are left out. `whole` hides nothing.
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

    /// Every answer of the groups that are shown.
    #[must_use]
    pub fn all(&self) -> Vec<&'a T> {
        self.shown.iter().flat_map(|(_, rows)| rows.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a group of four can be seen, or be had as the difference of what can.

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
