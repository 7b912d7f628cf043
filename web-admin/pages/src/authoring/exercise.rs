//! The page of an exercise: task, cross-section and rubric.

use std::collections::BTreeMap;

use askama::Template;
use askama_web::WebTemplate;
use documents::{ClassCounts, Exercise, ExerciseBundle, SceneStructure};
use law::structures::Shape;
use nalgebra::{Point3, Vector3};

use crate::authoring::measured::MeasuredLine;
use crate::authoring::pictures::{PictureAtHand, ShownPicture, show_pictures};
use crate::charts::{CrossSection, SectionPoint, SectionStructure, StructureOutline};
use crate::form::SelectOption;
use crate::training::trainee::OwnAttemptRow;
use crate::{Shell, StatusWord, anatomy, charts, format, metric};

/// The page of an exercise.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "authoring/exercise.html")]
pub struct ExercisePage {
    /// Page frame.
    pub shell: Shell,
    /// Facts and rubric of the exercise.
    pub exercise: ExerciseFacts,
    /// Its place in each course.
    pub contexts: Vec<Context>,
    /// Attempts, newest first: the trainee's own, or all that the visitor may see.
    pub attempts: Vec<OwnAttemptRow>,
    /// Whether the visitor is a trainee.
    pub own: bool,
    /// Chart of scores over time, for a trainee with attempts.
    pub chart: Option<String>,
    /// Controls for instructors; `None` for trainees.
    pub teaching: Option<ExerciseTeaching>,
}

/// Controls of the page for instructors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExerciseTeaching {
    /// Whether the exercise has just been published.
    pub published: bool,
    /// Courses that do not contain it yet.
    pub courses: Vec<SelectOption>,
    /// Parameters of its scene compared with published measurements.
    pub measured: Vec<MeasuredLine>,
    /// Numbers of its scene's layers by class.
    pub classes: ClassCounts,
    /// The scene's force against depth, as SVG.
    pub curve: String,
}

/// Place of an exercise in a course.
#[derive(Clone, Debug)]
pub struct Context {
    /// The course's title.
    pub course: String,
    /// Position in the course, from 1, and number of exercises.
    pub place: (usize, usize),
    /// The mastery rule as text.
    pub rule: String,
    /// Exercises to be mastered first: title and address.
    pub prerequisites: Vec<(String, String)>,
    /// Exercises that this one unlocks: title and address.
    pub opens: Vec<(String, String)>,
    /// The visitor's status, if the visitor is a trainee.
    pub status: Option<StatusWord>,
}

