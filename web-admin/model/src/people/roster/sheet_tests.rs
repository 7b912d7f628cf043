//! Workbooks as written by spreadsheets and programs. The tests check that hidden sheets are not
//! read, that cells are read as they are shown, and that files that are not workbooks get the right
//! error.

use std::io::{Cursor, Write};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;

/// Makes a zip archive.
fn archive(files: &[(&str, String)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, text) in files {
        zip.start_file(*name, stored).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
const RELATIONS: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";

/// Makes a workbook of sheets, each with its state and its XML from `<sheetData>` on. Cell style n
/// refers to format n of `formats`, from 1.
fn workbook(sheets: &[(&str, &str)], formats: &[&str]) -> Vec<u8> {
    let root = format!(
        r#"<Relationships><Relationship Id="r" Type="{RELATIONS}/officeDocument" Target="xl/workbook.xml"/></Relationships>"#
    );
    let mut files = vec![("[Content_Types].xml", "<Types/>".to_owned()), ("_rels/.rels", root)];
    let (mut list, mut links) = (String::new(), String::new());
    let paths: Vec<String> = (1..=sheets.len()).map(|n| format!("xl/worksheets/sheet{n}.xml")).collect();
    for (n, (state, body)) in (1..).zip(sheets) {
        list += &format!(r#"<sheet name="S{n}" sheetId="{n}" state="{state}" r:id="rId{n}"/>"#);
        links +=
            &format!(r#"<Relationship Id="rId{n}" Type="{RELATIONS}/worksheet" Target="worksheets/sheet{n}.xml"/>"#);
        files.push((&paths[n - 1], format!(r#"<worksheet xmlns="{MAIN}">{body}</worksheet>"#)));
    }
    let ids = 164..164 + formats.len();
    let number_formats: String = ids
        .clone()
        .zip(formats)
        .map(|(id, code)| format!(r#"<numFmt numFmtId="{id}" formatCode="{code}"/>"#))
        .collect();
    let cell_formats: String = ids.map(|id| format!(r#"<xf numFmtId="{id}"/>"#)).collect();
    files.push((
        "xl/workbook.xml",
        format!(r#"<workbook xmlns="{MAIN}" xmlns:r="{RELATIONS}"><sheets>{list}</sheets></workbook>"#),
    ));
    files.push(("xl/_rels/workbook.xml.rels", format!("<Relationships>{links}</Relationships>")));
    files.push((
        "xl/styles.xml",
        format!(
            r#"<styleSheet xmlns="{MAIN}"><numFmts>{number_formats}</numFmts><cellXfs><xf numFmtId="0"/>{cell_formats}</cellXfs></styleSheet>"#
        ),
    ));
    archive(&files)
}

/// Makes the XML of a sheet: cells with text, or with the given XML if it begins with `<`.
fn sheet(rows: &[&[&str]]) -> String {
    let cell = |text: &&str| match text.strip_prefix('<') {
        Some(_) => (*text).to_owned(),
        None => format!(r#"<c t="inlineStr"><is><t>{text}</t></is></c>"#),
    };
    let row = |cells: &&[&str]| format!("<row>{}</row>", cells.iter().map(cell).collect::<String>());
    format!("<sheetData>{}</sheetData>", rows.iter().map(row).collect::<String>())
}

fn list(name: &str) -> String {
    sheet(&[&["email", "name"], &[&format!("{name}@uni.example"), name]])
}

fn names(book: &[u8]) -> Vec<String> {
    read(book).unwrap().rows.into_iter().map(|row| row.entry.unwrap().name).collect()
}

#[test]
fn only_what_is_seen_is_read() {
    for hidden in ["hidden", "veryHidden"] {
        assert_eq!(names(&workbook(&[(hidden, &list("Old")), ("visible", &list("New"))], &[])), ["New"]);
        assert_eq!(read(&workbook(&[(hidden, &list("Old"))], &[])), Err(Unreadable::NoVisibleSheet));
    }
    assert_eq!(names(&workbook(&[("visible", &list("First")), ("visible", &list("Second"))], &[])), ["First"]);
}

#[test]
fn a_cell_is_read_as_it_is_shown() {
    let value = |style: usize, value: &str| format!(r#"<c s="{style}"><v>{value}</v></c>"#);
    for (format, stored, shown) in [
        ("0000000", "12345", "0012345"),
        ("00-00000", "12345", "00-12345"),
        ("General", "12345", "12345"),
        ("mmm-yy", "46296", "Oct-26"),
        ("h:mm", "0.416666666666667", "10:00"),
        ("0%", "0.5", "50%"),
        ("#,##0", "987654321012", "987654321012"),
    ] {
        let cell = value(1, stored);
        let rows = sheet(&[&["email", "name", "id", "cohort"], &["a@uni.example", "Ana", &cell, &cell]]);
        let entry = read(&workbook(&[("visible", &rows)], &[format])).unwrap().rows.remove(0).entry.unwrap();
        assert_eq!(
            (entry.registrar_id.as_deref(), entry.cohorts.as_slice()),
            (Some(shown), &[shown.to_owned()][..]),
            "{format}"
        );
    }
}

#[test]
fn a_merged_cell_is_said_of_every_line_beside_it() {
    let rows = sheet(&[
        &["email", "name", "cohort"],
        &["a@uni.example", "Ana", "Spring"],
        &["b@uni.example", "Bo", "<c/>"],
        &["c@uni.example", "Cy", "hidden below the merge"],
        &["d@uni.example", "Di", "Autumn"],
    ]);
    let body = format!(r#"{rows}<mergeCells count="1"><mergeCell ref="C2:C4"/></mergeCells>"#);
    let rows = read(&workbook(&[("visible", &body)], &[])).unwrap().rows;
    let cohorts: Vec<_> = rows.into_iter().map(|row| row.entry.unwrap().cohorts.join(", ")).collect();
    assert_eq!(cohorts, ["Spring", "Spring", "Spring", "Autumn"]);
}

#[test]
fn merged_cells_without_end_are_too_much() {
    let many = vec![["a@uni.example", "Ana"].as_slice(); 2000];
    let rows = sheet(&[&[["email", "name"].as_slice()], many.as_slice()].concat());
    let merges = r#"<mergeCell ref="C1:C2001"/>"#.repeat(1000);
    let body = format!("{rows}<mergeCells>{merges}</mergeCells>");
    assert_eq!(read(&workbook(&[("visible", &body)], &[])), Err(Unreadable::TooMuch));
}

#[test]
fn a_formula_without_a_result_is_refused_by_its_heading() {
    for (cell, solved) in [
        ("<c><f>LOWER(B2)</f><v></v></c>", false),
        ("<c><f>LOWER(B2)</f></c>", false),
        (r#"<c t="str"><f>LOWER(B2)</f><v>a@uni.example</v></c>"#, true),
    ] {
        let rows = sheet(&[&["E-Mail", "name", "note"], &[cell, "Ana", "<c><f>1+1</f></c>"]]);
        let row = read(&workbook(&[("visible", &rows)], &[])).unwrap().rows.remove(0);
        match row.entry {
            Ok(entry) => assert!(solved && entry.email == "a@uni.example", "{cell}"),
            Err(refused) => assert_eq!((refused.refusal, solved), (Refusal::Unsolved("E-Mail".to_owned()), false)),
        }
    }
}

#[test]
fn what_is_no_workbook_is_called_what_it_is() {
    let file = |name: &'static str| (name, String::new());
    let told = |files: &[(&str, String)]| read(&archive(files)).unwrap_err();
    assert_eq!(
        told(&[file("manifest.csv"), file("orgs.csv"), file("users.csv")]),
        Unreadable::Archive(Some("users.csv".to_owned())),
        "OneRoster"
    );
    assert_eq!(told(&[file("list.txt")]), Unreadable::Archive(None));
    assert_eq!(told(&[file("mimetype"), file("content.xml")]), Unreadable::OpenDocument);
    assert_eq!(told(&[file("[Content_Types].xml"), file("xl/workbook.bin")]), Unreadable::BinaryExcel);
    let name: Vec<u8> = "EncryptedPackage".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let container = [&[0xD0, 0xCF, 0x11, 0xE0, 0xA1, 0xB1, 0x1A, 0xE1][..], &[0; 600], &name].concat();
    assert_eq!(read(&container), Err(Unreadable::Sealed));
}
