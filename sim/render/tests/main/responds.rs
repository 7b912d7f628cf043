//! The picture responds to every input, and to nothing else: where the tip is, how deep a tent is, blood, fade, touch, bend.
//!
//! It would fail on a needle drawn beside its tip, a tent that is not the field's, an input that is ignored, and a picture that
//! depends on what was drawn before.

use render::Quality;
use render::frame::{
    DrawnBend, DrawnHub, DrawnNeedle, DrawnStructure, DrawnStructureKind, Frame, Ghost, OnHub, Orbit, Stage, View,
};

use crate::painter::{changed, painter, picture, pixel_of};
use crate::specimen::{at_depth, cuboid, inside, stage, tenting};

const SIZE: [u32; 2] = [640, 360];
/// Half the width of the block, in m.
const HALF_WIDTH_M: f32 = 0.088;
/// A difference that is seen, in levels of a channel.
const SEEN: u8 = 12;

#[test]
fn the_same_frame_is_the_same_to_the_byte() {
    let frame = tenting(3, 0.0125, 0.6);
    let mut painter = painter();
    let once = painter.picture(&stage(), &frame, SIZE).expect("a picture");
    let other = painter.next(&at_depth(-0.01), SIZE).expect("another between");
    let again = painter.picture(&stage(), &frame, SIZE).expect("the first again");
    assert!(once == again, "{} pixels differ", changed(&once, &again, 0).len());
    assert!(once != other, "and another frame is another picture");
}

/// The lowest pixel of the needle near a column, found by taking the needle away.
fn lowest_of_needle(frame: &Frame, column: f32) -> [f32; 2] {
    let away = Frame { tip_m: [0.0, 0.0, 1.0], ..frame.clone() };
    let pixels = changed(&picture(&stage(), frame, SIZE), &picture(&stage(), &away, SIZE), SEEN);
    // The needle's shadow begins elsewhere.
    let near = pixels.iter().filter(|[x, _]| (*x as f32 + 0.5 - column).abs() < 8.0);
    let [x, y] = near.max_by_key(|[_, y]| *y).expect("a needle");
    [*x as f32 + 0.5, *y as f32 + 0.5]
}

#[test]
fn a_section_does_not_fade() {
    let frame = |fade| Frame { view: View::Section, fade, ..tenting(3, 0.0125, 0.6) };
    let [clear, faded] = [0.0, 0.7].map(|fade| picture(&stage(), &frame(fade), SIZE));
    let differing = changed(&clear, &faded, SEEN).len();
    assert_eq!(differing, 0, "its layers are what it is for");
}

/// A patient: the specimen's back goes on as a large slab.
fn patient() -> Stage {
    Stage { skin: Some(cuboid([0.0, 0.0, -0.11], [0.16, 0.24, 0.11])), ..stage() }
}

#[test]
fn a_patient_is_closed_under_a_drape_and_fades_to_the_bones() {
    let stage = patient();
    let frame = |fade| Frame { view: View::Patient, closed: true, fade, ..inside(at_depth(0.026), 4, 0.0) };
    let [closed, faded] = [0.0, 0.8].map(|fade| picture(&stage, &frame(fade), SIZE));
    let at = |drawn: &image::RgbaImage, place_m: [f32; 3]| {
        let [x, y] = pixel_of(&stage, &frame(0.0), (place_m, SIZE));
        drawn.get_pixel(x as u32, y as u32).0
    };
    let [r, _, b, _] = at(&closed, [-0.03, -0.03, 0.0]);
    assert!(r > b.saturating_add(20), "skin in the window: {r} {b}");
    let [r, _, b, _] = at(&closed, [-0.115, 0.0, 0.0015]);
    assert!(b > r.saturating_add(20), "a drape beside it: {r} {b}");
    let bone_m = [-0.026, 0.004, -0.026];
    let without = Stage { structures: Vec::new(), ..stage.clone() };
    let seen = |fade| {
        let [x, y] = pixel_of(&stage, &frame(fade), (bone_m, SIZE));
        let [with, without] =
            [&stage, &without].map(|stage| picture(stage, &frame(fade), SIZE).get_pixel(x as u32, y as u32).0);
        with[1].abs_diff(without[1])
    };
    assert_eq!(seen(0.0), 0, "nothing shows through a closed body");
    assert!(seen(0.8) > SEEN, "the bone shows through one that fades: {}", seen(0.8));
    assert!(!changed(&closed, &faded, SEEN).is_empty());
}

