//! Topics laid flat. Would fail if a field were left out, if a column lost its unit, or if rows of different width got into one
//! table.

use std::io;

use recording::Tent;
use recording::error::ReadError;
use recording::tables::{Cell, Column, ColumnKind, Table, TableSink, UNITS, read_tables};

use crate::support::{file, rupture, sample, writer};

/// Keeps everything.
#[derive(Default)]
struct Kept {
    columns: Vec<(Table, Vec<Column>)>,
    rows: Vec<(Table, Vec<Cell>)>,
}

impl TableSink for Kept {
    fn begin(&mut self, table: Table, columns: &[Column]) -> io::Result<()> {
        assert!(self.columns.iter().all(|(begun, _)| *begun != table), "{} begins twice", table.name());
        self.columns.push((table, columns.to_vec()));
        Ok(())
    }

    fn row(&mut self, table: Table, cells: &[Cell]) -> io::Result<()> {
        self.rows.push((table, cells.to_vec()));
        Ok(())
    }
}

impl Kept {
    fn of(bytes: &[u8]) -> Self {
        let mut kept = Self::default();
        assert!(read_tables(bytes, &mut kept).unwrap(), "the file is whole");
        kept
    }

    fn columns(&self, table: Table) -> &[Column] {
        &self.columns.iter().find(|(found, _)| *found == table).unwrap().1
    }

    fn names(&self, table: Table) -> Vec<&str> {
        self.columns(table).iter().map(|column| column.name.as_str()).collect()
    }

    /// The cells of a row under a column.
    fn cell(&self, table: Table, row: usize, column: &str) -> &Cell {
        let place = self.names(table).iter().position(|name| *name == column).unwrap();
        &self.rows.iter().filter(|(found, _)| *found == table).nth(row).unwrap().1[place]
    }
}

fn tent(t_s: f64, boundaries: usize) -> Tent {
    Tent {
        t_s,
        tent_m: vec![0.001; boundaries],
        contactor_n: vec![0.5; boundaries],
        drag_n: vec![0.25; boundaries],
        linear_n: vec![0.125; 2 * boundaries],
        follows: recording::Follows::Secant,
    }
}

#[test]
fn columns_carry_their_units_last() {
    let kept = Kept::of(&file(20));
    let samples = kept.names(Table::Samples);
    for name in
        ["t_s", "position_x_m", "orientation_w", "velocity_z_m_per_s", "force_y_n", "flags", "lateness_us", "bend_x_m"]
    {
        assert!(samples.contains(&name), "{name} is missing in {samples:?}");
    }
    let summary = kept.names(Table::Summary);
    for name in ["ticks", "axial_max_n", "depth_mean_m", "speed_min_m_per_s"] {
        assert!(summary.contains(&name), "{name} is missing in {summary:?}");
    }
    for table in [Table::Samples, Table::Summary] {
        let bare = kept.names(table).into_iter().filter(|name| !UNITS.iter().any(|(ending, _)| name.ends_with(ending)));
        let bare: Vec<_> =
            bare.filter(|name| !name.starts_with("orientation_") && !["flags", "ticks"].contains(name)).collect();
        assert!(bare.is_empty(), "without a unit: {bare:?}");
    }
}

#[test]
fn numbers_keep_their_kind() {
    let kept = Kept::of(&file(20));
    assert!(matches!(kept.cell(Table::Samples, 7, "t_s"), Cell::Double(t) if *t == sample(7).t_s));
    assert!(matches!(kept.cell(Table::Samples, 7, "tip_n"), Cell::Float(n) if *n == sample(7).tip_n));
    assert!(matches!(kept.cell(Table::Samples, 7, "flags"), Cell::Whole(bits) if *bits == i64::from(sample(7).flags)));
    assert_eq!(kept.cell(Table::Samples, 7, "bend_x_m"), &Cell::Float(sample(7).bend_m[0]), "a part left out is zero");
}

#[test]
fn events_say_their_kind_and_leave_empty_what_they_lack() {
    let mut writer = writer();
    writer.event(&rupture(0.25)).unwrap();
    writer.event(&recording::Event { kind: recording::EventKind::Confirm, boundary: None, ..rupture(0.5) }).unwrap();
    let kept = Kept::of(&writer.finish().unwrap());
    assert_eq!(kept.cell(Table::Events, 0, "kind"), &Cell::Text("tip_rupture".to_owned()));
    assert_eq!(kept.cell(Table::Events, 0, "boundary"), &Cell::Whole(0), "the first boundary is not an absent one");
    assert_eq!(kept.cell(Table::Events, 1, "boundary"), &Cell::Empty);
    for column in kept.columns(Table::Events) {
        let optional = ["boundary", "track", "structure"].contains(&column.name.as_str());
        assert_eq!(column.optional, optional, "{}", column.name);
        assert!(column.kind != ColumnKind::Float, "{} is a double or none", column.name);
    }
}

#[test]
fn tables_that_depend_on_the_scene_begin_with_their_first_row() {
    let none = Kept::of(&writer().finish().unwrap());
    let begun: Vec<_> = none.columns.iter().map(|(table, _)| table.name()).collect();
    assert_eq!(begun, ["samples", "summary", "events"]);
    let mut writer = writer();
    writer.tent(&tent(0.0, 2)).unwrap();
    let kept = Kept::of(&writer.finish().unwrap());
    let names = kept.names(Table::Tents);
    assert_eq!(names[..7], ["t_s", "tent_0_m", "tent_1_m", "contactor_0_n", "contactor_1_n", "drag_0_n", "drag_1_n"]);
    assert_eq!(
        names[7..],
        ["follows_needle", "linear_0_n", "linear_1_n", "linear_2_n", "linear_3_n", "follows_secant"]
    );
}

#[test]
fn rows_of_another_width_are_damage() {
    let mut writer = writer();
    writer.tent(&tent(0.0, 2)).unwrap();
    writer.tent(&tent(0.01, 3)).unwrap();
    let error = read_tables(writer.finish().unwrap().as_slice(), &mut Kept::default()).unwrap_err();
    assert!(matches!(error, ReadError::Damaged { .. }) && error.to_string().contains("tents"), "{error}");
}
