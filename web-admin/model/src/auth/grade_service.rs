//! Grades for learning platforms (LTI Assignment and Grade Services 2.0).

use serde::Deserialize;
use serde_json::{Value, json};
use url::Url;

use crate::Moment;
use crate::ids::AssignmentId;

/// Maximum score of a line item.
const MOST_POINTS: u32 = 100;

/// State of the delivery of a grade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum DeliveryState {
    /// The grade may have changed.
    Waiting,
    /// There is no grade.
    Idle,
    /// The platform has the grade.
    Sent,
    /// The platform has refused the grade.
    Stopped,
}

impl DeliveryState {
    /// Every state, in the order of the page.
    pub const ALL: [Self; 4] = [Self::Stopped, Self::Waiting, Self::Sent, Self::Idle];

    /// Returns the word used in the database and in addresses.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Idle => "idle",
            Self::Sent => "sent",
            Self::Stopped => "stopped",
        }
    }

    /// Returns the state of a word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.word() == word)
    }
}

/// What a link of a learning platform opens, if it has grades.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GradedPage {
    /// An assignment.
    Assignment(AssignmentId),
    /// An exercise.
    Exercise(String),
}

impl GradedPage {
    /// Returns what a path opens; `None` if it has no grades.
    #[must_use]
    pub fn of_path(path: &str) -> Option<Self> {
        if let Some(id) = path.strip_prefix("/assignments/") {
            return id.parse().ok().map(Self::Assignment);
        }
        path.strip_prefix("/exercises/").map(|id| Self::Exercise(id.to_owned()))
    }

    /// Returns the id by which the platform finds the line item.
    #[must_use]
    pub fn resource_id(&self) -> String {
        match self {
            Self::Assignment(id) => format!("assignment:{id}"),
            Self::Exercise(id) => format!("exercise:{id}"),
        }
    }
}

/// The attempt to which a grade refers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubmittedAttempt {
    /// Its beginning.
    pub started_at: Moment,
    /// Its end.
    pub submitted_at: Moment,
    /// Address of its page.
    pub address: String,
}

/// The grade of a user.
#[derive(Clone, Debug, PartialEq)]
pub enum SentGrade {
    /// The score that counts, 0–100.
    Score(f64, SubmittedAttempt),
    /// The supervision of the attempt is not confirmed yet.
    Pending(SubmittedAttempt),
    /// The grade that was sent counts no longer.
    Withdrawn,
}

impl SentGrade {
    /// Returns the message about a user, without its timestamp.
    #[must_use]
    pub fn message(&self, subject: &str) -> Value {
        let mut message = json!({ "userId": subject, "activityProgress": "Completed" });
        let attempt = match self {
            Self::Score(score, attempt) => {
                message["scoreGiven"] = json!((score * 1e6).round() / 1e6);
                message["scoreMaximum"] = json!(MOST_POINTS);
                message["gradingProgress"] = json!("FullyGraded");
                attempt
            }
            Self::Pending(attempt) => {
                message["gradingProgress"] = json!("PendingManual");
                attempt
            }
            Self::Withdrawn => {
                message["activityProgress"] = json!("Initialized");
                message["gradingProgress"] = json!("NotReady");
                return message;
            }
        };
        let [started, submitted] = [attempt.started_at, attempt.submitted_at].map(format_time);
        message["submission"] = json!({ "startedAt": started, "submittedAt": submitted });
        message["comment"] = json!(attempt.address);
        message
    }
}

/// Returns the timestamp of a message: now, and later than the last one, in whole ms.
#[must_use]
pub fn next_timestamp(now: Moment, last: Option<Moment>) -> Moment {
    let of_ms = |moment: Moment| moment.micros().div_euclid(1000);
    let earliest = last.map_or(i64::MIN, |last| of_ms(last) + 1);
    Moment::from_micros(of_ms(now).max(earliest) * 1000)
}

/// Adds the timestamp to a message.
#[must_use]
pub fn stamp_message(mut message: Value, timestamp: Moment) -> Value {
    message["timestamp"] = json!(format_time(timestamp));
    message
}

/// Formats a moment with ms: platforms compare timestamps as texts.
fn format_time(moment: Moment) -> String {
    let utc = moment.to_utc();
    let (date, (hour, minute, second, ms)) = (utc.date(), utc.time().as_hms_milli());
    format!("{date}T{hour:02}:{minute:02}:{second:02}.{ms:03}Z")
}

/// Returns the address to which scores of a line item are posted. It may have a query.
#[must_use]
pub fn scores_url(line_item: &str) -> Option<String> {
    let mut url = Url::parse(line_item).ok()?;
    url.path_segments_mut().ok()?.pop_if_empty().push("scores");
    Some(url.into())
}

/// Returns the address that lists the line items with a resource id.
#[must_use]
pub fn search_url(line_items: &str, resource_id: &str) -> Option<String> {
    let mut url = Url::parse(line_items).ok()?;
    url.query_pairs_mut().append_pair("resource_id", resource_id);
    Some(url.into())
}