#[test]
fn without_its_own_skin_the_patient_is_the_closed_block() {
    let frame = |view| Frame { view, closed: true, ..at_depth(-0.01) };
    let drawn = picture(&stage(), &frame(View::Patient), SIZE);
    let [x, y] = pixel_of(&stage(), &frame(View::Patient), ([-0.115, 0.0, 0.0], SIZE));
    let [r, _, b, _] = drawn.get_pixel(x as u32, y as u32).0;
    assert!(r < b, "beside the block lies the cloth under it: {r} {b}");
}

/// Where a cut goes through a bone that reaches out of the block below, nothing hangs in the air.
#[test]
fn a_block_that_bends_lies_on_its_table() {
    let flat = Stage { structures: Vec::new(), ..stage() };
    let bent = Stage { bend: DrawnBend::Cylinder { radius_m: 0.11, line: [0.0, 1.0] }, ..flat.clone() };
    let frame = at_depth(-0.01);
    let differing = changed(&picture(&flat, &frame, SIZE), &picture(&bent, &frame, SIZE), SEEN);
    let ends = [-HALF_WIDTH_M, HALF_WIDTH_M].map(|x| pixel_of(&flat, &frame, ([x, 0.0, -flat.depth_m()], SIZE))[1]);
    let lowest = differing.iter().map(|[_, y]| *y).max().expect("a bend is seen");
    assert!((lowest as f32) < ends[0].max(ends[1]) + 2.0, "row {lowest}, and the block ends at {ends:?}");
}

#[test]
fn a_bone_ends_with_the_block() {
    let mut stage = stage();
    stage.structures = vec![DrawnStructure {
        name: "vertebra".to_owned(),
        kind: DrawnStructureKind::Bone,
        mesh: cuboid([0.0, 0.004, -0.06], [0.02, 0.02, 0.04]),
    }];
    let bare = Stage { structures: Vec::new(), ..stage.clone() };
    let frame = at_depth(-0.02);
    let pixels = changed(&picture(&stage, &frame, SIZE), &picture(&bare, &frame, SIZE), SEEN);
    let lowest = pixels.iter().map(|[_, y]| *y).max().expect("a bone");
    let bottom = pixel_of(&stage, &frame, ([0.0, -0.016, -stage.depth_m()], SIZE))[1];
    assert!((lowest as f32) < bottom + 3.0, "it is seen down to row {lowest}, the block's bottom is at {bottom}");
}

#[test]
fn the_needle_ends_where_its_tip_is() {
    for (view, tip_m) in
        [(View::Whole, [0.0, 0.0, 0.02]), (View::Section, [0.004, 0.0, 0.013]), (View::Tip, [0.0, 0.0, 0.006])]
    {
        for tip in [render::frame::Tip::Diamond, render::frame::Tip::Bevel] {
            let frame = Frame { view, tip_m, ..at_depth(0.0) };
            let mut stage = stage();
            stage.needle.tip = tip;
            let expected = pixel_of(&stage, &frame, (tip_m, SIZE));
            let found =
                if view == View::Tip { tip_in_close_up(&stage, &frame) } else { lowest_of_needle(&frame, expected[0]) };
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off <= 2.0, "{view:?} {tip:?}: the tip is at {expected:?}, its lowest pixel at {found:?}");
        }
    }
}

/// In the close-up the camera follows the needle, so that the needle is taken away by making it thin and blunt.
fn tip_in_close_up(stage: &Stage, frame: &Frame) -> [f32; 2] {
    let mut bare = stage.clone();
    bare.needle.length_m = 0.0;
    bare.needle.tip = render::frame::Tip::Blunt;
    let expected = pixel_of(stage, frame, (frame.tip_m, SIZE));
    let pixels = changed(&picture(stage, frame, SIZE), &picture(&bare, frame, SIZE), SEEN);
    let near = |[x, y]: &[u32; 2]| (*x as f32 - expected[0]).hypot(*y as f32 - expected[1]);
    let [x, y] = pixels.iter().min_by(|a, b| near(a).total_cmp(&near(b))).expect("a needle");
    [*x as f32 + 0.5, *y as f32 + 0.5]
}

