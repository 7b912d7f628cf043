//! Questionnaires: what an answer may be, which questions are asked, and scores from answers by the instrument's own key.

mod answer;
mod score;

pub use answer::{Answer, Refused, is_asked, read_answer};
pub use score::{NoScore, item_counts, range, score};
