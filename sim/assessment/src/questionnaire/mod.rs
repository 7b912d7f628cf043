//! Questionnaires: validation of answers, conditional questions, and scores by the instrument's
//! key.

mod answer;
mod score;

pub use answer::{Allowed, Answer, Found, Refused, asked_pages, is_asked, read_answer};
pub use score::{NoScore, Scorer, score_range, score_response};
