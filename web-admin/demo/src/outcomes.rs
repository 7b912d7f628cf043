//! Outcomes of the demonstration: three entrustable professional activities, and decisions on the
//! levels of two trainees.

use acts::training::outcomes::{Decision, OutcomeSettings, change_outcome, entrust_level, import_catalogue};
use anyhow::Context;
use model::training::outcome::OutcomeText;
use model::{Moment, PersonKey};
use routes_base::AppState;
use store::training::{curricula, outcomes};

use crate::DAY_S;
use crate::assignments::find_demo_person;
use crate::school::{ADMINISTRATOR, COHORTS, LEARNERS};

/// The catalogue: the first two outcomes have a course that leads to them.
const CATALOGUE: &str = "code,title,description
EPA 1,Punctures the lower back,\"Positions the patient, finds the level, and reaches the target without touching a vessel.\"
EPA 2,Gains access to the kidney,\"Plans the way, punctures the lower pole, and confirms the position.\"
EPA 3,Obtains informed consent,\"Explains benefit, risks and alternatives, and documents the decision.\"
";
/// Trainees by number, days before the end, levels and reasons of the decisions.
const DECISIONS: [(usize, i64, i64, &str); 4] = [
    (7, 21, 2, "Five attempts seen at the station; calm hands."),
    (7, 3, 4, "Course mastered; ten supervised attempts without contact to a structure."),
    (2, 9, 3, "Safe with me in the room next door."),
    (1, 5, 2, "Pushes on after the second pop; needs me beside the station."),
];

/// Defines the outcomes and decides.
///
/// # Errors
/// Fails if the people are missing, or the database fails.
pub async fn decide_on_outcomes(state: &AppState, now: Moment) -> anyhow::Result<()> {
    let head = find_demo_person(state, ADMINISTRATOR).await?.into_current().context("an administrator")?;
    import_catalogue(state, &head, CATALOGUE.as_bytes()).await?;
    let courses = curricula::list_taught_curricula(state.db.reader(), head.school_id).await?;
    let named =
        |word: &str| courses.iter().map(|course| course.curriculum_id.clone()).filter(|id| id.contains(word)).collect();
    let found = outcomes::list_outcomes(state.db.reader(), head.school_id).await?;
    for (outcome, courses) in found.iter().zip([named("back"), named("kidney")]) {
        let text = OutcomeText {
            code: outcome.code.clone(),
            title: outcome.title.clone(),
            description: outcome.description.clone(),
            source: String::new(),
        };
        let settings = OutcomeSettings { text, courses, is_retired: false };
        change_outcome(state, &head, outcome.id, settings).await?;
    }
    let outcome_id = found.first().context("an outcome")?.id;
    for (learner, days, level, note) in DECISIONS {
        let learner = &LEARNERS[learner];
        let instructor = find_demo_person(state, COHORTS[learner.cohort].instructor).await?;
        let instructor = instructor.into_current().context("an instructor")?;
        let trainee = find_demo_person(state, learner.name).await?;
        let whom = PersonKey { school_id: trainee.school_id, person_id: trainee.id };
        let then = state.at(now.plus_s(-days * DAY_S));
        entrust_level(&then, &instructor, whom, Decision { outcome_id, level: Some(level), note }).await?;
    }
    Ok(())
}
