//! Questionnaires: what an answer may be, which questions are asked, and scores from answers by the instrument's own key.

mod answer;
mod score;

pub use answer::{Allowed, Answer, Found, Refused, asked_pages, is_asked, read_answer};
pub use score::{NoScore, Scorer, score_range, score_response};
