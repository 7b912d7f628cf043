//! Sample data for the tests of the pages, from one fictitious school.

#[cfg(test)]
pub(crate) mod markup;
#[cfg(test)]
pub(crate) mod untranslated_text;

use assessment::{Deduction, DeductionCause, Direction, Metric};
use documents::{Exercise, ExerciseBundle, HardFail, Required, RubricLine};
use model::ids::{CohortId, PersonId, SessionId};
use model::letters::notice::{Notice, NoticeKind};
use model::training::assignment::AssignmentTally;
use model::training::due::local;
use model::training::membership::{MembershipAct, MembershipEvent, MembershipRequest};
use model::training::progress::{Course, CourseStep, Mastery, Progress, ScoredAttempt};
use model::{Moment, Role, Uncounted};
use time::macros::datetime;
use time::{Duration, OffsetDateTime};

use crate::authoring::exercise::{Context, ExerciseFacts, ExercisePage};
use crate::charts::Drawing;
use crate::form::SelectOption;
use crate::letters::news::NewsItem;
use crate::people::listed::{ListPart, ListQuery, PageNumbers};
use crate::recordings::session::{Ruling, SessionOutcome, SessionPage, VerificationResult};
use crate::scoring::judgement::{GradedAttempt, JudgementView, MetricSpread, OthersSpreads};
use crate::shell::ShellVisitor;
use crate::training::assignments::DueLine;
use crate::training::cohort::{CohortFigures, CohortPage, CourseShare, NamedTrainee, TraineeRow};
use crate::training::concern::say_concern;
use crate::training::progress::HabitsView;
use crate::training::risk::SupportNoteRow;
use crate::training::trainee::{CourseFacts, CourseView, OwnAttemptRow, TraineePage};
use crate::{NavPlace, Shell, StatusWord};

mod exam_files;
mod insertion;
mod support;
mod tissue;

pub(crate) use exam_files::exam_files;
pub(crate) use insertion::curve;

/// Current time of the samples.
pub(crate) const NOW: OffsetDateTime = datetime!(2026-05-20 09:30 UTC);

/// Renders a page and checks it. If `STYLET_KEEP_PAGES` is set, writes it to `target/pages`.
pub(crate) fn keep_page(name: &str, page: &(impl askama::Template + std::fmt::Debug)) -> String {
    untranslated_text::check_page(name, page);
    let html = page.render().expect("the page renders");
    markup::check_markup(name, &html);
    let scripts = html.replace("<script src=\"/assets/", "").replace("<script type=\"module\" src=\"/assets/", "");
    let inline = html.contains("style=") || html.contains("<style") || scripts.contains("<script");
    assert!(!inline, "the policy forbids it");
    assert!(!html.contains("NaN"), "{name} holds a number that is none");
    if std::env::var_os("STYLET_KEEP_PAGES").is_some() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = root.join("../target/pages");
        std::fs::create_dir_all(folder.join("assets")).expect("a folder");
        for asset in ["style.css", "icon.svg"] {
            std::fs::copy(root.join("assets").join(asset), folder.join("assets").join(asset)).expect("an asset");
        }
        let html = html.replace("\"/assets/", "\"assets/");
        std::fs::write(folder.join(format!("{name}.html")), html).expect("a page");
    }
    html
}

pub(crate) fn shell(role: Role) -> Shell {
    let name = match role {
        Role::Trainee | Role::Guest => "Ana Lindqvist",
        Role::Instructor => "Dr Peter Osei",
        Role::Administrator => "Maria Keller",
    };
    Shell {
        visitor: ShellVisitor { name: name.to_owned(), role },
        csrf: "token".to_owned(),
        place: NavPlace::Home,
        news: 3,
        logo: Some("/school/logo?v=1".to_owned()),
    }
}

