//! Rows of a document: arrays of tables at its root (`item`) or in a row of another array
//! (`scale[2].option`).

use toml_edit::{Array, ArrayOfTables, Item, Table, Value};

use super::{EditedDocument, last_key, with_decor_of};

impl EditedDocument {
    /// Returns the number of rows in an array of tables.
    #[must_use]
    pub fn count_rows(&self, array: &str) -> usize {
        match self.find_item(array) {
            Some(Item::ArrayOfTables(rows)) => rows.len(),
            Some(Item::Value(Value::Array(rows))) => rows.len(),
            _ => 0,
        }
    }

    /// Appends a row with initial texts.
    pub fn add_row(&mut self, array: &str, first: &[(&str, &str)]) {
        let mut table = Table::new();
        first.iter().for_each(|(key, text)| drop(table.insert(key, toml_edit::value(*text))));
        if !self.is_written(array) && !self.begin_array(array) {
            return;
        }
        let behind = self.find_item(array).and_then(last_position).or_else(|| self.position_around(array));
        match self.item_mut(array) {
            Some(Item::ArrayOfTables(rows)) => {
                table.set_position(behind);
                rows.push(table);
            }
            Some(Item::Value(Value::Array(rows))) => rows.push(table.into_inline_table()),
            _ => {}
        }
    }

    /// Creates an empty array. Returns false if its parent row does not exist.
    fn begin_array(&mut self, array: &str) -> bool {
        let is_inline = array.contains('.') && self.parent_mut(array).is_some_and(|parent| !parent.is_table());
        let Some(parent) = self.parent_mut(array).and_then(Item::as_table_like_mut) else { return false };
        let empty = match is_inline {
            true => Item::Value(Value::Array(Array::new())),
            false => Item::ArrayOfTables(ArrayOfTables::new()),
        };
        parent.insert(last_key(array), empty);
        true
    }

    /// Returns the position after which the first row of an array is inserted.
    fn position_around(&self, array: &str) -> Option<isize> {
        match array.rsplit_once('.') {
            Some((row, _)) => self.find_item(row).and_then(last_position),
            None => self.position_before(array),
        }
    }

    /// Removes a row.
    pub fn remove_row(&mut self, array: &str, row: usize) {
        if row >= self.count_rows(array) {
            return;
        }
        match self.item_mut(array) {
            Some(Item::ArrayOfTables(rows)) => drop(rows.remove(row)),
            Some(Item::Value(Value::Array(rows))) => drop(rows.remove(row)),
            _ => {}
        }
        if self.count_rows(array) == 0 {
            self.put_value(array, None);
        }
    }

    /// Swaps two rows, each with the comments above it and its content.
    pub fn swap_rows(&mut self, array: &str, row: usize, other: usize) {
        let count = self.count_rows(array);
        match self.item_mut(array).filter(|_| row.max(other) < count) {
            Some(Item::ArrayOfTables(rows)) => {
                let mut tables: Vec<Table> = rows.iter().cloned().collect();
                let mut places = Vec::new();
                tables.iter().for_each(|table| collect_positions(table, &mut places));
                places.sort_unstable();
                tables.swap(row, other);
                let mut places = places.into_iter();
                tables.iter_mut().for_each(|table| take_positions(table, &mut places));
                *rows = tables.into_iter().collect();
            }
            Some(Item::Value(Value::Array(rows))) => {
                let (Some(first), Some(second)) = (rows.get(row).cloned(), rows.get(other).cloned()) else { return };
                rows.replace(row, with_decor_of(second.clone(), &first));
                rows.replace(other, with_decor_of(first, &second));
            }
            _ => {}
        }
    }
}

/// Returns the position of the last table in an item.
pub(super) fn last_position(item: &Item) -> Option<isize> {
    let mut places = Vec::new();
    match item {
        Item::Table(table) => collect_positions(table, &mut places),
        Item::ArrayOfTables(rows) => rows.iter().for_each(|table| collect_positions(table, &mut places)),
        _ => {}
    }
    places.into_iter().max()
}

fn collect_positions(table: &Table, places: &mut Vec<isize>) {
    places.extend(table.position());
    for (_, item) in table {
        match item {
            Item::Table(table) => collect_positions(table, places),
            Item::ArrayOfTables(rows) => rows.iter().for_each(|table| collect_positions(table, places)),
            _ => {}
        }
    }
}

/// Assigns the next positions to a table and its contents, in the order in which they are written.
fn take_positions(table: &mut Table, places: &mut impl Iterator<Item = isize>) {
    if table.position().is_some() {
        table.set_position(places.next());
    }
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(table) => take_positions(table, places),
            Item::ArrayOfTables(rows) => rows.iter_mut().for_each(|table| take_positions(table, places)),
            _ => {}
        }
    }
}
