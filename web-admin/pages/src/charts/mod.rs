//! Charts as SVG, rendered on the server.
//!
//! Colours are classes that the style sheet resolves, so that one chart serves light mode, dark
//! mode and print, and no inline style is needed. Every chart has a title and a description, and
//! every difference in colour has a second cue.

mod bars;
mod boxes;
mod corridor;
mod cross_section;
mod damage;
mod drawing;
mod force_depth;
mod labels;
mod learning;
mod likert;
mod marks;
mod means;
mod plot;
mod progress;
mod scale;
mod scatter;
mod svg;
mod time;
mod trace;
mod weeks;

pub use bars::{draw_attempts_by_day, draw_score_among_others, draw_spread};
pub use boxes::{BoxRow, draw_boxes};
pub use corridor::{draw_corridor, find_deepest};
pub use cross_section::{CrossSection, SectionPoint, SectionStructure, StructureOutline, draw_cross_section};
pub use damage::{LayerDamage, draw_damage};
pub use drawing::{Drawing, MarkRow, StageRow, moment_href};
pub use force_depth::draw_force_over_depth;
pub use learning::draw_learning_curve;
pub use likert::{LikertBar, LikertItem, class_of_point, draw_diverging_bars};
pub use marks::number_marks;
pub use means::{MeansLine, draw_means};
pub use progress::{ScorePoint, draw_mastery_strip, draw_score_bar, draw_scores, draw_share_bar, draw_sparkline};
pub use scale::Extent;
pub use scatter::draw_scatter;
pub use time::draw_force_and_depth;
pub use trace::{LEFT as TRACE_LEFT, RIGHT as TRACE_RIGHT, TraceStrip, draw_trace_strip};
pub use weeks::{ShareLine, draw_shares};

/// Target width of a drawing. Text in an SVG scales with it, so phones get a drawing of their own;
/// the style sheet shows one of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawingSize {
    /// For desktop screens and paper.
    Wide,
    /// For phones.
    Narrow,
}

impl DrawingSize {
    /// Returns the class of the drawing, which is also the suffix of its ids.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Narrow => "narrow",
        }
    }

    /// Returns the width of the drawing, in CSS pixels at its natural size.
    #[must_use]
    pub fn width(self) -> f64 {
        match self {
            Self::Wide => 760.0,
            Self::Narrow => 340.0,
        }
    }

    /// Returns the maximum number of ticks on a horizontal axis.
    fn ticks(self) -> usize {
        match self {
            Self::Wide => 10,
            Self::Narrow => 5,
        }
    }
}

/// Draws a chart at both widths.
pub fn draw_both_widths(draw: impl Fn(DrawingSize) -> String) -> String {
    draw(DrawingSize::Wide) + &draw(DrawingSize::Narrow)
}

#[cfg(test)]
mod tests {
    //! Drawings are in the reader's language, including the text for screen readers.

    use assessment::learning::{CusumParams, Rule, learning_curve as learning};
    use model::scoring::corridor::corridor as corridor_of;

    use super::*;
    use crate::samples::untranslated_text::check_drawing;
    use crate::{anatomy, samples};

    #[test]
    fn drawings_of_an_attempt_speak_the_readers_language() {
        let curve = samples::curve();
        let experts = corridor_of(&curve, &vec![curve.clone(); 5]).expect("five are enough");
        check_drawing("force over depth", &(&curve, "III", "IV"), || {
            draw_force_over_depth(&anatomy::name_layers_of_curve(&curve), DrawingSize::Wide)
        });
        check_drawing("force and depth", &curve, || {
            draw_force_and_depth(&anatomy::name_layers_of_curve(&curve), DrawingSize::Wide)
        });
        check_drawing("corridor", &curve, || draw_corridor(&curve, &experts, DrawingSize::Wide));
        let layers = [LayerDamage { name: "skin".to_owned(), rupture_mj: 1.0, ..LayerDamage::default() }];
        check_drawing("damage", &layers, || draw_damage(&layers, DrawingSize::Wide));
    }

    #[test]
    fn drawings_of_progress_speak_the_readers_language() {
        let rule = Rule::new(&CusumParams { p0: 0.1, p1: 0.4, alpha: 0.1, beta: 0.1 }, Some(30)).expect("a rule");
        let points = learning(&rule, &[false; 40]).points;
        check_drawing("learning curve", &"CUSUM", || draw_learning_curve(&points, &rule, "x", "CUSUM"));
        for points in [vec![], vec![ScorePoint { at: samples::NOW, score: 70.0, passed: true }]] {
            check_drawing("scores", &"CUSUM", || draw_scores(&points, 60.0, "x", "CUSUM"));
        }
    }
}