/// Returns the exercise "Stop in the fat" on a lower back with a vessel.
pub(crate) fn bundle() -> ExerciseBundle {
    let line =
        |metric: &str, full, zero, weight| RubricLine { metric: metric.to_owned(), version: 1, full, zero, weight };
    let exercise = Exercise {
        id: "stop-in-the-fat".to_owned(),
        title: "Stop in the fat".into(),
        briefing: "Go through the skin and stop in the middle of the fat.\n\nBrace your hand: the skin gives twice."
            .into(),
        scene: "../scenes/lower-back.toml".to_owned(),
        entry_mm: [0.0, 0.0],
        skin_shape: law::Skin::Flat,
        angle_deg: 15.0,
        azimuth_deg: 0.0,
        target_depth_mm: 20.0,
        time_limit_s: 180.0,
        feedback: documents::Feedback::Both,
        fluoroscopy: None,
        required: Some(Required {
            reached: Some("fat".to_owned()),
            within_mm: Some(8.0),
            confirmed: true,
            withdrawn: true,
        }),
        rubric: vec![
            line("depth_error_mm", 0.5, 8.0, 5.0),
            line("overshoot_mm", 0.5, 6.0, 3.0),
            line("peak_force_n", 1.8, 6.0, 2.0),
            line("lateral_work_mj", 0.3, 4.0, 2.0),
        ],
        hard_fails: vec![HardFail {
            metric: "structure_hits.vessel".to_owned(),
            version: 1,
            above: 0.0,
            why: "The needle hit the vessel.".into(),
        }],
        pass_mark: 70.0,
        coaching: vec![],
        pictures: vec![],
        difficulty: 2,
        sha256: "5f1c0a9be2d47c31".repeat(4),
    };
    ExerciseBundle {
        exercise,
        scene: tissue::scene(),
        exercise_bytes: vec![],
        scene_bytes: vec![],
        meshes: vec![],
        pictures: vec![],
    }
}

pub(crate) fn metrics() -> Vec<Metric> {
    let values: [(&str, Option<f64>); 26] = [
        ("depth_error_mm", Some(1.93)),
        ("overshoot_mm", Some(1.93)),
        ("tip_error_mm", Some(2.4)),
        ("entry_error_mm", Some(0.8)),
        ("angle_error_deg", Some(2.1)),
        ("peak_force_n", Some(2.27)),
        ("peak_force_layer_n.skin", Some(1.73)),
        ("peak_force_layer_n.muscle", Some(2.27)),
        ("rupture_force_n", Some(1.9)),
        ("over_insertion_mm", Some(1.6)),
        ("stop_time_s", None),
        ("rupture_energy_mj", Some(9.94)),
        ("rupture_energy_mj.skin", Some(3.82)),
        ("rupture_energy_mj.fat", Some(1.62)),
        ("rupture_energy_mj.muscle", Some(4.5)),
        ("cutting_energy_mj.skin", Some(0.2)),
        ("cutting_energy_mj.fat", Some(0.8)),
        ("cutting_energy_mj.muscle", Some(2.9)),
        ("friction_energy_mj.fat", Some(0.6)),
        ("friction_energy_mj.muscle", Some(1.1)),
        ("lateral_work_mj", Some(0.9)),
        ("lateral_work_mj.muscle", Some(0.9)),
        ("sweep_area_mm2", Some(12.4)),
        ("skin_entries", Some(1.0)),
        ("structure_hits", Some(0.0)),
        ("time_total_s", Some(26.0)),
    ];
    values.map(|(id, value)| metric(id, value)).to_vec()
}

pub(crate) fn metric(id: &str, value: Option<f64>) -> Metric {
    let definition = assessment::catalogue::newest_definition(id);
    let label = definition.map_or_else(String::new, |d| {
        id.split_once('.').map_or_else(|| d.label.to_owned(), |(_, part)| d.label_of(part))
    });
    // Parsed from JSON, so that a field added to the type does not break the sample.
    serde_json::from_value(serde_json::json!({
        "id": id, "version": 1, "value": value, "unit": definition.map_or("", |d| d.unit),
        "direction": definition.map_or(Direction::Lower, |d| d.direction), "applies": value.is_some(), "label": label,
    }))
    .expect("a metric")
}

pub(crate) fn judgement() -> JudgementView {
    let deduction = |metric: &str, points: f64, value: f64, (full, zero): (f64, f64)| Deduction {
        metric: metric.to_owned(),
        version: 1,
        points,
        cause: DeductionCause::Measured { value, full, zero },
    };
    let deductions = [
        deduction("depth_error_mm", 7.95, 1.93, (0.5, 5.0)),
        deduction("overshoot_mm", 6.5, 1.9, (0.5, 5.0)),
        deduction("peak_force_n", 4.8, 2.3, (1.8, 4.0)),
        deduction("lateral_work_mj", 0.0, 0.9, (2.0, 10.0)),
    ];
    let bundle = bundle();
    JudgementView::new(&GradedAttempt {
        score: 80.75,
        passed: true,
        deductions: &deductions,
        hard_fails: &[],
        metrics: &metrics(),
        exercise: Some(&bundle.exercise),
        targets: &[],
        curve: Some(&curve()),
        others: &OthersSpreads {
            cohort: vec![MetricSpread { id: "peak_force_n".to_owned(), version: 1, quartiles: [1.9, 2.3, 2.7] }],
            experts: vec![],
        },
    })
}

