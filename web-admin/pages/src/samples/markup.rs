//! Requirements on the markup of every page, beyond what browsers enforce: heading levels are not
//! skipped, and times have a valid HTML format. Every sample page is checked.

/// Checks a page.
pub(crate) fn check_markup(name: &str, html: &str) {
    let levels = heading_levels(html);
    let skips = levels.windows(2).any(|pair| pair[1] > pair[0] + 1);
    assert!(!skips, "{name} skips a level of headings: {levels:?}");
    for time in attribute_values(html, "datetime") {
        assert!(is_machine_time(time), "{name}: datetime=\"{time}\"");
    }
}

/// Returns the levels of the headings in order, with 0 first for a complete page, whose first
/// heading must have level 1.
fn heading_levels(html: &str) -> Vec<u32> {
    let levels = html.split("<h").skip(1).filter_map(|rest| {
        let mut start = rest.chars();
        let level = start.next()?.to_digit(10)?;
        matches!(start.next(), Some('>' | ' ')).then_some(level)
    });
    let outside = html.starts_with("<!doctype").then_some(0);
    outside.into_iter().chain(levels).collect()
}

/// Returns the values of an attribute.
fn attribute_values<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let opening = format!(" {name}=\"");
    html.split(opening.as_str()).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// Returns whether the text is a date and time with offset and at most three decimals of a second:
/// "a valid global date and time string" in HTML.
fn is_machine_time(text: &str) -> bool {
    let Some((date, rest)) = text.split_once('T') else { return false };
    let (time, offset) = rest.split_at(rest.find(['Z', '+', '-']).unwrap_or(rest.len()));
    let (whole, fraction) = time.split_once('.').unwrap_or((time, "0"));
    let like = |text: &str, pattern: &str| {
        text.len() == pattern.len()
            && text
                .bytes()
                .zip(pattern.bytes())
                .all(|(byte, p)| if p == b'0' { byte.is_ascii_digit() } else { byte == p })
    };
    let fraction_is_short = (1..=3).contains(&fraction.len()) && fraction.bytes().all(|byte| byte.is_ascii_digit());
    let offset_is_known = offset == "Z" || ["+00:00", "-00:00"].iter().any(|pattern| like(offset, pattern));
    like(date, "0000-00-00") && like(whole, "00:00:00") && fraction_is_short && offset_is_known
}

#[cfg(test)]
mod tests {
    //! The check must find invalid markup, and accept valid markup.

    use super::*;

    #[test]
    fn a_skipped_level_and_a_time_too_fine_are_found() {
        assert_eq!(heading_levels("<!doctype html><header><h1>A</h1><h3 class=\"b\">B</h3><hr>"), [0, 1, 3]);
        assert_eq!(heading_levels("<h2>B</h2><html><h2>C</h2>"), [2, 2]);
        for fine in ["2026-03-02T09:05:01Z", "2026-03-02T09:05:01.987Z", "2026-11-30T18:00:00+01:00"] {
            assert!(is_machine_time(fine), "{fine}");
        }
        for wrong in
            ["2026-03-02T09:05:01.987654Z", "2026-03-02 09:05Z", "2026-03-02T09:05:01", "2026-03-02T09:05:01.Z"]
        {
            assert!(!is_machine_time(wrong), "{wrong}");
        }
    }
}