/// A line item, as a platform describes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct LineItem {
    /// Address.
    pub id: String,
    #[serde(default)]
    resource_id: Option<String>,
    #[serde(default)]
    resource_link_id: Option<String>,
}

impl LineItem {
    /// Returns whether it is for a resource, and for no other link than this one. Some platforms
    /// list more than was asked for.
    #[must_use]
    pub fn is_for(&self, resource_id: &str, link: &str) -> bool {
        self.resource_id.as_deref() == Some(resource_id) && self.resource_link_id.as_deref().is_none_or(|id| id == link)
    }
}

/// Describes a new line item.
#[must_use]
pub fn describe_line_item(label: &str, resource_id: &str, link: &str) -> Value {
    json!({ "label": label, "scoreMaximum": MOST_POINTS, "resourceId": resource_id, "resourceLinkId": link })
}

/// Returns whether a refusal, by HTTP status and answer, means that another try is useless. Older
/// versions of Canvas answer too many requests with 403.
#[must_use]
pub fn is_final(status: u16, answer: &str) -> bool {
    match status {
        403 => !answer.contains("Rate Limit Exceeded"),
        status => matches!(status, 404 | 410 | 422),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_go_before_the_query() {
        for (line_item, scores) in [
            ("https://a.example/items/7", "https://a.example/items/7/scores"),
            ("https://a.example/items/7/", "https://a.example/items/7/scores"),
            ("https://a.example/7/lineitem?type_id=1", "https://a.example/7/lineitem/scores?type_id=1"),
            ("https://a.example/a%2Fb?x=a/b", "https://a.example/a%2Fb/scores?x=a/b"),
        ] {
            assert_eq!(scores_url(line_item).as_deref(), Some(scores));
        }
        assert_eq!(scores_url("mailto:a@b.example"), None);
        let found = search_url("https://a.example/items?type=1", "exercise:a b").unwrap();
        assert_eq!(found, "https://a.example/items?type=1&resource_id=exercise%3Aa+b");
    }

    #[test]
    fn timestamps_rise_by_a_millisecond_at_least() {
        let at = Moment::from_micros;
        assert_eq!(next_timestamp(at(5_000_700), None), at(5_000_000));
        assert_eq!(next_timestamp(at(5_000_700), Some(at(5_000_000))), at(5_001_000));
        assert_eq!(next_timestamp(at(1_000_000), Some(at(5_000_000))), at(5_001_000), "the clock was set back");
        assert_eq!(next_timestamp(at(9_000_000), Some(at(5_000_000))), at(9_000_000));
        assert_eq!(stamp_message(json!({}), at(1_500_000))["timestamp"], "1970-01-01T00:00:01.500Z");
        assert_eq!(stamp_message(json!({}), at(2_000_000))["timestamp"], "1970-01-01T00:00:02.000Z");
    }

    #[test]
    fn only_a_score_that_counts_is_given() {
        let attempt = || SubmittedAttempt {
            started_at: Moment::from_micros(0),
            submitted_at: Moment::from_micros(61_250_000),
            address: "https://training.example.org/sessions/1".to_owned(),
        };
        let score = SentGrade::Score(100.0 / 12.0, attempt()).message("7");
        assert_eq!(score["scoreGiven"].to_string(), "8.333333");
        assert_eq!((&score["scoreMaximum"], &score["gradingProgress"]), (&json!(100), &json!("FullyGraded")));
        assert_eq!(score["submission"]["submittedAt"], "1970-01-01T00:01:01.250Z");
        let pending = SentGrade::Pending(attempt()).message("7");
        assert_eq!((&pending["scoreGiven"], &pending["gradingProgress"]), (&Value::Null, &json!("PendingManual")));
        let withdrawn = SentGrade::Withdrawn.message("7");
        assert_eq!((&withdrawn["scoreGiven"], &withdrawn["gradingProgress"]), (&Value::Null, &json!("NotReady")));
    }

    #[test]
    fn a_line_item_of_another_link_is_not_used() {
        let item = |json: Value| serde_json::from_value::<LineItem>(json).unwrap();
        let own = item(json!({ "id": "u", "resourceId": "exercise:a", "resourceLinkId": "1", "scoreMaximum": 100 }));
        assert!(own.is_for("exercise:a", "1") && !own.is_for("exercise:a", "2") && !own.is_for("exercise:b", "1"));
        assert!(item(json!({ "id": "u", "resourceId": "exercise:a" })).is_for("exercise:a", "2"));
        assert!(!item(json!({ "id": "u" })).is_for("exercise:a", "2"));
    }

    #[test]
    fn a_refusal_is_final_unless_requests_were_too_many() {
        let of = |status| is_final(status, "403 Forbidden (Rate Limit Exceeded)");
        assert!([403, 404, 410, 422].iter().all(|&status| is_final(status, "Forbidden")));
        assert!(![400, 401, 403, 409, 429, 500, 503].iter().any(|&status| of(status)));
        assert!(of(404));
    }
}