/// The same attempt at an exercise that allows less distance from the target than it has.
pub(crate) fn missed_judgement() -> JudgementView {
    let mut exercise = bundle().exercise;
    exercise.required = Some(Required { within_mm: Some(1.5), ..Required::default() });
    let judged = assessment::judge(metrics(), &exercise, "0.1.0").expect("a rubric");
    JudgementView::new(&GradedAttempt {
        score: judged.score,
        passed: judged.passed,
        deductions: &judged.deductions,
        hard_fails: &judged.hard_fails,
        metrics: &metrics(),
        exercise: Some(&exercise),
        targets: &[],
        curve: Some(&curve()),
        others: &OthersSpreads::default(),
    })
}

/// Its page, with another score put in place by an instructor.
pub(crate) fn missed_page() -> SessionPage {
    SessionPage {
        outcome: SessionOutcome::Scored(Box::new(missed_judgement())),
        ruling: Some(Ruling {
            score: 75.0,
            passed: true,
            by: "Dr Peter Osei".to_owned(),
            reason: "The probe slipped at the station; seen there.".to_owned(),
        }),
        ..session_page()
    }
}

pub(crate) fn session_page() -> SessionPage {
    SessionPage {
        shell: shell(Role::Instructor),
        exercise: "Stop in the fat".to_owned(),
        exercise_href: Some("/exercises/stop-in-the-fat".to_owned()),
        trainee: Some(("Ana Lindqvist".to_owned(), "/trainees/1".to_owned())),
        started_at: NOW,
        replay_href: "/sessions/0190/replay".to_owned(),
        grade_href: "/sessions/0190/grade".to_owned(),
        outcome: SessionOutcome::Scored(Box::new(judgement())),
        ruling: None,
        drawing: Some(Drawing::new(&curve()).leading_to("/sessions/0190/replay")),
        uncounted: Some((Uncounted::Duplicate, Some("/sessions/0180".to_owned()))),
        is_replaced: false,
        verification: VerificationResult::Same,
        signed_by: Some("Skills lab 2".to_owned()),
        supervised_by: None,
        surveys: vec![("How was it for you?".to_owned(), "/surveys/1?session=2".to_owned(), 1.0)],
        facts: vec![
            ("Duration", "26.0 s".to_owned()),
            ("Device", "operator:intermediate".to_owned()),
            ("Simulator", "0.1.0".to_owned()),
            ("Recording", "1.4 MB, complete".to_owned()),
            ("Exercise revision", "5f1c0a9be2d4".to_owned()),
        ],
        exam_files: Some(exam_files()),
    }
}

/// Returns a course of four exercises, each requiring the previous one, mastered with three passes
/// of five.
pub(crate) fn course() -> Course {
    let step = |id: &str, title: &str, before: &[&str]| CourseStep {
        exercise: id.to_owned(),
        title: title.to_owned(),
        prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
    };
    Course {
        steps: vec![
            step("feel-the-layers", "Feel the layers", &[]),
            step("stop-in-the-fat", "Stop in the fat", &["feel-the-layers"]),
            step("reach-the-muscle", "Reach 20 mm in muscle", &["stop-in-the-fat"]),
            step("oblique-approach", "Oblique approach", &["reach-the-muscle"]),
        ],
        rule: Mastery::Passes { passes: 3, of: 5 },
        earlier: Vec::new(),
    }
}

pub(crate) const PASS_MARKS: [f64; 4] = [60.0, 70.0, 70.0, 70.0];
const COURSE_TITLE: &str = "Lower back: first punctures";

/// Returns attempts two days apart, the last one `days_ago` days ago.
pub(crate) fn history(scores: &[(&str, f64)], days_ago: i64) -> Vec<ScoredAttempt> {
    let count = i64::try_from(scores.len()).expect("few");
    let attempt = |(i, (exercise, score)): (i64, &(&str, f64))| ScoredAttempt {
        session: SessionId::from_u128(u128::from(i.unsigned_abs())),
        exercise: (*exercise).into(),
        at: NOW - Duration::days(days_ago + 2 * (count - 1 - i)) + Duration::hours(i % 7),
        score: *score,
        passed: *score >= 70.0,
        revision: None,
    };
    (0..).zip(scores).map(attempt).collect()
}

