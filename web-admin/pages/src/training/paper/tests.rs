//! A paper must be written whatever its names are, and the same paper must give the same bytes.

use super::fonts::REPLACEMENT;
use super::*;
use crate::samples;

fn paper(blocks: Vec<Block>) -> Paper {
    Paper { title: "Paper".to_owned(), language: "de", made_at: samples::NOW, logo: None, blocks, attachment: None }
}

fn named(name: &str) -> Paper {
    let cell = name.to_owned();
    let column = |percent| PaperColumn { title: cell.clone(), percent };
    paper(vec![
        Block::Heading(1, cell.clone()),
        Block::Text(Style::Name, cell.clone()),
        Block::Table(PaperTable {
            columns: vec![column(60), column(40)],
            rows: vec![vec![cell.clone(), cell.clone()]],
        }),
        Block::Code { content: "https://stylet.example".to_owned(), alt: "code".to_owned(), text: cell.clone() },
        Block::Signature { name: cell.clone(), function: cell },
    ])
}

#[test]
fn any_name_gives_a_conforming_paper() {
    let hostile = [
        "",
        " ",
        "Ada Größer-Łukasiewicz, Αθηνά Ёлкина",
        "محمد بن سلمان 李小龙 ひらがな 한국어 हिन्दी ไทย",
        "👩🏽‍⚕️🩺 🇩🇪 ☕︎ 💉💉",
        "a\u{301}\u{301}\u{301}\u{301}\u{301}\u{301} \u{202e}gnissim\u{202c} \u{feff}\u{fffe}\u{0}\u{7}",
        "\u{e000}\u{f8ff}\u{10ffff}\u{fffd}\n\t\r\u{2028}",
        "fi ffl ﬁ ﬂ soft\u{ad}hyphen no\u{a0}break <script>()\\",
        "{\"statement\":",
    ];
    let names = hostile.map(str::to_owned).into_iter().chain(["W".repeat(200), "ab ".repeat(200), "李".repeat(100)]);
    // One paper with all of them: in a debug build each takes half a second.
    let all = paper(names.flat_map(|name| named(&name).blocks).collect());
    let pdf = all.to_pdf().unwrap_or_else(|error| panic!("{error}"));
    assert!(pdf.starts_with(b"%PDF-1.7"));
}

#[test]
fn the_same_paper_gives_the_same_bytes() {
    let one = named("Ada 💉 李");
    assert_eq!(one.to_pdf(), one.to_pdf());
    assert_ne!(one.to_pdf(), named("Bo").to_pdf());
}

#[test]
fn a_missing_character_is_stated_once() {
    let fonts = fonts::Fonts::load().expect("fonts");
    let layout = |paper: &Paper| layout::lay_out(&paper.blocks, None, &fonts);
    assert!(layout(&named("李")).replaced && !layout(&named("Größer 💉 \u{200d}")).replaced);
    let shaped = fonts.shape("A李\u{e000}", false);
    let text: String = shaped.runs.iter().map(|run| run.text.as_str()).collect();
    assert_eq!(text, "A李□", "what is copied is complete");
    let [boxed] = [REPLACEMENT.to_string()].map(|text| fonts.shape(&text, false).runs[0].glyphs[0].glyph_id);
    assert!(shaped.replaced && shaped.runs[1].glyphs.iter().all(|glyph| glyph.glyph_id == boxed));
}

#[test]
fn forty_rows_are_whole_and_headed_on_every_sheet() {
    let row = |n: usize| vec![format!("Exercise {n} {}", "with a long title ".repeat(3)), "2 March 2026".to_owned()];
    let column = |title: &str| PaperColumn { title: title.to_owned(), percent: 50 };
    let table =
        PaperTable { columns: vec![column("Exercise"), column("Mastered on")], rows: (1..=60).map(row).collect() };
    let fonts = fonts::Fonts::load().expect("fonts");
    let layout = layout::lay_out(&[Block::Table(table)], None, &fonts);
    assert!(layout.sheets.len() > 1);
    let lowest = layout::SHEET_HEIGHT - 40.0;
    let mut rows = 0;
    for sheet in &layout.sheets {
        let texts: Vec<(String, f32)> = sheet.iter().filter_map(text_of).collect();
        assert_eq!(texts[0].0, "Exercise", "{texts:?}");
        assert!(texts.iter().all(|(_, y)| *y < lowest), "{texts:?}");
        rows += texts.iter().filter(|(text, _)| text.starts_with("Exercise ")).count();
    }
    assert_eq!(rows, 60);
}

fn text_of(mark: &layout::SheetMark) -> Option<(String, f32)> {
    let layout::SheetMark::Text { shaped, y, .. } = mark else { return None };
    Some((shaped.runs.iter().map(|run| run.text.as_str()).collect(), *y))
}
