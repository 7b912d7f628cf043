//! Rubric exploit checks: simulates and judges attempts that deserve almost no points, and careless
//! ones.

use documents::{ExerciseBundle, Patient, Remark, spec_along_path};
use law::closed_form;
use law::operator::{Operator, Plan};
use phrase::{Phrase, phrase};
use recording::{Contactor, EventKind, Recording};

use crate::error::AssessError;
use crate::review::review_rubric;
use crate::score::Assessment;
use crate::tryout::Tryout;

/// Most points of 100 for an attempt that deserves almost none: an untouched needle, a prick, a
/// lunge.
const NEXT_TO_NOTHING: f64 = 25.0;
/// Points of 100 that an attempt must lose if it leaves out the confirm or the withdrawal, unless
/// it fails.
const CARELESS: f64 = 10.0;
/// Speeds of the hands, in m/s.
const PRICK_M_PER_S: f64 = 0.005;
const LUNGE_M_PER_S: f64 = 0.1;
const STEADY_M_PER_S: f64 = 0.002;
/// Duration of the hold before the confirm, in s.
const HOLD_S: f64 = 0.5;

/// Returns remarks for the author of an exercise: from the catalogue's review of the rubric, and
/// from simulated attempts. The exercise remains usable.
///
/// # Errors
/// If the scene cannot be simulated, or if an attempt cannot be judged.
pub fn appraise_rubric(bundle: &ExerciseBundle) -> Result<Vec<Remark>, AssessError> {
    let tryout = Tryout::new(bundle, Patient::nominal(&bundle.scene))?;
    let mut remarks = review_rubric(bundle);
    for (what, target_x_m, speed_m_per_s) in find_worthless_act(&tryout) {
        let judged = tryout.judge(&stiff_scene(&tryout, target_x_m, speed_m_per_s))?;
        if judged.score > NEXT_TO_NOTHING || judged.passed {
            remarks.push(pays_for_attempt(what, &judged));
        }
    }
    let whole = stiff_scene(&tryout, bundle.exercise.target_depth_mm * 1e-3, STEADY_M_PER_S);
    let best = tryout.judge(&whole)?;
    for (what, careless) in [
        (phrase!("the position is not confirmed"), unconfirmed_attempt(&whole)),
        (phrase!("the needle is not withdrawn"), attempt_left_inside(&whole)),
    ] {
        let judged = tryout.judge(&careless)?;
        if judged.score > best.score - CARELESS && judged.passed == best.passed {
            remarks.push(does_not_care(what, [&best, &judged]));
        }
    }
    Ok(remarks)
}

/// Returns attempts that deserve almost no points: description, depth in m, speed in m/s.
fn find_worthless_act(tryout: &Tryout<'_>) -> Vec<(Phrase, f64, f64)> {
    let bundle = tryout.bundle;
    let target_m = bundle.exercise.target_depth_mm * 1e-3;
    let prick = |x_m: f64| (phrase!("a prick of {depth} mm", depth = Phrase::number(x_m * 1e3, 1)), x_m, PRICK_M_PER_S);
    let length_m = bundle.scene.needle.length_mm * 1e-3;
    vec![
        (phrase!("a needle that never touches the skin"), -0.002, PRICK_M_PER_S),
        prick(skin_m(tryout) + 0.5e-3),
        prick(0.25 * target_m),
        prick(0.5 * target_m),
        prick(0.75 * target_m),
        (phrase!("a fast push to the hub"), length_m, LUNGE_M_PER_S),
    ]
}

/// Returns the depth at which the tip opens the skin of the nominal patient, in m along the needle.
fn skin_m(tryout: &Tryout<'_>) -> f64 {
    let axial = spec_along_path(tryout.specimen().spec().axial.clone(), &tryout.bundle.exercise.incidence());
    let mut ruptures = closed_form::predict_ruptures(&axial).into_iter();
    let skin = ruptures.find(|rupture| rupture.boundary == 0 && rupture.contactor == Contactor::Tip);
    skin.map_or(0.0, |rupture| rupture.x_m)
}

/// Simulates a stiff hand: inserts to a depth, holds, confirms and withdraws.
fn stiff_scene(tryout: &Tryout<'_>, target_x_m: f64, speed_m_per_s: f64) -> Recording {
    let plan = Plan { target_x_m, hold_s: HOLD_S, ..tryout.bundle.exercise.plan() };
    tryout.perform(&mut Operator::constant(speed_m_per_s, &plan))
}

fn unconfirmed_attempt(whole: &Recording) -> Recording {
    let mut recording = whole.clone();
    recording.events.retain(|event| event.kind != EventKind::Confirm);
    recording
}

fn attempt_left_inside(whole: &Recording) -> Recording {
    let mut recording = whole.clone();
    let confirm = whole.events.iter().find(|event| event.kind == EventKind::Confirm);
    let until_s = confirm.map_or(f64::INFINITY, |event| event.t_s);
    recording.samples.retain(|sample| sample.t_s <= until_s);
    recording.events.retain(|event| event.t_s <= until_s);
    recording
}

fn pays_for_attempt(what: Phrase, judged: &Assessment) -> Remark {
    let score = Phrase::number(judged.score, 0);
    let found = match judged.passed {
        true => phrase!("{what} earns {score} points and passes", what = what, score = score),
        false => phrase!("{what} earns {score} points", what = what, score = score),
    };
    let allowed = phrase!(
        "allowed: at most {most} points for almost nothing; state what must be done first (table `required`)",
        most = NEXT_TO_NOTHING
    );
    Remark { field: "required".to_owned(), found, allowed }
}

fn does_not_care(what: Phrase, [best, judged]: [&Assessment; 2]) -> Remark {
    let (best, score) = (Phrase::number(best.score, 0), Phrase::number(judged.score, 0));
    let found = phrase!(
        "an attempt worth {best} points earns {score} points when {what}",
        best = best,
        what = what,
        score = score
    );
    let allowed = phrase!(
        "allowed: it fails, or loses at least {least} points; state that it must be done (table `required`)",
        least = CARELESS
    );
    Remark { field: "required".to_owned(), found, allowed }
}
