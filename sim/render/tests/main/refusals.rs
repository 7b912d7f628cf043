//! A stage or a size that cannot be drawn is refused in one line that says what is allowed, and the old stage stays.
//!
//! It would fail on a panic of the graphics library, and on a picture of something else.

use render::frame::{DrawnLayer, Stage};

use crate::painter::{painter, picture};
use crate::specimen::{at_depth, stage};

fn refused(stage: &Stage) -> String {
    painter().set_stage(stage).expect_err("it is refused").to_string()
}

#[test]
fn a_stage_that_is_too_large_or_does_not_fit_its_field() {
    let many = Stage { layers: vec![DrawnLayer::default(); 17], ..Stage::default() };
    assert_eq!(refused(&many), "17 layers; allowed in a picture: at most 16");
    let mut loads = stage();
    loads.field.loads = 49;
    assert_eq!(refused(&loads), "49 loads of the field; allowed in a picture: at most 48");
    let mut short = stage();
    short.field.axial_m_per_n.pop();
    assert!(refused(&short).contains("1535 displacements; allowed: 1536"), "{}", refused(&short));
}

#[test]
fn a_refused_stage_leaves_the_old_one() {
    let frame = at_depth(-0.01);
    let mut broken = stage();
    broken.field.axial_m_per_n.clear();
    let mut painter = painter();
    let before = painter.picture(&stage(), &frame, [160, 90]).expect("a picture");
    painter.set_stage(&broken).expect_err("it is refused");
    assert!(before == painter.next(&frame, [160, 90]).expect("a picture"));
}

#[test]
fn a_size_that_is_none() {
    for size in [[0, 90], [160, 0], [1 << 20, 90]] {
        let error = painter().picture(&stage(), &at_depth(0.0), size).expect_err("refused").to_string();
        assert!(error.contains("1 to ") && error.contains(&size[0].to_string()), "{error}");
    }
}

#[test]
fn an_empty_stage_is_an_empty_picture() {
    let drawn = picture(&Stage::default(), &at_depth(0.01), [160, 90]);
    assert_eq!(drawn.dimensions(), (160, 90));
}
