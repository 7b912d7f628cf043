//! Rows of numbers in the layout of a C struct, which numpy reads without copying. Columns have the
//! same names as in `stylet export`.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use recording::tables::MOST_COLUMNS;
use recording::{Energy, Follows, Sample, Tent};

use crate::errors::refuse_input;

/// A column: name, numpy format, offset in the row.
type Field = (String, &'static str, usize);

/// Rows with identical columns.
#[derive(Default)]
pub struct PackedRows {
    fields: Vec<Field>,
    bytes: Vec<u8>,
    /// Size of a row in bytes, known after the first row.
    row_bytes: usize,
    rows: usize,
}

/// A type that can be written as a row.
pub trait Packed {
    /// Writes its columns, which must be the same for all rows of a table.
    fn pack(&self, row: &mut PackedRow<'_>);
}

/// A row that is being written.
pub struct PackedRow<'a> {
    rows: &'a mut PackedRows,
    begin: usize,
    naming: bool,
}

impl PackedRow<'_> {
    fn double(&mut self, name: impl Fn() -> String, value: f64) {
        self.put(name, "<f8", &value.to_le_bytes());
    }

    fn float(&mut self, name: impl Fn() -> String, value: f32) {
        self.put(name, "<f4", &value.to_le_bytes());
    }

    fn doubles<const N: usize>(&mut self, name: impl Fn(char) -> String, values: [f64; N]) {
        "xyzw".chars().zip(values).for_each(|(part, value)| self.double(|| name(part), value));
    }

    fn floats(&mut self, name: impl Fn(char) -> String, values: [f32; 3]) {
        "xyz".chars().zip(values).for_each(|(part, value)| self.float(|| name(part), value));
    }

    /// Writes a number, aligned to its size.
    fn put<const N: usize>(&mut self, name: impl Fn() -> String, format: &'static str, value: &[u8; N]) {
        let bytes = &mut self.rows.bytes;
        let offset = (bytes.len() - self.begin).next_multiple_of(N);
        bytes.resize(self.begin + offset, 0);
        bytes.extend_from_slice(value);
        if self.naming {
            self.rows.fields.push((name(), format, offset));
        }
    }
}

impl PackedRows {
    /// Packs items as rows.
    ///
    /// # Errors
    /// If a row has other columns than the first, or too many; neither occurs in our recordings.
    pub fn pack<T: Packed + Default>(table: &str, items: &[T]) -> PyResult<Self> {
        let mut rows = Self::default();
        if items.is_empty() {
            // An empty table still has columns.
            rows = Self::pack(table, &[T::default()])?;
            rows.bytes.clear();
            rows.rows = 0;
            return Ok(rows);
        }
        for (at, item) in items.iter().enumerate() {
            let begin = rows.bytes.len();
            item.pack(&mut PackedRow { rows: &mut rows, begin, naming: at == 0 });
            let end = rows.bytes.len().next_multiple_of(8);
            rows.bytes.resize(end, 0);
            if at == 0 {
                rows.row_bytes = end;
                rows.bytes.reserve(end * (items.len() - 1));
            }
            if end - begin != rows.row_bytes || rows.fields.len() > MOST_COLUMNS {
                let columns = rows.fields.len();
                return Err(refuse_input(format_args!(
                    "{table}[{at}]: {} bytes; allowed: {}, as in the first row, of {columns} columns, and at most \
                     {MOST_COLUMNS} columns",
                    end - begin,
                    rows.row_bytes
                )));
            }
        }
        rows.rows = items.len();
        Ok(rows)
    }

    /// Returns columns, bytes per row, number of rows, and the data.
    pub fn tell<'py>(&self, py: Python<'py>) -> (Vec<Field>, usize, usize, Bound<'py, PyByteArray>) {
        (self.fields.clone(), self.row_bytes, self.rows, PyByteArray::new(py, &self.bytes))
    }
}

impl Packed for Sample {
    fn pack(&self, row: &mut PackedRow<'_>) {
        row.double(|| "t_s".to_owned(), self.t_s);
        row.doubles(|part| format!("position_{part}_m"), self.position_m);
        row.doubles(|part| format!("orientation_{part}"), self.orientation);
        row.floats(|part| format!("velocity_{part}_m_per_s"), self.velocity_m_per_s);
        row.double(|| "x_m".to_owned(), self.x_m);
        row.float(|| "depth_m".to_owned(), self.depth_m);
        row.floats(|part| format!("force_{part}_n"), self.force_n);
        row.float(|| "tip_n".to_owned(), self.tip_n);
        row.float(|| "rim_n".to_owned(), self.rim_n);
        row.float(|| "viscous_n".to_owned(), self.viscous_n);
        row.float(|| "friction_n".to_owned(), self.friction_n);
        row.float(|| "cutting_n".to_owned(), self.cutting_n);
        row.floats(|part| format!("lateral_{part}_n"), self.lateral_n);
        row.floats(|part| format!("device_{part}_n"), self.device_n);
        row.put(|| "flags".to_owned(), "<u4", &self.flags.to_le_bytes());
        row.float(|| "lateness_us".to_owned(), self.lateness_us);
        row.floats(|part| format!("bend_{part}_m"), self.bend_m);
    }
}

impl Packed for Tent {
    fn pack(&self, row: &mut PackedRow<'_>) {
        row.double(|| "t_s".to_owned(), self.t_s);
        let parts = [("tent", "m", &self.tent_m), ("contactor", "n", &self.contactor_n), ("drag", "n", &self.drag_n)];
        for (part, unit, values) in parts {
            for (at, &value) in values.iter().enumerate() {
                row.float(|| format!("{part}_{at}_{unit}"), value);
            }
        }
        // In the order of the message, as in the tables of `stylet export`.
        row.put(|| "follows_needle".to_owned(), "|b1", &[u8::from(self.follows >= Follows::Needle)]);
        for (at, &value) in self.linear_n.iter().enumerate() {
            row.float(|| format!("linear_{at}_n"), value);
        }
        row.put(|| "follows_secant".to_owned(), "|b1", &[u8::from(self.follows >= Follows::Secant)]);
    }
}

impl Packed for Energy {
    fn pack(&self, row: &mut PackedRow<'_>) {
        let ledger = &self.ledger;
        row.double(|| "t_s".to_owned(), self.t_s);
        row.double(|| "input_j".to_owned(), ledger.input_j);
        row.double(|| "returned_j".to_owned(), ledger.returned_j);
        row.double(|| "presliding_j".to_owned(), ledger.presliding_j);
        for (at, layer) in ledger.layers.iter().enumerate() {
            let parts = [
                ("elastic", layer.elastic_j),
                ("rupture", layer.rupture_j),
                ("viscous", layer.viscous_j),
                ("friction", layer.friction_j),
                ("cutting", layer.cutting_j),
                ("lateral", layer.lateral_j),
            ];
            for (part, value) in parts {
                row.double(|| format!("layers_{at}_{part}_j"), value);
            }
        }
        row.double(|| "lagged_j".to_owned(), ledger.lagged_j);
    }
}