pub(crate) fn ana() -> Vec<ScoredAttempt> {
    let scores = [
        ("feel-the-layers", 52.0),
        ("feel-the-layers", 71.0),
        ("feel-the-layers", 78.0),
        ("feel-the-layers", 85.0),
        ("stop-in-the-fat", 41.0),
        ("stop-in-the-fat", 58.0),
        ("stop-in-the-fat", 74.0),
        ("stop-in-the-fat", 66.0),
        ("stop-in-the-fat", 80.7),
    ];
    history(&scores, 16)
}

pub(crate) fn facts(course: &Course) -> CourseFacts<'_> {
    CourseFacts {
        trainee: Some("/trainees/1"),
        id: "lower-back-basics",
        title: COURSE_TITLE,
        course,
        pass_marks: &PASS_MARKS,
    }
}

pub(crate) fn attempts() -> Vec<OwnAttemptRow> {
    let row = |(exercise, status, score, note, flagged): (&str, StatusWord, Option<f64>, &str, bool)| OwnAttemptRow {
        href: "/sessions/0190".to_owned(),
        at: NOW - Duration::days(16),
        trainee: None,
        exercise: exercise.to_owned(),
        status,
        score,
        computed: (status == StatusWord::Passed).then_some(64.2),
        note: note.to_owned(),
        flagged,
        uncounted: flagged.then_some(Uncounted::Unpublished),
    };
    [
        ("Stop in the fat", StatusWord::Waiting, None, "", false),
        ("Stop in the fat", StatusWord::Passed, Some(80.7), "1.9 mm too deep", false),
        ("Stop in the fat", StatusWord::Failed, Some(66.2), "4.1 mm too deep", true),
        ("Feel the layers", StatusWord::Refused, None, "the recording holds no samples", false),
    ]
    .map(row)
    .to_vec()
}

pub(crate) fn progress() -> Progress {
    Progress::of(&course(), &ana())
}

pub(crate) fn request() -> MembershipRequest {
    MembershipRequest {
        cohort_id: CohortId::from_u128(3),
        cohort: "Spring".to_owned(),
        person_id: PersonId::from_u128(4),
        person: "Ana Lindqvist".to_owned(),
        role: Role::Trainee,
        asked_by: "Ben Okafor".to_owned(),
        asked_at: Moment::from(NOW),
    }
}

pub(crate) fn noted(act: MembershipAct) -> MembershipEvent {
    MembershipEvent { cohort: "Spring".to_owned(), act, by: Some("Ben Okafor".to_owned()), done_at: Moment::from(NOW) }
}

/// Returns news of three kinds.
pub(crate) fn news() -> Vec<NewsItem> {
    let notice = |kind| Notice {
        kind,
        by: "Dr Peter Osei".to_owned(),
        session_id: Some(SessionId::nil()),
        comment_id: None,
        from_s: Some(3.5),
        round_id: None,
        title: "Stop in the fat".to_owned(),
        made_at: Moment::from_micros(1_779_000_000_000_000),
    };
    [NoticeKind::Answer, NoticeKind::Override, NoticeKind::Assignment].map(|kind| NewsItem::new(&notice(kind))).to_vec()
}

pub(crate) fn trainee_page(own: bool) -> TraineePage {
    let (course, progress) = (course(), progress());
    TraineePage {
        news: if own { news() } else { vec![] },
        transcript: "/trainees/1/transcript".to_owned(),
        outcomes: Some("/trainees/1/outcomes".to_owned()),
        requests: if own { vec![request()] } else { vec![] },
        shell: shell(if own { Role::Trainee } else { Role::Instructor }),
        name: "Ana Lindqvist".to_owned(),
        own,
        due: vec![],
        concerns: if own { vec![] } else { support::concerns_of("Ana Lindqvist").iter().map(say_concern).collect() },
        notes: vec![SupportNoteRow::new(support::message())],
        support_href: (!own).then(|| "/at-risk?trainee=1".to_owned()),
        cohorts: vec!["Spring 2026".to_owned()],
        courses: vec![CourseView::new(&facts(&course), &progress, 0)],
        others: vec![CourseView {
            title: "Lumbar puncture".to_owned(),
            ..CourseView::new(&facts(&course), &Progress::of(&course, &[]), 1)
        }],
        habits: HabitsView::default(),
        attempts: attempts(),
        pages: PageNumbers { page: 1, last: 2, entries: 34 },
        sign_in_code: own.then_some(None),
    }
}

