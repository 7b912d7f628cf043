//! Tables of a recording hold its numbers. Would fail if a number changed on its way into CSV or Parquet, if a field were left
//! out, if tables were overwritten unasked, or if something half-written stayed behind.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use recording::Recording;
use tempfile::TempDir;

use crate::recordings::recorded;
use crate::{stylet, text};

const TABLES: [&str; 5] = ["samples", "summary", "energy", "events", "tents"];

/// A table: the names of its columns, and the texts of its rows.
struct Csv {
    places: BTreeMap<String, usize>,
    rows: Vec<csv::StringRecord>,
}

impl Csv {
    fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).expect("a table");
        let header = reader.headers().expect("a header").clone();
        let places = header.iter().enumerate().map(|(i, name)| (name.to_owned(), i)).collect();
        Self { places, rows: reader.records().collect::<Result<_, _>>().expect("rows") }
    }

    fn text(&self, row: usize, column: &str) -> &str {
        self.rows[row].get(*self.places.get(column).expect(column)).expect("a cell")
    }

    /// A double, to the bit.
    fn double(&self, row: usize, column: &str) -> u64 {
        self.text(row, column).parse::<f64>().expect(column).to_bits()
    }

    /// A float, to the bit.
    fn float(&self, row: usize, column: &str) -> u32 {
        self.text(row, column).parse::<f32>().expect(column).to_bits()
    }
}

/// A recording and its tables in a format.
fn exported(format: &str) -> (TempDir, Recording) {
    let (folder, file) = recorded();
    stylet(&["export", text(&file), "--to", format]).ends(0);
    let recording = Recording::read(File::open(&file).expect("a recording")).expect("a recording");
    (folder, recording)
}

#[test]
fn samples_are_those_of_the_recording_to_the_bit() {
    let (folder, recording) = exported("csv");
    let table = Csv::read(&folder.path().join("attempt/samples.csv"));
    assert_eq!(table.rows.len(), recording.samples.len());
    for (row, sample) in recording.samples.iter().enumerate() {
        assert_eq!(table.double(row, "t_s"), sample.t_s.to_bits());
        assert_eq!(table.double(row, "x_m"), sample.x_m.to_bits());
        assert_eq!(table.float(row, "depth_m"), sample.depth_m.to_bits());
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            assert_eq!(table.double(row, &format!("position_{axis}_m")), sample.position_m[i].to_bits());
            assert_eq!(table.double(row, &format!("orientation_{axis}")), sample.orientation[i].to_bits());
            assert_eq!(table.float(row, &format!("velocity_{axis}_m_per_s")), sample.velocity_m_per_s[i].to_bits());
            assert_eq!(table.float(row, &format!("force_{axis}_n")), sample.force_n[i].to_bits());
            assert_eq!(table.float(row, &format!("lateral_{axis}_n")), sample.lateral_n[i].to_bits());
            assert_eq!(table.float(row, &format!("device_{axis}_n")), sample.device_n[i].to_bits());
            assert_eq!(table.float(row, &format!("bend_{axis}_m")), sample.bend_m[i].to_bits());
        }
        let parts = [sample.tip_n, sample.rim_n, sample.viscous_n, sample.friction_n, sample.cutting_n];
        for (name, part) in ["tip_n", "rim_n", "viscous_n", "friction_n", "cutting_n"].into_iter().zip(parts) {
            assert_eq!(table.float(row, name), part.to_bits(), "{name}");
        }
        assert_eq!(table.text(row, "flags"), sample.flags.to_string());
    }
}

#[test]
fn events_energies_and_tents_are_those_of_the_recording() {
    let (folder, recording) = exported("csv");
    let table = |name: &str| Csv::read(&folder.path().join("attempt").join(name));
    let events = table("events.csv");
    assert!(!recording.events.is_empty() && events.rows.len() == recording.events.len());
    for (row, event) in recording.events.iter().enumerate() {
        assert_eq!(events.text(row, "kind"), event.kind.name());
        assert_eq!(events.text(row, "boundary"), event.boundary.map_or(String::new(), |b| b.to_string()));
        assert_eq!(events.double(row, "force_n"), event.force_n.to_bits());
        assert_eq!(events.text(row, "text"), event.text);
    }
    let energies = table("energy.csv");
    assert_eq!(energies.rows.len(), recording.energies.len());
    for (row, energy) in recording.energies.iter().enumerate() {
        assert_eq!(energies.double(row, "input_j"), energy.ledger.input_j.to_bits());
        for (i, layer) in energy.ledger.layers.iter().enumerate() {
            assert_eq!(energies.double(row, &format!("layers_{i}_friction_j")), layer.friction_j.to_bits());
        }
    }
    let tents = table("tents.csv");
    assert!(!recording.tents.is_empty() && tents.rows.len() == recording.tents.len());
    for (row, tent) in recording.tents.iter().enumerate() {
        for (i, value) in tent.tent_m.iter().enumerate() {
            assert_eq!(tents.float(row, &format!("tent_{i}_m")), value.to_bits());
        }
    }
}

