//! States as a word, an icon and a colour: never by colour alone.

use askama::Template;

/// State of an attempt, an exercise or a trainee.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusWord {
    /// An attempt at or above the pass mark, without a hard fail.
    Passed,
    /// An attempt that was not passed.
    Failed,
    /// An attempt in the queue.
    Waiting,
    /// A recording that could not be scored.
    Refused,
    /// An exercise whose mastery rule was met.
    Mastered,
    /// An exercise being practised.
    Current,
    /// An exercise that may be practised.
    Open,
    /// An exercise whose prerequisites are not mastered.
    Locked,
    /// An exercise that was mastered and whose mastery was lost.
    Regressing,
    /// A trainee who may need help.
    Help,
    /// A trainee without concerns.
    OnTrack,
    /// A trainee who has not tried anything of the course.
    NotBegun,
    /// A trainee who has mastered the course.
    Complete,
}

/// The badge of a state.
#[derive(Debug, Template)]
#[template(path = "parts/badge.html")]
struct Badge<'a> {
    tone: &'static str,
    icon: &'static str,
    word: &'a str,
}

impl StatusWord {
    /// Returns the word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => tr!("Passed"),
            Self::Failed => tr!("Not passed"),
            Self::Waiting => tr!("Being scored"),
            Self::Refused => tr!("Not scored"),
            Self::Mastered => tr!("Mastered"),
            Self::Current => tr!("Next"),
            Self::Open => tr!("Open"),
            Self::Locked => tr!("Locked"),
            Self::Regressing => tr!("Regressing"),
            Self::Help => tr!("Needs help"),
            Self::OnTrack => tr!("On track"),
            Self::NotBegun => tr!("Not started"),
            Self::Complete => tr!("Course mastered"),
        }
    }

    /// Returns the class of the colour.
    #[must_use]
    pub fn tone(self) -> &'static str {
        match self {
            Self::Passed | Self::Mastered | Self::Complete => "good",
            Self::Failed | Self::Refused => "bad",
            Self::Help | Self::Regressing => "warn",
            Self::Current => "lead",
            Self::Waiting | Self::Open | Self::Locked | Self::OnTrack | Self::NotBegun => "quiet",
        }
    }

    /// Returns the path of the icon, in a 16 × 16 square.
    fn icon(self) -> &'static str {
        match self {
            Self::Passed | Self::Mastered | Self::Complete => "M3 8.5l3.2 3.2L13 5",
            Self::Failed | Self::Refused => "M4 4l8 8M12 4l-8 8",
            Self::Help => "M8 2.5v7M8 12.2v1.3",
            Self::Current => "M3 8h9M8.5 4.5L12 8l-3.5 3.5",
            Self::Waiting => "M8 2.5a5.5 5.5 0 1 0 0 11a5.5 5.5 0 1 0 0-11M8 5v3.2l2 1.3",
            Self::Regressing => "M3 4.5l4 4 2-2 4 5M13 8v3.5H9.5",
            Self::Open | Self::OnTrack | Self::NotBegun => "M8 4.5a3.5 3.5 0 1 0 0 7a3.5 3.5 0 1 0 0-7",
            Self::Locked => "M4 7.5h8v6H4zM5.5 7.5V5.3a2.5 2.5 0 0 1 5 0v2.2",
        }
    }

    /// Returns the badge with the state's own word.
    #[must_use]
    pub fn badge(self) -> String {
        self.badge_saying(self.word())
    }

    /// Returns the badge with another word.
    #[must_use]
    pub fn badge_saying(self, word: &str) -> String {
        // Rendering this template into a `String` cannot fail; without the badge the page would
        // still be usable.
        Badge { tone: self.tone(), icon: self.icon(), word }.render().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_has_word_icon_and_tone_and_escapes_its_word() {
        let html = StatusWord::Help.badge_saying("Stuck <b>");
        assert!(html.contains("warn") && html.contains("<path") && html.contains("Stuck &#60;b&#62;"), "{html}");
    }
}
