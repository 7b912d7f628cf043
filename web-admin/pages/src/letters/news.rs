//! News for a user, on the home page and by email.

use model::letters::notice::{Notice, NoticeKind};
use model::surveys::Survey;
use time::OffsetDateTime;

/// A news item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewsItem {
    /// Description.
    pub words: String,
    /// Address of the page it leads to.
    pub href: String,
    /// Time of the event.
    pub at: OffsetDateTime,
}

impl NewsItem {
    /// Creates an item from a notice.
    #[must_use]
    pub fn new(notice: &Notice) -> Self {
        let Notice { by, title, .. } = notice;
        let words = match notice.kind {
            NoticeKind::Comment => tr!("{name} has commented on your attempt at “{title}”", name = by, title = title),
            NoticeKind::Question => {
                tr!("{name} has a question about an attempt at “{title}”", name = by, title = title)
            }
            NoticeKind::Answer => tr!("{name} has answered a comment on “{title}”", name = by, title = title),
            NoticeKind::Override => {
                tr!("{name} has overridden the score of your attempt at “{title}”", name = by, title = title)
            }
            NoticeKind::Rating if notice.session_id.is_some() => {
                tr!("Your attempt at “{title}” was rated", title = title)
            }
            NoticeKind::Rating => tr!("All raters have finished: “{title}”", title = title),
            NoticeKind::Assignment => tr!("{name} has assigned “{title}” to you", name = by, title = title),
            NoticeKind::Delivery => {
                tr!("The learning platform has refused the grade of {name} in “{title}”", name = by, title = title)
            }
            NoticeKind::Message => tr!("{name} has written to you: “{title}”", name = by, title = title),
        };
        Self { words, href: notice.href(), at: notice.made_at.to_utc() }
    }

    /// Creates an item for a study invitation.
    #[must_use]
    pub fn of_study(owner: &str, title: &str, at: OffsetDateTime) -> Self {
        let words = tr!("{name} invites you to the study “{title}”", name = owner, title = title);
        Self { words, href: "/account/studies".to_owned(), at }
    }

    /// A survey waits for the visitor's answers.
    #[must_use]
    pub fn of_survey(survey: &Survey) -> Self {
        let words = tr!("A survey is waiting for your answers: “{title}”", title = survey.title);
        Self { words, href: format!("/surveys/{}", survey.id), at: survey.opens_at.to_utc() }
    }

    /// Notices in words: what one person did several times on the same page is one item, the newest.
    #[must_use]
    pub fn list(notices: &[Notice]) -> Vec<Self> {
        let is_same = |a: &Notice, b: &Notice| {
            (a.kind, a.session_id, a.round_id, &a.by, &a.title) == (b.kind, b.session_id, b.round_id, &b.by, &b.title)
        };
        let mut items = Vec::new();
        for (at, notice) in notices.iter().enumerate() {
            if notices[..at].iter().any(|before| is_same(before, notice)) {
                continue;
            }
            let times = notices[at..].iter().filter(|other| is_same(other, notice)).count();
            let item = Self::new(notice);
            items.push(match times {
                1 => item,
                _ => Self { words: tr!("{what} ({n} times)", what = item.words, n = times), ..item },
            });
        }
        items
    }
}

/// That somebody waits for the visitor's ratings of so many attempts, in words.
#[must_use]
pub fn say_waiting_ratings(by: &str, title: &str, attempts: u32) -> String {
    trn!(
        "{name} asks you to rate {n} attempt: “{title}”",
        "{name} asks you to rate {n} attempts: “{title}”",
        attempts,
        name = by,
        title = title
    )
}

#[cfg(test)]
mod tests {
    //! Each kind must name the person and the title, and link to its page.

    use model::Moment;
    use model::ids::SessionId;

    use super::*;

    #[test]
    fn each_kind_says_who_and_what() {
        let notice = |kind| Notice {
            kind,
            by: "Dr Osei".to_owned(),
            session_id: Some(SessionId::nil()),
            comment_id: None,
            from_s: None,
            round_id: None,
            title: "Stop in the fat".to_owned(),
            made_at: Moment::from_micros(0),
        };
        for kind in [NoticeKind::Comment, NoticeKind::Question, NoticeKind::Answer, NoticeKind::Override] {
            let item = NewsItem::new(&notice(kind));
            assert!(item.words.contains("Dr Osei") && item.words.contains("Stop in the fat"), "{}", item.words);
            assert!(item.href.starts_with("/sessions/"), "{}", item.href);
        }
        let several = [NoticeKind::Comment, NoticeKind::Answer, NoticeKind::Comment].map(notice);
        let items = NewsItem::list(&several);
        assert_eq!(items.len(), 2);
        assert!(items[0].words.ends_with("(2 times)"), "{}", items[0].words);
    }
}