/// The uppermost pixel of the body in a column of a section: paper is light and grey.
fn top_of_body(frame: &Frame, column: u32) -> f32 {
    let drawn = picture(&stage(), frame, SIZE);
    let body = |y: &u32| {
        let [r, _, b, _] = drawn.get_pixel(column, *y).0;
        r > b.saturating_add(30)
    };
    (0..SIZE[1]).find(body).expect("a body") as f32
}

#[test]
fn a_tent_is_as_deep_as_the_field_says() {
    const BESIDE_M: f32 = 0.003;
    let depth_m = 0.0029;
    let section = |frame: Frame| Frame { view: View::Section, ..frame };
    let (flat, tent) = (section(inside(at_depth(0.0), 0, 0.0)), section(tenting(0, depth_m, 0.0)));
    // The specimen's field: a dent that is half as deep 4.2 mm from the axis.
    let given_m = depth_m * 0.0042 / (0.0042 + BESIDE_M);
    let [column, rest] = pixel_of(&stage(), &tent, ([BESIDE_M, 0.0, 0.0], SIZE));
    let expected = pixel_of(&stage(), &tent, ([BESIDE_M, 0.0, -given_m], SIZE))[1] - rest;
    let found = top_of_body(&tent, column as u32) - top_of_body(&flat, column as u32);
    assert!(
        expected > 4.0 && (found - expected).abs() <= 2.0,
        "the skin goes down {found} pixels, {expected} by the field"
    );
}

#[test]
fn tent_ends_at_the_needle_for_any_field_load() {
    let section = |mut frame: Frame, loads: f32| {
        frame.loads_n.iter_mut().for_each(|newton| *newton *= loads);
        picture(&stage(), &Frame { view: View::Section, ..frame }, SIZE)
    };
    for (boundary, depth_m) in [(0, 0.0029), (1, 0.005), (3, 0.0125)] {
        let mut frame = tenting(boundary, depth_m, 0.0);
        let pressed_m = frame.dents_m[boundary];
        frame.dents_m = (0..4).map(|at| if at == boundary { pressed_m } else { 0.1 * pressed_m }).collect();
        let [own, more] = [1.0, 2.2].map(|loads| section(frame.clone(), loads));
        let differing = changed(&own, &more, SEEN).len();
        assert!(differing < 60, "boundary {boundary}: {differing} pixels go with a field that is too soft");
        let none = section(Frame { dents_m: Vec::new(), ..frame }, 2.2);
        assert!(
            changed(&own, &none, SEEN).len() > 4 * differing.max(20),
            "boundary {boundary}: the dents are not seen"
        );
    }
}

#[test]
fn blood_spreads_and_reddens() {
    let at = |blood: f32| {
        let frame = inside(at_depth(0.02), 4, blood);
        picture(&stage(), &Frame { orbit: Orbit { yaw_rad: 0.0, pitch_rad: 0.4, distance: 0.4 }, ..frame }, SIZE)
    };
    let none = at(0.0);
    let redder = |with: &image::RgbaImage| {
        let pairs = with.pixels().zip(none.pixels());
        pairs.filter(|(with, without)| with.0[1].saturating_add(25) < without.0[1] && with.0[0] / 2 > with.0[1]).count()
    };
    let [a_little, much] = [0.3, 1.0].map(|blood| redder(&at(blood)));
    assert!(a_little > 20 && much > 3 * a_little, "{a_little} pixels redden at 0.3, {much} at 1");
}

#[test]
fn fading_shows_what_is_inside() {
    let bare = Stage { structures: Vec::new(), ..stage() };
    let shown = |fade: f32| {
        let frame = Frame { fade, ..at_depth(-0.01) };
        changed(&picture(&stage(), &frame, SIZE), &picture(&bare, &frame, SIZE), SEEN).len()
    };
    let (opaque, clear) = (shown(0.0), shown(0.9));
    assert!(opaque > 50, "the cut goes through structures: {opaque} pixels");
    assert!(
        clear as f32 > 1.3 * opaque as f32,
        "{clear} pixels of structures through a clear body, {opaque} in the cut"
    );
}