#[test]
fn a_summary_spans_its_samples() {
    let (folder, recording) = exported("csv");
    let summary = Csv::read(&folder.path().join("attempt/summary.csv"));
    assert_eq!(summary.rows.len(), recording.samples.len().div_ceil(10));
    for (row, window) in recording.samples.chunks(10).enumerate() {
        let greatest = window.iter().map(|sample| sample.axial_n() as f32).fold(f32::NEG_INFINITY, f32::max);
        assert_eq!(summary.double(row, "t_s"), window[0].t_s.to_bits());
        assert_eq!(summary.text(row, "ticks"), window.len().to_string());
        assert_eq!(summary.float(row, "axial_max_n"), greatest.to_bits());
    }
}

/// The text that CSV has for a value of Parquet.
fn as_text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Double(value) => value.to_string(),
        Field::Float(value) => value.to_string(),
        Field::Long(value) => value.to_string(),
        Field::Str(value) => value.clone(),
        // No column holds anything else; this is no text of CSV.
        other => format!("{other:?}"),
    }
}

#[test]
fn parquet_holds_what_csv_holds() {
    let (folder, _) = exported("csv");
    let file = folder.path().join("attempt.mcap");
    let out = folder.path().join("tables");
    let run = stylet(&["export", text(&file), "--to", "parquet", "--out", text(&out), "--json"]).ends(0);
    assert_eq!(run.json().as_array().map(Vec::len), Some(TABLES.len()));
    for name in TABLES {
        let csv = Csv::read(&folder.path().join("attempt").join(name).with_extension("csv"));
        let parquet = File::open(out.join(name).with_extension("parquet")).expect("a table");
        let parquet = SerializedFileReader::new(parquet).expect("Parquet");
        let mut rows = 0;
        for row in parquet.get_row_iter(None).expect("rows") {
            let row = row.expect("a row");
            assert_eq!(row.len(), csv.places.len(), "{name}");
            for (column, field) in row.get_column_iter() {
                assert_eq!(as_text(field), csv.text(rows, column), "{name}, row {rows}, {column}");
            }
            rows += 1;
        }
        assert_eq!(rows, csv.rows.len(), "{name}");
    }
}

#[test]
fn tables_are_not_overwritten_unasked() {
    let (folder, _) = exported("csv");
    let (file, samples) = (folder.path().join("attempt.mcap"), folder.path().join("attempt/samples.csv"));
    fs::write(&samples, "mine").expect("written");
    stylet(&["export", text(&file), "--to", "csv"]).refused(&["samples.csv", "exists already", "--force"]);
    assert_eq!(fs::read_to_string(&samples).expect("a table"), "mine");
    stylet(&["export", text(&file), "--to", "csv", "--force"]).ends(0);
    assert!(fs::metadata(&samples).expect("a table").len() > 1000);
    assert_eq!(fs::read_dir(folder.path().join("attempt")).expect("a folder").count(), TABLES.len());
}

#[test]
fn what_cannot_be_exported_leaves_nothing_behind() {
    let (folder, file) = recorded();
    let (bad, out) = (folder.path().join("bad.mcap"), folder.path().join("bad"));
    fs::write(&bad, b"poem").expect("written");
    stylet(&["export", text(&bad), "--to", "csv"]).refused(&["bad.mcap"]);
    assert!(!out.exists());
    let mut bytes = fs::read(&file).expect("a recording");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0xff;
    fs::write(&bad, &bytes).expect("written");
    stylet(&["export", text(&bad), "--to", "parquet"]).refused(&["bad.mcap", "damaged"]);
    assert!(!out.exists());
    stylet(&["export", text(&file), "--to", "xlsx"]).refused(&["xlsx", "csv", "parquet"]);
    stylet(&["export", text(&file), "--to", "csv", "--out", text(&bad)]).refused(&["bad.mcap", "is a file"]);
    stylet(&["export", text(&file)]).refused(&["--to"]);
}

#[test]
fn a_cut_recording_is_exported_as_far_as_it_goes() {
    let (folder, file) = recorded();
    let cut = folder.path().join("cut.mcap");
    let bytes = fs::read(&file).expect("a recording");
    fs::write(&cut, &bytes[..bytes.len() * 3 / 4]).expect("written");
    let run = stylet(&["export", text(&cut), "--to", "csv"]).ends(0);
    run.says(&["cut.mcap", "the recording is truncated"]);
    let whole = Recording::read(bytes.as_slice()).expect("a recording").samples.len();
    let rows = Csv::read(&folder.path().join("cut/samples.csv")).rows.len();
    assert!(rows > whole / 4 && rows < whole, "{rows} of {whole}");
}
