//! What a rubric pays for: attempts that are worth next to nothing, and one that is careless, are simulated and judged.

use std::path::Path;

use assessment::{AssessError, Assessment, assess};
use mechanics::axial::Contactor;
use mechanics::closed_form;
use mechanics::operator::{Operator, Plan};
use mechanics::puncture::PunctureParams;
use recording::{EventKind, Recording};
use scene::phrase::Phrase;
use scene::{ExerciseBundle, Issue, Patient, Remark, along_path, phrase};

use crate::attempt::Maker;
use crate::exit::Failure;
use crate::rehearsal::{TICK_HZ, params_of_law, perform};

/// Most points of 100 for next to nothing: an untouched needle, a prick, a lunge.
const NEXT_TO_NOTHING: f64 = 25.0;
/// Points of 100 that an attempt must lose when it leaves out the confirm or the withdrawal, unless it fails.
const CARELESS: f64 = 10.0;
/// Speeds of the hands, in m/s.
const PRICK_M_PER_S: f64 = 0.005;
const LUNGE_M_PER_S: f64 = 0.1;
const STEADY_M_PER_S: f64 = 0.002;
/// How long the hands hold before they confirm, in s.
const HOLD_S: f64 = 0.5;

/// What is wrong with the rubric of an exercise in the file of a name: what the catalogue knows, and what simulating it shows.
///
/// # Errors
/// When the scene cannot be simulated, or an attempt not be judged.
pub fn issues(file: &Path, bundle: &ExerciseBundle) -> Result<Vec<Issue>, Failure> {
    let mut remarks = assessment::review(bundle);
    remarks.extend(Rehearsal::new(file, bundle)?.remarks().map_err(|error| Failure::refused(file, error))?);
    Ok(bundle.place(&file.display().to_string(), &remarks)?)
}

/// Stiff hands at an exercise, on its nominal patient.
struct Rehearsal<'a> {
    bundle: &'a ExerciseBundle,
    params: PunctureParams,
    /// Where the tip opens the skin, in m along the needle.
    skin_m: f64,
}

impl<'a> Rehearsal<'a> {
    fn new(file: &Path, bundle: &'a ExerciseBundle) -> Result<Self, Failure> {
        let params = params_of_law(file, bundle, &Patient::nominal(&bundle.scene))?;
        let axial = along_path(params.spec().axial.clone(), bundle.exercise.angle_deg);
        let mut ruptures = closed_form::ruptures(&axial).into_iter();
        let skin = ruptures.find(|rupture| rupture.boundary == 0 && rupture.contactor == Contactor::Tip);
        Ok(Self { bundle, params, skin_m: skin.map_or(0.0, |rupture| rupture.x_m) })
    }

    fn remarks(&self) -> Result<Vec<Remark>, AssessError> {
        let mut remarks = Vec::new();
        for (what, target_x_m, speed_m_per_s) in self.worthless() {
            let judged = self.judge(&self.record(target_x_m, speed_m_per_s))?;
            if judged.score > NEXT_TO_NOTHING || judged.passed {
                remarks.push(pays_for(what, &judged));
            }
        }
        let whole = self.record(self.bundle.exercise.target_depth_mm * 1e-3, STEADY_M_PER_S);
        let best = self.judge(&whole)?;
        for (what, careless) in
            [(phrase!("never confirmed"), unconfirmed(&whole)), (phrase!("never withdrawn"), left_inside(&whole))]
        {
            let judged = self.judge(&careless)?;
            if judged.score > best.score - CARELESS && judged.passed == best.passed {
                remarks.push(does_not_care(what, [&best, &judged]));
            }
        }
        Ok(remarks)
    }

    /// Attempts that are worth next to nothing: in words, how deep in m, how fast in m/s.
    fn worthless(&self) -> Vec<(Phrase, f64, f64)> {
        let target_m = self.bundle.exercise.target_depth_mm * 1e-3;
        let prick =
            |x_m: f64| (phrase!("a prick of {depth} mm", depth = Phrase::number(x_m * 1e3, 1)), x_m, PRICK_M_PER_S);
        let length_m = self.bundle.scene.needle.length_mm * 1e-3;
        vec![
            (phrase!("a needle that never touches the skin"), -0.002, PRICK_M_PER_S),
            prick(self.skin_m + 0.5e-3),
            prick(target_m / 4.0),
            prick(target_m / 2.0),
            (phrase!("a lunge to the hub"), length_m, LUNGE_M_PER_S),
        ]
    }

    fn record(&self, target_x_m: f64, speed_m_per_s: f64) -> Recording {
        let exercise = &self.bundle.exercise;
        let plan = Plan { target_x_m, hold_s: HOLD_S, ..exercise.plan() };
        let maker = Maker { device: "operator:check", device_max_force_n: f64::INFINITY, seed: 0, tick_hz: TICK_HZ };
        let mut session = maker.session(self.bundle);
        session.patient_thickness_mm = Patient::nominal(&self.bundle.scene).thickness_mm;
        let mut hand = Operator::constant(speed_m_per_s, &plan);
        perform(&self.params, session, &mut hand, exercise.time_limit_s)
    }

    fn judge(&self, recording: &Recording) -> Result<Assessment, AssessError> {
        assess(recording, self.bundle)
    }
}

fn unconfirmed(whole: &Recording) -> Recording {
    let mut recording = whole.clone();
    recording.events.retain(|event| event.kind != EventKind::Confirm);
    recording
}

fn left_inside(whole: &Recording) -> Recording {
    let mut recording = whole.clone();
    let confirm = whole.events.iter().find(|event| event.kind == EventKind::Confirm);
    let until_s = confirm.map_or(f64::INFINITY, |event| event.t_s);
    recording.samples.retain(|sample| sample.t_s <= until_s);
    recording.events.retain(|event| event.t_s <= until_s);
    recording
}

fn pays_for(what: Phrase, judged: &Assessment) -> Remark {
    let score = Phrase::number(judged.score, 0);
    let found = match judged.passed {
        true => phrase!("{what} earns {score} points and passes", what = what, score = score),
        false => phrase!("{what} earns {score} points", what = what, score = score),
    };
    let allowed = phrase!(
        "allowed: at most {most} points for next to nothing; say under [required] what must have happened",
        most = NEXT_TO_NOTHING
    );
    Remark { field: "required".to_owned(), found, allowed }
}

fn does_not_care(what: Phrase, [best, judged]: [&Assessment; 2]) -> Remark {
    let (best, score) = (Phrase::number(best.score, 0), Phrase::number(judged.score, 0));
    let found =
        phrase!("an attempt of {best} points, {what}, earns {score} points", best = best, what = what, score = score);
    let allowed = phrase!("allowed: it fails, or loses {least} points; say so under [required]", least = CARELESS);
    Remark { field: "required".to_owned(), found, allowed }
}