#[test]
fn every_other_input_is_seen() {
    let frame = inside(at_depth(0.02), 4, 0.0);
    let plain = picture(&stage(), &frame, SIZE);
    let ghost = Some(Ghost { tip_m: [0.02, 0.0, 0.0], orientation: frame.orientation });
    let second = inside(Frame { tip_m: [0.02, 0.01, 0.0], ..frame.clone() }, 1, 0.5).punctures;
    let others = [
        ("the guide", Frame { guide: true, ..frame.clone() }),
        ("touch", Frame { touched: Some(1), ..frame.clone() }),
        ("a bend", Frame { bend_m: [0.01, 0.0, 0.0], ..frame.clone() }),
        ("a ghost", Frame { ghost, ..frame.clone() }),
        ("a closed body", Frame { closed: true, ..frame.clone() }),
        ("an older puncture", Frame { punctures: [second, frame.punctures.clone()].concat(), ..frame.clone() }),
        ("a turn", Frame { orbit: Orbit { yaw_rad: 0.3, ..Orbit::default() }, ..frame.clone() }),
    ];
    for (what, other) in others {
        let pixels = changed(&plain, &picture(&stage(), &other, SIZE), SEEN).len();
        assert!(pixels > 25, "{what} changes {pixels} pixels");
    }
}

#[test]
fn what_is_at_the_hub_is_seen() {
    let stage = |hub| {
        let needle = DrawnNeedle { length_m: 0.07, hub, ..stage().needle };
        Stage { needle, ..stage() }
    };
    let seen = |on: OnHub, hub: DrawnHub| {
        let frame = Frame { hub, ..inside(at_depth(0.02), 4, 0.0) };
        picture(&stage(on), &frame, SIZE)
    };
    let (rest, open) = (DrawnHub::default(), DrawnHub { open: true, ..DrawnHub::default() });
    let pairs = [
        ("a syringe instead of a knob", [seen(OnHub::Stylet, rest), seen(OnHub::Syringe, rest)]),
        ("a stylet that is out", [seen(OnHub::Stylet, rest), seen(OnHub::Stylet, open)]),
        ("a syringe that is off", [seen(OnHub::Stylet, open), seen(OnHub::Syringe, open)]),
        ("blood", [seen(OnHub::Stylet, rest), seen(OnHub::Stylet, DrawnHub { blood: 1.0, ..rest })]),
        ("a plunger", [seen(OnHub::Syringe, rest), seen(OnHub::Syringe, DrawnHub { plunger: 1.0, ..rest })]),
        ("a drop", [seen(OnHub::Stylet, open), seen(OnHub::Stylet, DrawnHub { drop: 1.0, ..open })]),
        (
            "a drop that falls",
            [DrawnHub { drop: 0.5, ..open }, DrawnHub { drop: 0.5, fallen_m: 0.02, ..open }]
                .map(|hub| seen(OnHub::Stylet, hub)),
        ),
    ];
    for (what, [one, other]) in pairs {
        let pixels = changed(&one, &other, SEEN).len();
        assert!((pixels > 15) == (what != "a syringe that is off"), "{what}: {pixels} pixels");
    }
}

