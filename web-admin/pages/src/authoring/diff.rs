//! Line-by-line comparison of two texts.

use similar::{ChangeTag, TextDiff};

/// Unchanged lines shown around a change.
const CONTEXT: usize = 3;

/// A line of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiffLine {
    /// Kind of change.
    pub change: DiffMark,
    /// Line number in the older text, from 1.
    pub before: Option<usize>,
    /// Line number in the newer text, from 1.
    pub after: Option<usize>,
    /// Text of the line, without its line ending.
    pub text: String,
}

/// Kind of change of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiffMark {
    /// Present in both texts.
    Kept,
    /// Only in the older text.
    Removed,
    /// Only in the newer text.
    Added,
}

impl DiffMark {
    /// Returns the CSS class of the row.
    #[must_use]
    pub fn class(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Removed => "removed",
            Self::Added => "added",
        }
    }

    /// Returns a sign, so that colour is not the only cue.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Kept => "",
            Self::Removed => "−",
            Self::Added => "+",
        }
    }
}

/// Returns the changed lines with their context, in groups; empty if the texts are equal.
#[must_use]
pub fn compare_lines(older: &str, newer: &str) -> Vec<Vec<DiffLine>> {
    let diff = TextDiff::from_lines(older, newer);
    let line = |change: similar::Change<&str>| DiffLine {
        change: match change.tag() {
            ChangeTag::Equal => DiffMark::Kept,
            ChangeTag::Delete => DiffMark::Removed,
            ChangeTag::Insert => DiffMark::Added,
        },
        before: change.old_index().map(|index| index + 1),
        after: change.new_index().map(|index| index + 1),
        text: change.value().trim_end_matches(['\r', '\n']).to_owned(),
    };
    let group = |operations: &Vec<similar::DiffOp>| {
        operations.iter().flat_map(|operation| diff.iter_changes(operation)).map(line).collect()
    };
    diff.grouped_ops(CONTEXT).iter().map(group).collect()
}

#[cfg(test)]
mod tests {
    //! Reviewers can only judge a change that is shown.

    use super::*;

    #[test]
    fn only_what_changed_is_shown_with_its_numbers() {
        let older: String = (1..=20).map(|i| format!("line {i}\n")).collect();
        let newer = older.replace("line 10\n", "line ten\n").replace("line 20\n", "line 20\nline 21\n");
        let groups = compare_lines(&older, &newer);
        assert_eq!(groups.len(), 2);
        let changed: Vec<_> = groups.concat().into_iter().filter(|line| line.change != DiffMark::Kept).collect();
        let seen: Vec<_> = changed.iter().map(|l| (l.change.sign(), l.before, l.after, l.text.as_str())).collect();
        assert_eq!(
            seen,
            [("−", Some(10), None, "line 10"), ("+", None, Some(10), "line ten"), ("+", None, Some(21), "line 21")]
        );
        assert!(compare_lines(&older, &older).is_empty());
    }
}
