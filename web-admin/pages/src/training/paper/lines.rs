//! Line breaks.

use super::fonts::{Fonts, Shaped};

/// Breaks a text into lines of at most `width` em: at spaces, and inside words that are longer than a
/// line. An empty text has no line.
pub(super) fn break_lines(fonts: &Fonts, text: &str, fixed: bool, width: f32) -> Vec<Shaped> {
    let space = fonts.shape(" ", fixed).width();
    let mut lines: Vec<String> = Vec::new();
    let mut used = f32::INFINITY;
    for word in text.split_whitespace().flat_map(|word| split_word(fonts, word, fixed, width)) {
        let long = fonts.shape(&word, fixed).width();
        match lines.last_mut() {
            Some(line) if used + space + long <= width => {
                line.push(' ');
                line.push_str(&word);
                used += space + long;
            }
            _ => {
                lines.push(word);
                used = long;
            }
        }
    }
    lines.iter().map(|line| fonts.shape(line, fixed)).collect()
}

/// Splits a word that is longer than a line.
fn split_word(fonts: &Fonts, word: &str, fixed: bool, width: f32) -> Vec<String> {
    if fonts.shape(word, fixed).width() <= width {
        return vec![word.to_owned()];
    }
    let mut parts = vec![String::new()];
    let mut used = 0.0;
    for c in word.chars() {
        let wide = fonts.shape(c.encode_utf8(&mut [0; 4]), fixed).width();
        if used + wide > width && used > 0.0 {
            parts.push(String::new());
            used = 0.0;
        }
        used += wide;
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts
}