#[test]
fn needle_beside_the_body_shades_the_drape_in_every_view() {
    // The lamp stands to the left, before and above: a shadow falls to the right and away by so much per metre of height.
    let (height_m, [right, away]) = (0.02_f32, [0.50 / 0.74, 0.46 / 0.74]);
    let drape_m = -stage().depth_m() - 0.001;
    let fall_m = height_m + 0.01 - drape_m;
    let shadow_m = [-0.16 + right * fall_m, away * fall_m, drape_m];
    for (yaw_rad, pitch_rad, fade) in [(0.0, 0.0, 0.0), (0.0, 0.0, 0.7), (-0.6, 0.3, 0.0), (0.4, 0.6, 0.7)] {
        let orbit = Orbit { yaw_rad, pitch_rad, distance: 1.3 };
        let frame = Frame { tip_m: [-0.16, 0.0, height_m], orbit, fade, ..at_depth(0.0) };
        let gone = Frame { tip_m: [0.0, 0.0, 1.0], ..frame.clone() };
        // So far below the needle its shadow is wide and faint.
        let darker = changed(&picture(&stage(), &frame, SIZE), &picture(&stage(), &gone, SIZE), 1);
        let [x, y] = pixel_of(&stage(), &frame, (shadow_m, SIZE));
        let close = |[a, b]: &[u32; 2]| (*a as f32 + 0.5 - x).hypot(*b as f32 + 0.5 - y) < 3.0;
        assert!(darker.iter().any(close), "yaw {yaw_rad}, pitch {pitch_rad}, fade {fade}: no shadow at {x}, {y}");
    }
}

/// How much darker, in levels of a channel, the skin gets around a place of the patient frame (m) by a needle that stands in it.
fn darkened(place_m: [f32; 3]) -> u8 {
    let stage = Stage { needle: DrawnNeedle { length_m: 0.049, ..stage().needle }, ..stage() };
    let frame = Frame { closed: true, ..inside(at_depth(0.02), 4, 0.0) };
    let gone = Frame { tip_m: [0.0, 0.0, 1.0], orientation: frame.orientation, punctures: Vec::new(), ..frame.clone() };
    let [with, without] = [&frame, &gone].map(|frame| picture(&stage, frame, SIZE));
    let [x, y] = pixel_of(&stage, &frame, (place_m, SIZE)).map(|at| at as u32);
    let around = (0..25).map(|i| [x + i % 5 - 2, y + i / 5 - 2]);
    let darker = around.map(|[x, y]| without.get_pixel(x, y).0[1].saturating_sub(with.get_pixel(x, y).0[1]));
    darker.max().unwrap_or(0)
}

#[test]
fn hub_shadow_is_fainter_than_the_shadow_at_the_entry() {
    // The lamp stands to the left and before: what is so high above the skin shades a place so far to the right and away.
    let shaded = |height_m: f32| [height_m * 0.50 / 0.74, height_m * 0.46 / 0.74, 0.0];
    let [close, hub, beside] = [shaded(0.005), shaded(0.035), [-0.03, 0.02, 0.0]].map(darkened);
    assert!(close > 40 && hub > 8 && hub < close - 10, "{close} levels at the needle, {hub} under the hub");
    assert!(beside < 4, "{beside} levels elsewhere");
}

#[test]
fn every_quality_draws_the_same_scene() {
    let frame = tenting(1, 0.005, 0.5);
    let best = picture(&stage(), &frame, SIZE);
    for quality in Quality::ALL {
        let mut painter = painter();
        painter.set_quality(quality);
        let drawn = painter.picture(&stage(), &frame, SIZE).expect("a picture");
        painter.set_quality(Quality::Full);
        let differ = changed(&best, &drawn, 40).len();
        assert_eq!(drawn.dimensions(), best.dimensions());
        assert!(differ < (SIZE[0] * SIZE[1] / 20) as usize, "{}: {differ} pixels look different", quality.in_words());
    }
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let nan = f32::NAN;
    let sound = tenting(1, 0.005, 0.5);
    let frames = [
        Frame { tip_m: [nan; 3], ..sound.clone() },
        Frame { orientation: [nan; 4], ..sound.clone() },
        Frame { loads_n: vec![f32::INFINITY; 8], ..sound.clone() },
        Frame { fade: nan, ..sound.clone() },
        Frame { bend_m: [0.0, nan, 0.0], ..sound.clone() },
        Frame { orbit: Orbit { yaw_rad: nan, pitch_rad: 9.0, distance: 0.0 }, ..sound.clone() },
        Frame { touched: Some(99), loads_n: Vec::new(), ..sound },
    ];
    for frame in frames {
        let drawn = picture(&stage(), &frame, [160, 90]);
        let first = drawn.get_pixel(0, 0);
        assert!(drawn.pixels().any(|pixel| pixel != first), "something is drawn: {frame:?}");
    }
}
