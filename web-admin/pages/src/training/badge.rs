//! The picture of a badge, which contains the badge.

use askama::Template;
use time::OffsetDateTime;

use crate::format;

/// A picture of a badge, in the language of the trainee.
#[derive(Clone, Debug, Template)]
#[template(path = "training/badge.svg", escape = "html")]
pub struct BadgePicture<'a> {
    /// Name of the school.
    pub school: &'a str,
    /// Title of the course.
    pub course: &'a str,
    /// Time from which the course is mastered.
    pub mastered_at: OffsetDateTime,
    /// The signed badge as an element of SVG.
    pub baked: String,
}

/// A line of text in the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PictureLine {
    /// Vertical position of its baseline.
    y: usize,
    text: String,
}

/// Room for a text.
#[derive(Clone, Copy, Debug)]
struct TextRoom {
    /// Width, in Latin letters.
    letters: usize,
    /// Number of lines.
    lines: usize,
    /// Vertical position of the middle line's baseline.
    middle: usize,
    /// Distance of the lines.
    step: usize,
}

const TITLE: TextRoom = TextRoom { letters: 23, lines: 3, middle: 244, step: 30 };
const SCHOOL: TextRoom = TextRoom { letters: 28, lines: 2, middle: 322, step: 19 };

impl BadgePicture<'_> {
    fn label(&self) -> String {
        format!("{}: {}", tr!("Course mastered"), visible(self.course))
    }

    fn title_lines(&self) -> Vec<PictureLine> {
        TITLE.place(self.course)
    }

    fn school_lines(&self) -> Vec<PictureLine> {
        SCHOOL.place(self.school)
    }
}

impl TextRoom {
    /// Breaks a text into lines around the middle one. A text that is too long ends with an ellipsis.
    fn place(self, text: &str) -> Vec<PictureLine> {
        let text = visible(text);
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if width(line) + 1 + width(word) <= self.letters => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        let complete = lines.len() <= self.lines;
        lines.truncate(self.lines);
        if let Some(last) = lines.last_mut().filter(|_| !complete) {
            last.push('…');
        }
        let first = self.middle - self.step * (lines.len().max(1) - 1) / 2;
        let lines = lines.into_iter().enumerate();
        lines.map(|(i, line)| PictureLine { y: first + i * self.step, text: shorten(&line, self.letters) }).collect()
    }
}

/// Cuts a line to a width.
fn shorten(line: &str, letters: usize) -> String {
    if width(line) <= letters {
        return line.to_owned();
    }
    let mut kept = String::new();
    for c in line.chars() {
        if width(&kept) + width_of(c) >= letters {
            break;
        }
        kept.push(c);
    }
    kept + "…"
}

fn width(text: &str) -> usize {
    text.chars().map(width_of).sum()
}

/// Returns the approximate width of a character: those of other scripts and emoji are wide.
const fn width_of(c: char) -> usize {
    if (c as u32) < 0x1100 { 1 } else { 2 }
}

/// Replaces characters that XML does not allow.
fn visible(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    //! A picture that is not XML, or in which a name becomes markup, would lose the badge.

    use super::*;
    use crate::samples;

    fn draw(school: &str, course: &str) -> String {
        let baked = "<openbadges:credential><![CDATA[{\"a\":\"<b>\"}]]></openbadges:credential>".to_owned();
        BadgePicture { school, course, mastered_at: samples::NOW, baked }.render().expect("a picture")
    }

    #[test]
    fn a_picture_shows_course_school_and_day() {
        let svg = draw("University Hospital North", "Lumbar puncture");
        for shown in [
            "Course mastered",
            ">Lumbar puncture</text>",
            ">University Hospital North</text>",
            "<![CDATA[{\"a\":\"<b>\"}]]>",
        ] {
            assert!(svg.contains(shown), "{shown}: {svg}");
        }
        assert!(svg.starts_with("<svg ") && svg.find("<openbadges:credential>") < svg.find("<title"), "{svg}");
        assert!(!svg.contains("href") && !svg.contains("<style"), "it needs nothing else");
    }

    #[test]
    fn a_name_never_becomes_markup_of_a_picture() {
        let svg = draw("<b>\u{1}\u{ffff}</svg> & \"S\"", "]]></text><script>alert(1)</script>");
        assert_eq!(svg.matches('<').count(), draw("x", "x").matches('<').count(), "{svg}");
        assert!(!svg.contains(['\u{1}', '\u{ffff}']), "{svg}");
    }

    #[test]
    fn long_names_are_broken_and_cut() {
        let texts = |room: TextRoom, text: &str| room.place(text).into_iter().map(|l| l.text).collect::<Vec<_>>();
        let title = "Percutaneous access to the kidney under fluoroscopy with respiratory motion of the patient";
        assert_eq!(texts(TITLE, title), ["Percutaneous access to", "the kidney under", "fluoroscopy with…"]);
        assert_eq!(texts(TITLE, "Donaudampfschifffahrtselektrizitäten"), ["Donaudampfschifffahrts…"]);
        assert_eq!(texts(TITLE, ""), Vec::<String>::new());
        let school = "Universitätsklinikum des Landes, Zentrum für klinisches Training und Simulation";
        assert_eq!(texts(SCHOOL, school), ["Universitätsklinikum des", "Landes, Zentrum für…"]);
    }
}