/// An exercise as displayed.
#[derive(Clone, Debug)]
pub struct ExerciseFacts {
    /// Id in its document.
    pub id: String,
    /// Title.
    pub title: String,
    /// Paragraphs of the briefing.
    pub briefing: Vec<String>,
    /// Pictures of the briefing.
    pub pictures: Vec<ShownPicture>,
    /// Cross-section, at both widths.
    pub drawing: String,
    /// Name and thickness in mm of each layer.
    pub layers: Vec<(String, f64)>,
    /// Name and kind of each structure.
    pub structures: Vec<(String, &'static str)>,
    /// Facts: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// Lines of the rubric.
    pub rubric: Vec<RubricLineView>,
    /// Limits that fail an attempt: metric with limit, and the explanation given to the trainee.
    pub hard_fails: Vec<(String, String)>,
    /// Requirements that must be met before any points are earned.
    pub required: Vec<String>,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
}

/// A line of the rubric.
#[derive(Clone, Debug, PartialEq)]
pub struct RubricLineView {
    /// Name of the metric.
    pub label: String,
    /// Definition of the metric.
    pub definition: String,
    /// Value that earns full marks, with unit.
    pub full: String,
    /// Value that earns no marks, with unit.
    pub zero: String,
    /// Maximum points, of 100.
    pub points: f64,
}

impl ExerciseFacts {
    /// Describes an exercise in text and a drawing, with the available pictures.
    #[must_use]
    pub fn new(bundle: &ExerciseBundle, pictures: &[PictureAtHand]) -> Self {
        let exercise = &bundle.exercise;
        let weights: f64 = exercise.rubric.iter().map(|l| l.weight).sum();
        let section = section_of_bundle(bundle);
        let language = words::current().code();
        Self {
            id: exercise.id.clone(),
            title: exercise.title.in_language(language).to_owned(),
            briefing: split_paragraphs(exercise.briefing.in_language(language)),
            pictures: show_pictures(exercise, pictures),
            drawing: charts::draw_both_widths(|size| charts::draw_cross_section(&section, size)),
            layers: bundle.scene.layers.iter().map(|l| (anatomy::say_structure(&l.name), l.thickness_mm)).collect(),
            structures: bundle
                .scene
                .structures
                .iter()
                .map(|s| (anatomy::say_structure(&s.spec.name), s.kind().word()))
                .collect(),
            facts: list_exercise_facts(bundle),
            rubric: exercise.rubric.iter().map(|l| rubric_line(l, weights)).collect(),
            hard_fails: exercise.hard_fails.iter().map(say_hard_fail).collect(),
            required: exercise.required.as_ref().map(say_requirements).unwrap_or_default(),
            pass_mark: exercise.pass_mark,
        }
    }
}

/// Splits a text into paragraphs at empty lines.
fn split_paragraphs(text: &str) -> Vec<String> {
    text.split("\n\n").map(|p| p.trim().replace('\n', " ")).filter(|p| !p.is_empty()).collect()
}

fn list_exercise_facts(bundle: &ExerciseBundle) -> Vec<(&'static str, String)> {
    let Exercise { difficulty, pass_mark, time_limit_s, target_depth_mm, angle_deg, sha256, .. } = &bundle.exercise;
    let needle = &bundle.scene.needle;
    vec![
        (tr!("Scene"), bundle.scene.title.clone()),
        (
            tr!("Needle"),
            tr!(
                "{diameter} {kind}, {tip} tip",
                diameter = format::format_stated(needle.diameter_mm, "mm"),
                kind = words::known(&needle.kind),
                tip = words::known(&needle.tip)
            ),
        ),
        (tr!("Target"), tr!("{depth} along the needle", depth = format::format_stated(target_depth_mm, "mm"))),
        (tr!("Angle to the surface normal"), format::format_stated(angle_deg, "°")),
        (tr!("Time limit"), format::format_span(*time_limit_s)),
        (tr!("Pass mark"), tr!("{score} of 100", score = format::line_points(*pass_mark))),
        (tr!("Difficulty"), tr!("{difficulty} of 5", difficulty = difficulty)),
        (tr!("Revision"), format::shorten_hash(sha256).to_owned()),
    ]
}

fn rubric_line(line: &documents::RubricLine, weights: f64) -> RubricLineView {
    let (label, definition, unit) = metric_words(&line.metric, line.version);
    RubricLineView {
        label,
        definition,
        full: format::format_stated(line.full, unit),
        zero: format::format_stated(line.zero, unit),
        points: if weights > 0.0 { line.weight / weights * 100.0 } else { 0.0 },
    }
}

/// Describes the requirements that must be met before any points are earned.
fn say_requirements(required: &documents::Required) -> Vec<String> {
    let reached = required
        .reached
        .as_ref()
        .map(|layer| tr!("the tip has entered {layer}", layer = anatomy::say_structure(layer)));
    let within = required.within_mm.map(|mm| {
        tr!("the position is within {distance} of the target depth", distance = format::format_stated(mm, "mm"))
    });
    let confirmed = required.confirmed.then(|| tr!("the position was confirmed in the body").to_owned());
    let withdrawn = required.withdrawn.then(|| tr!("the needle was withdrawn").to_owned());
    [reached, within, confirmed, withdrawn].into_iter().flatten().collect()
}

fn say_hard_fail(limit: &documents::HardFail) -> (String, String) {
    let (label, _, unit) = metric_words(&limit.metric, limit.version);
    let why = limit.why.in_language(words::current().code()).to_owned();
    (tr!("{label} above {limit}", label = label, limit = format::format_stated(limit.above, unit)), why)
}

/// Returns label, definition and unit of a version of a metric, plain or split.
fn metric_words(id: &str, version: u32) -> (String, String, &'static str) {
    let unit = assessment::catalogue::find_definition(id, version).map_or("", |definition| definition.unit);
    (metric::metric_label(id), metric::metric_definition(id, version), unit)
}

/// Returns the section in the plane of the planned needle, seen from the side. A perpendicular
/// needle lies in every vertical plane: of the planned plane and the one rotated by 90°, the one
/// that cuts more meshes is chosen.
fn section_of_bundle(bundle: &ExerciseBundle) -> CrossSection {
    let planned = section_of_needle(bundle, &bundle.exercise);
    if bundle.exercise.angle_deg > 0.0 {
        return planned;
    }
    let turned = Exercise { azimuth_deg: bundle.exercise.azimuth_deg + 90.0, ..bundle.exercise.clone() };
    let turned = section_of_needle(bundle, &turned);
    if count_cuts(&turned) > count_cuts(&planned) { turned } else { planned }
}

/// Returns the number of contours along which meshes are cut.
fn count_cuts(section: &CrossSection) -> usize {
    let cuts = section.structures.iter().map(|structure| match &structure.outline {
        StructureOutline::Cut(loops) => loops.len(),
        _ => 0,
    });
    cuts.sum()
}

fn section_of_needle(bundle: &ExerciseBundle, exercise: &Exercise) -> CrossSection {
    let layers = bundle.scene.layers.iter();
    CrossSection {
        layers: layers.map(|l| (anatomy::say_structure(&l.name), l.texture.clone(), l.thickness_mm)).collect(),
        angle_deg: exercise.angle_deg,
        target_depth_mm: exercise.target_depth_mm,
        structures: bundle.scene.structures.iter().filter_map(|s| structure_in_section(s, exercise)).collect(),
    }
}

/// Returns a structure's outline in the plane; `None` for a mesh that the plane does not cut.
fn structure_in_section(structure: &SceneStructure, exercise: &Exercise) -> Option<SectionStructure> {
    let spec = &structure.spec;
    let at = [spec.position_m.x, spec.position_m.y, spec.position_m.z];
    let outline = outline_of_shape(&spec.shape, at, exercise);
    let is_passed_by = matches!(&outline, StructureOutline::Cut(loops) if loops.is_empty());
    (!is_passed_by).then(|| SectionStructure {
        name: anatomy::say_structure(&spec.name),
        kind: spec.kind.word(),
        outline,
    })
}

fn outline_of_shape(shape: &Shape, at: [f64; 3], exercise: &Exercise) -> StructureOutline {
    let seen = |offset: [f64; 3]| point_in_plane([at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]], exercise);
    match shape {
        Shape::Sphere { radius_m } => StructureOutline::Circle { centre: seen([0.0; 3]), radius_mm: radius_m * 1e3 },
        Shape::Capsule { half_axis_m: h, radius_m } => StructureOutline::Capsule {
            from: seen([-h.x, -h.y, -h.z]),
            to: seen([h.x, h.y, h.z]),
            radius_mm: radius_m * 1e3,
        },
        Shape::Box { half_extents_m: h } => {
            let signs = (0..8_u8).map(|c| [0, 1, 2].map(|axis| if c >> axis & 1 == 0 { -1.0 } else { 1.0 }));
            outline_of_bounds(signs.map(|s: [f64; 3]| seen([s[0] * h.x, s[1] * h.y, s[2] * h.z])))
        }
        Shape::Mesh { vertices_m, triangles } => {
            let offset = Vector3::from(at);
            let seen: Vec<_> = vertices_m.iter().map(|v| exercise.seen_from_entry_m(&(v + offset))).collect();
            StructureOutline::Cut(cut_mesh(&seen, triangles))
        }
    }
}