pub(crate) fn newcomer_page() -> TraineePage {
    let course = course();
    let progress = Progress::of(&course, &[]);
    let courses = vec![CourseView::new(&facts(&course), &progress, 0)];
    TraineePage { courses, attempts: vec![], pages: PageNumbers::default(), ..trainee_page(true) }
}

pub(crate) fn cohort_page() -> CohortPage {
    let course = course();
    let first = [("feel-the-layers", 75.0), ("feel-the-layers", 82.0), ("feel-the-layers", 88.0)];
    let second = [("stop-in-the-fat", 71.0), ("stop-in-the-fat", 75.0), ("stop-in-the-fat", 79.0)];
    let third = [("reach-the-muscle", 38.0), ("reach-the-muscle", 44.0), ("reach-the-muscle", 41.0)];
    let fourth = [("reach-the-muscle", 84.0), ("reach-the-muscle", 90.0), ("reach-the-muscle", 88.0)];
    let last = [("oblique-approach", 81.0), ("oblique-approach", 93.0), ("oblique-approach", 90.0)];
    let people = [
        ("Ana Lindqvist", ana()),
        ("Bruno Ferrari", history(&[&first[..], &second, &third].concat(), 1)),
        ("Chen Wei", history(&[&first[..], &second, &fourth, &last].concat(), 3)),
        ("Dorothea Achterberg-Nakamura", history(&[&first[..], &second[..1]].concat(), 0)),
        ("Emeka Obi", vec![]),
        ("Fatima Zahra", history(&[&first[..], &second].concat(), 2)),
    ];
    let standing = people.map(|(name, attempts)| (name.to_owned(), Progress::of(&course, &attempts)));
    let row = |(name, progress): &(String, Progress)| {
        let who = NamedTrainee { href: "/trainees/1".to_owned(), name: name.clone() };
        TraineeRow::new(who, &facts(&course), progress, &support::concerns_of(name))
    };
    let rows: Vec<TraineeRow> = standing.iter().map(row).collect();
    let help: Vec<TraineeRow> = rows.iter().filter(|row| !row.concerns.is_empty()).cloned().collect();
    let in_course = standing.each_ref().map(|(_, progress)| progress);
    let option = |value: &str, label: &str| SelectOption {
        value: value.to_owned(),
        label: label.to_owned(),
        chosen: value == "lower-back-basics",
    };
    let (trainees, list) = ListPart::of(ListQuery::default(), rows, |row| &row.name);
    CohortPage {
        shell: shell(Role::Instructor),
        href: "/cohorts/1".to_owned(),
        risk_href: "/at-risk?cohort=1".to_owned(),
        name: "Spring 2026".to_owned(),
        instructors: vec!["Dr Peter Osei".to_owned()],
        figures: CohortFigures::new(&in_course, help.len()),
        help,
        due_lines: vec![due_line()],
        courses: vec![option("lower-back-basics", "Lower back"), option("lumbar-puncture", "Lumbar puncture")],
        course: Some(CourseShare::new(&facts(&course), &standing.each_ref().map(|(name, p)| (name.as_str(), p)))),
        trainees,
        list,
        now: NOW,
    }
}

pub(crate) fn due_line() -> DueLine {
    DueLine {
        href: "/assignments/1".to_owned(),
        title: "Stop in the fat".to_owned(),
        to: "Spring 2026".to_owned(),
        due: Some(local(Moment::from(NOW), "Europe/Berlin")),
        tally: AssignmentTally { done: 4, late: 2, of: 6 },
    }
}

pub(crate) fn exercise_page() -> ExercisePage {
    let link = |title: &str, id: &str| (title.to_owned(), format!("/exercises/{id}"));
    ExercisePage {
        shell: shell(Role::Trainee),
        exercise: ExerciseFacts::new(&bundle(), &[]),
        contexts: vec![Context {
            course: COURSE_TITLE.to_owned(),
            place: (2, 4),
            rule: "mastered after 3 passes within 5 consecutive attempts".to_owned(),
            prerequisites: vec![link("Feel the layers", "feel-the-layers")],
            opens: vec![link("Reach 20 mm in muscle", "reach-the-muscle")],
            status: Some(StatusWord::Current),
        }],
        attempts: attempts(),
        own: true,
        chart: None,
        teaching: None,
    }
}
