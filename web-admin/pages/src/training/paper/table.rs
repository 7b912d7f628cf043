//! Tables: rows stay whole, and the headings are repeated on every sheet.

use super::fonts::{Fonts, Shaped};
use super::layout::{Ink, Layout, MARGIN, PartRole, SheetMark, TaggedPart, TextLook, WIDTH};
use super::lines::break_lines;
use super::{PaperTable, Style};

/// Space between columns.
const GAP: f32 = 12.0;
/// Space above and below the text of a row.
const PADDING: f32 = 3.0;

/// A row as lines of each cell.
struct SetRow {
    look: TextLook,
    cells: Vec<Vec<Shaped>>,
    height: f32,
}

/// Sets a table.
pub(super) fn set_table(layout: &mut Layout, table: &PaperTable, fonts: &Fonts) {
    let body = TextLook { size: 10.0, leading: 13.5, ..Style::Body.look() };
    let head = TextLook { ink: Ink::Muted, ..body };
    let titles: Vec<&str> = table.columns.iter().map(|column| column.title.as_str()).collect();
    let heading = set_row(table, &titles, head, fonts);
    let rows: Vec<SetRow> = table
        .rows
        .iter()
        .map(|cells| set_row(table, &cells.iter().map(String::as_str).collect::<Vec<_>>(), body, fonts))
        .collect();
    layout.y += 4.0;
    layout.make_room(heading.height + rows.first().map_or(0.0, |row| row.height));
    let top = put_row(layout, table, &heading, true);
    let mut parts = Vec::new();
    for row in &rows {
        if layout.make_room(row.height) {
            put_row(layout, table, &heading, false);
        }
        parts.push(tag_row(put_row(layout, table, row, true), PartRole::RowHeading, PartRole::Cell));
    }
    layout.y += 10.0;
    let head =
        TaggedPart::Group(PartRole::TableHead, vec![tag_row(top, PartRole::ColumnHeading, PartRole::ColumnHeading)]);
    layout.parts.push(TaggedPart::Group(PartRole::Table, vec![head, TaggedPart::Group(PartRole::TableBody, parts)]));
}

/// Breaks the cells of a row into lines.
fn set_row(table: &PaperTable, cells: &[&str], look: TextLook, fonts: &Fonts) -> SetRow {
    let lines = table.columns.iter().zip(cells).map(|(column, text)| {
        let width = WIDTH * f32::from(column.percent) / 100.0 - GAP;
        break_lines(fonts, text, false, width / look.size)
    });
    let cells: Vec<Vec<Shaped>> = lines.collect();
    let high = cells.iter().map(Vec::len).max().unwrap_or_default().max(1);
    SetRow { look, cells, height: high as f32 * look.leading + 2.0 * PADDING }
}

/// Draws a row and returns the leaf of each cell. A repeated row of headings has no leaves.
fn put_row(layout: &mut Layout, table: &PaperTable, row: &SetRow, tagged: bool) -> Vec<usize> {
    let look = row.look;
    let mut x = MARGIN;
    let mut leaves = Vec::new();
    for (column, lines) in table.columns.iter().zip(&row.cells) {
        let leaf = tagged.then(|| layout.next_leaf());
        leaves.extend(leaf);
        let mut y = layout.y + PADDING;
        for line in lines {
            layout.put_line([x, y], look, line.clone(), leaf);
            y += look.leading;
        }
        x += WIDTH * f32::from(column.percent) / 100.0;
    }
    layout.y += row.height;
    layout.put(SheetMark::Bar { x: MARGIN, y: layout.y, width: WIDTH, height: 0.5, ink: Ink::Line });
    leaves
}

/// Returns the structure of a row.
fn tag_row(leaves: Vec<usize>, first: PartRole, others: PartRole) -> TaggedPart {
    let cell = |(at, leaf)| {
        let role = if at == 0 { first.clone() } else { others.clone() };
        TaggedPart::Group(role, vec![TaggedPart::Leaf(leaf)])
    };
    TaggedPart::Group(PartRole::Row, leaves.into_iter().enumerate().map(cell).collect())
}