/// Projects a point of the patient frame, in m, onto the plane.
fn point_in_plane([x, y, z]: [f64; 3], exercise: &Exercise) -> SectionPoint {
    let from_entry = exercise.seen_from_entry_m(&[x, y, z].into());
    SectionPoint::new(from_entry.x * 1e3, -from_entry.z * 1e3)
}

/// Returns the closed contours along which the plane cuts a closed mesh. Vertices are relative to
/// the entry point, in m.
fn cut_mesh(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vec<SectionPoint>> {
    let is_left = |vertex: u32| vertices_m.get(vertex as usize).is_some_and(|place_m| place_m.y >= 0.0);
    // Each cut triangle connects two of its edges. Contours are chains of edges, keyed by their
    // vertices: an edge runs from the right of the plane to its left, or back.
    let mut next = BTreeMap::new();
    for &[a, b, c] in triangles {
        let crossed = [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| is_left(*from) != is_left(*to));
        let edges: Vec<(u32, u32)> = crossed.collect();
        if let [first, second] = edges[..] {
            let (enters, leaves) = if is_left(first.0) { (second, first) } else { (first, second) };
            next.insert((enters.0, enters.1), (leaves.1, leaves.0));
        }
    }
    let place = |(from, to): (u32, u32)| {
        let [from, to] = [vertices_m.get(from as usize)?, vertices_m.get(to as usize)?];
        let at = from + (to - from) * (from.y / (from.y - to.y));
        Some(SectionPoint::new(at.x * 1e3, -at.z * 1e3))
    };
    let mut loops = Vec::new();
    while let Some((start, mut edge)) = next.pop_first() {
        let mut line = vec![start];
        while let Some(following) = next.remove(&edge) {
            line.push(edge);
            edge = following;
        }
        loops.push(line.into_iter().filter_map(place).collect());
    }
    loops
}

fn outline_of_bounds(points: impl Iterator<Item = SectionPoint>) -> StructureOutline {
    let mut from = SectionPoint::new(f64::INFINITY, f64::INFINITY);
    let mut to = SectionPoint::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
    for SectionPoint { across_mm, depth_mm } in points {
        from = SectionPoint::new(from.across_mm.min(across_mm), from.depth_mm.min(depth_mm));
        to = SectionPoint::new(to.across_mm.max(across_mm), to.depth_mm.max(depth_mm));
    }
    StructureOutline::Rect { from, to }
}

#[cfg(test)]
mod tests {
    //! The page must show the task and the scoring; the drawing must show the scene's true
    //! positions.

    use super::*;
    use crate::samples;

    #[test]
    fn shows_briefing_drawing_and_rubric() {
        let html = samples::keep_page("exercise", &samples::exercise_page());
        for wanted in
            ["Stop in the fat", "<svg", "Depth error", "0.5\u{a0}mm", "lumbar vessel", "out of 100", "example"]
        {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
    }

    #[test]
    fn without_attempts_it_says_how_to_begin() {
        let page = ExercisePage { attempts: vec![], chart: None, ..samples::exercise_page() };
        assert!(samples::keep_page("exercise-untried", &page).contains("No attempts yet"));
    }

    #[test]
    fn once_published_it_leads_to_a_course_and_to_an_assignment() {
        let courses = vec![SelectOption { value: "c".to_owned(), label: "A course".to_owned(), chosen: false }];
        let teaching = Some(ExerciseTeaching { published: true, courses, ..ExerciseTeaching::default() });
        let page = ExercisePage { own: false, teaching, ..samples::exercise_page() };
        let html = samples::keep_page("exercise-published", &page);
        for wanted in ["Published", "value=\"c\">A course", "/assignments?task=exercise:"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn a_structure_is_seen_along_the_lean_of_the_needle() {
        let mut exercise = samples::bundle().exercise;
        exercise.entry_mm = [10.0, 0.0];
        exercise.azimuth_deg = 90.0;
        let SectionPoint { across_mm, depth_mm } = point_in_plane([0.010, 0.007, -0.018], &exercise);
        assert!((across_mm - 7.0).abs() < 1e-9 && (depth_mm - 18.0).abs() < 1e-9, "{across_mm}, {depth_mm}");
    }

    #[test]
    fn a_mesh_is_seen_where_the_plane_cuts_it() {
        let mesh = |at: f64| {
            let corner = |c: u8| Point3::from([0, 1, 2].map(|axis| if c >> axis & 1 == 0 { -0.002 } else { 0.002 }));
            let vertices: Vec<_> = (0..8).map(|c| corner(c) + Vector3::new(0.001, at, -0.010)).collect();
            let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let triangles: Vec<_> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            cut_mesh(&vertices, &triangles)
        };
        let loops = mesh(0.0005);
        assert_eq!(loops.len(), 1);
        let bounds = outline_of_bounds(loops[0].iter().copied());
        let (from, to) = (SectionPoint::new(-1.0, 8.0), SectionPoint::new(3.0, 12.0));
        let StructureOutline::Rect { from: least, to: most } = bounds else { panic!("bounds") };
        for (value, wanted) in [(least, from), (most, to)] {
            assert!((value.across_mm - wanted.across_mm).abs() < 1e-9, "{value:?} is not {wanted:?}");
            assert!((value.depth_mm - wanted.depth_mm).abs() < 1e-9, "{value:?} is not {wanted:?}");
        }
        assert_eq!(mesh(0.003), Vec::<Vec<SectionPoint>>::new(), "the plane passes it by");
    }

    #[test]
    fn a_box_is_seen_by_its_bounds() {
        let exercise = samples::bundle().exercise;
        let shape = Shape::Box { half_extents_m: Vector3::new(0.002, 0.003, 0.004) };
        let StructureOutline::Rect { from, to } = outline_of_shape(&shape, [0.0, 0.0, -0.010], &exercise) else {
            panic!("a box")
        };
        let corners = [(from.across_mm, -2.0), (to.across_mm, 2.0), (from.depth_mm, 6.0), (to.depth_mm, 14.0)];
        for (value, wanted) in corners {
            assert!((value - wanted).abs() < 1e-9, "{value} is not {wanted}");
        }
    }

    #[test]
    fn paragraphs_are_split_at_empty_lines() {
        assert_eq!(split_paragraphs("One\nline.\n\nTwo.\n\n"), ["One line.", "Two."]);
    }
}
