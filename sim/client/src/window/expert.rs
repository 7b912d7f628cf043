//! The curve of a virtual expert in a debrief: its attempt at the same patient, simulated in a
//! background thread after the trainee's own attempt has ended.

use std::sync::Arc;
use std::thread::{self, JoinHandle};

use eframe::egui::Context;
use law::operator::{Operator, Skill};

use super::plots::Curves;
use crate::live::LiveTrial;

/// Seed of the expert's hand: each debrief of a patient shows the same curve.
const SEED: u64 = 0;

/// The expert's curves, once they have been computed.
pub struct ExpertCurves {
    computing: Option<JoinHandle<Curves>>,
    curves: Option<Curves>,
}

impl ExpertCurves {
    /// Starts the expert's attempt at the exercise and the patient of a trial.
    pub fn start(trial: &LiveTrial) -> Self {
        let (specimen, session) = (Arc::clone(&trial.specimen), trial.session.clone());
        let (plan, time_limit_s) = (trial.bundle.plan(), trial.bundle.exercise.time_limit_s);
        let computing = thread::spawn(move || {
            let mut expert = Operator::skilled(&Skill::expert(), &plan, SEED);
            let recording = attempt::simulate::rehearse(&specimen, &mut expert, session, time_limit_s);
            Curves::new(sentence!("a virtual expert"), &recording)
        });
        Self { computing: Some(computing), curves: None }
    }

    /// Takes the curves if they have been computed; otherwise requests another frame.
    pub fn update(&mut self, context: &Context) {
        match self.computing.take_if(|computing| computing.is_finished()) {
            // After a panic the debrief shows the trainee's curve alone.
            Some(computing) => self.curves = computing.join().ok().filter(Curves::entered),
            None if self.computing.is_some() => context.request_repaint_after_secs(0.1),
            None => {}
        }
    }

    /// Returns the curves; `None` while they are being computed, or if the expert never entered the
    /// body.
    pub fn curves(&self) -> Option<&Curves> {
        self.curves.as_ref()
    }
}

#[cfg(test)]
mod tests {
    //! Fails if the expert punctures another patient, differs between debriefs, or ends where the
    //! trainee's attempt does.

    use haptics::devices::scripted::Fault;

    use super::*;
    use crate::live::tests as attempts;

    /// Returns the curves of the expert at the first shipped exercise.
    fn expert() -> Curves {
        let folder = tempfile::tempdir().expect("a folder");
        let live = attempts::begin(Fault::None, None, folder.path());
        let mut expert = ExpertCurves::start(&live.trial);
        while expert.computing.is_some() {
            expert.update(&Context::default());
            thread::sleep(std::time::Duration::from_millis(10));
        }
        let target_mm = live.trial.bundle.exercise.target_depth_mm;
        let curves = expert.curves.expect("the expert enters the body");
        assert!(curves.deepest_mm() > 0.9 * target_mm, "{} mm of {target_mm} mm", curves.deepest_mm());
        curves
    }

    #[test]
    fn expert_reaches_the_target_and_repeats_its_curve() {
        let [first, second] = [expert(), expert()];
        assert_eq!(first.depth, second.depth);
        assert_eq!(first.name, "a virtual expert");
    }
}
