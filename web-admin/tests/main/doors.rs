//! Visibility of attempts by route. Fails when a route shows an attempt to a visitor outside its list, and when a new path parameter is not
//! classified.

use axum::http::Method;

use crate::every_route::rows;

/// The objects of addresses by which an attempt is seen, and which visitors see it by them. Whoever is no trainee's teacher sees attempts in a
/// rating or a task, without a name; that a rater may know more is marked.
const SHOW_ATTEMPTS: [(&str, &[&str]); 7] = [
    ("session", &["own", "teacher", "admin"]),
    ("trainee", &["own", "teacher", "admin"]),
    ("cohort", &["teacher", "admin"]),
    ("exam", &["teacher", "admin"]),
    ("rating", &["colleague"]),
    ("task", &["same", "teacher", "admin"]),
    ("upload", &["own"]),
];
/// The other objects, by which no attempt is seen.
const SHOW_NONE: [&str; 34] = [
    "outcome",
    "asked",
    "asset",
    "assignment",
    "choice",
    "comment",
    "course",
    "delivery",
    "document",
    "draft",
    "exam_file",
    "exercise",
    "export",
    "file",
    "identity",
    "instrument",
    "join",
    "link",
    "list",
    "lms_course",
    "number",
    "picture",
    "pictured",
    "platform",
    "provider",
    "questionnaire",
    "regrading",
    "revision",
    "roster",
    "round",
    "station",
    "survey",
    "term",
    "trace",
];

#[test]
fn an_attempt_is_seen_by_no_door_but_those_that_are_known() {
    let is_known = |object: &str| {
        SHOW_NONE.contains(&object) || object == "unknown" || SHOW_ATTEMPTS.iter().any(|(known, _)| *known == object)
    };
    for row in rows() {
        let objects = row.path.split('{').skip(1).filter_map(|rest| rest.split('}').next());
        for object in objects {
            assert!(is_known(object), "{}: does {{{object}}} show an attempt, and to whom?", row.path);
            let Some((_, seen_by)) = SHOW_ATTEMPTS.iter().find(|(known, _)| *known == object) else { continue };
            if !matches!(row.method, Method::GET | Method::HEAD) {
                continue;
            }
            for (column, status) in &row.expected {
                let is_shown = status.split('/').any(|status| status.starts_with('2'));
                // A station asks which survey follows an attempt, and is told nothing of it.
                let is_asking = *column == "station" && row.path == "/api/v1/sessions/{session}/survey";
                assert!(
                    !is_shown || is_asking || seen_by.contains(column),
                    "{}: {column} is answered {status}",
                    row.path
                );
            }
        }
    }
}
