//! Tables of answers or ratings, some of them incomplete.

use super::NotComputable;

/// The complete rows of a table, all of the same length.
pub(super) struct Complete {
    /// One row per person, one column per item or rater.
    pub rows: Vec<Vec<f64>>,
    /// Number of columns.
    pub columns: usize,
    /// Number of rows left out because a value is missing.
    pub missing: usize,
}

impl Complete {
    /// Collects the complete rows.
    pub(super) fn from_rows(rows: &[Vec<Option<f64>>]) -> Result<Self, NotComputable> {
        let columns = rows.first().map_or(0, Vec::len);
        if rows.iter().any(|row| row.len() != columns) {
            return Err(NotComputable::Ragged);
        }
        let complete: Vec<Vec<f64>> = rows.iter().filter_map(|row| row.iter().copied().collect()).collect();
        if complete.iter().flatten().any(|v| !v.is_finite()) {
            return Err(NotComputable::OutOfRange);
        }
        Ok(Self { missing: rows.len() - complete.len(), rows: complete, columns })
    }

    /// Refuses fewer than two rows or columns.
    pub(super) fn at_least_two(&self) -> Result<(), NotComputable> {
        match (self.columns, self.rows.len()) {
            (found @ ..2, _) => Err(NotComputable::TooFewItems { found, needed: 2 }),
            (_, found @ ..2) => Err(NotComputable::TooFew { found, needed: 2 }),
            _ => Ok(()),
        }
    }

    /// Returns one column.
    pub(super) fn column(&self, at: usize) -> Vec<f64> {
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// Returns the table without one column.
    pub(super) fn without_column(&self, at: usize) -> Self {
        let kept =
            |row: &Vec<f64>| row.iter().enumerate().filter(|(column, _)| *column != at).map(|(_, v)| *v).collect();
        Self { rows: self.rows.iter().map(kept).collect(), columns: self.columns - 1, missing: self.missing }
    }
}
