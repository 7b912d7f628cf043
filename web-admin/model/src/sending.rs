//! Records that are sent to other services: answers, and delays between tries.

/// Maximum length of an answer that is shown, in characters.
const LONGEST_ANSWER: usize = 500;

/// Returns the beginning of the answer of another service, on one line.
#[must_use]
pub fn shorten_answer(body: &[u8]) -> String {
    let text = String::from_utf8_lossy(body);
    let words: Vec<_> =
        text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty()).collect();
    words.join(" ").chars().take(LONGEST_ANSWER).collect()
}

/// Delay before the next try after so many, in s; `None` if there is none. After the first day, a
/// record is sent daily for two weeks.
#[must_use]
pub const fn retry_delay_s(tries: u32) -> Option<i64> {
    match tries {
        0 | 1 => Some(60),
        2 => Some(5 * 60),
        3 => Some(30 * 60),
        4 => Some(2 * 3600),
        5 => Some(12 * 3600),
        6..=19 => Some(24 * 3600),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_short_and_on_one_line() {
        assert_eq!(shorten_answer(b"<p>\r\n no\0\xff</p>"), "<p> no \u{fffd}</p>");
        assert_eq!(shorten_answer("ä".repeat(9000).as_bytes()).chars().count(), 500);
    }

    #[test]
    fn tries_end_after_two_weeks() {
        let delays: Vec<_> = (1..30).map_while(retry_delay_s).collect();
        assert_eq!(delays[..6], [60, 300, 1800, 7200, 43_200, 86_400]);
        assert_eq!(delays[5..].iter().sum::<i64>(), 14 * 86_400);
    }
}
