//! A validation study of the demonstration, held at a station: simulated novices, intermediates and
//! experts participate as guests, with the same codes, uploads and answers as real ones.

use std::collections::BTreeMap;

use acts::privacy::study_consents::revision_of_terms;
use acts::recordings::intake::Bearer;
use acts::stations::{self, CallingStation, StationVisit, TypedCode};
use acts::studies::{self, ParticipantFacts, StudyRequest};
use acts::surveys::{self, AnsweredSheet};
use acts::training::assignments::find_taught_curriculum;
use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::ExerciseBundle;
use indicatif::ProgressBar;
use law::operator::{Occasion, Skill};
use model::ids::{RevisionId, SchoolId, StudyId};
use model::{CurrentPerson, Moment};
use routes_base::AppState;
use store::audit::Actor;
use store::people::Person;
use store::recordings::sessions::Session;
use store::studies::{self as stored, Study};
use store::surveys::instruments;

use crate::attempt::{self, AttemptTask, MadeRecording};
use crate::study::{Participant, basis_of_attempt, find_study_owner, invent_answer, scatter_of_seed};
use crate::{COURSE, current_bundle, take_in};

/// Number of guests per group, and of attempts per guest.
const EACH: usize = 8;
const ATTEMPTS_EACH: u32 = 2;
/// Total number of attempts.
pub(super) const ATTEMPTS: usize = ATTEMPTS_EACH as usize * EACH * TOLD.len();
/// Interval between attempts, in s.
const APART_S: i64 = 120;
const TITLE: &str = "Does the simulator distinguish experts from novices?";
const STATION: &str = "Study room";
/// Answers of the guests by group: role, and maximum years of practice.
const TOLD: [(&str, u32); 3] = [("Student", 0), ("Resident", 4), ("Consultant", 22)];

/// A guest at the station.
struct StudyGuest {
    person: Person,
    group: usize,
    place: usize,
}

/// Holds the study.
///
/// # Errors
/// Fails if the course or an instrument is missing, or an operation fails.
pub(super) async fn hold_validation_study(
    state: &AppState,
    school: SchoolId,
    seed: u64,
    progress: &ProgressBar,
) -> anyhow::Result<()> {
    let owner = find_study_owner(state).await?;
    let (_, course) = find_taught_curriculum(state, school, COURSE).await?;
    let bundle = current_bundle(state, school, &course, 0).await?;
    let id = make_demo_study(state, &owner, &bundle).await?;
    let study = stored::find_visible_study(state.db.reader(), &owner, id).await?.context("the study that was made")?;
    let station = pair_station(state, &owner).await?;
    let guests = invite_guests(state, &owner, &study, &station).await?;
    let tasks = plan_attempts(state.clock.now(), &guests, &bundle, seed)?;
    let mut taken = Vec::new();
    for MadeRecording { by, path, ends } in attempt::perform_demo_attempts(state, tasks).await? {
        let actor = Actor::Station(station.name.clone());
        let (school_id, station_id) = (station.school_id, Some(station.id));
        let bearer = Bearer { school_id, trainee_id: None, station_id, actor, ahead_us: None };
        taken.push((by, ends, take_in(state, &bearer, path, ends).await?));
        progress.inc(1);
    }
    worker::work_off_jobs(state).await?;
    for ((guest, number), ends, receipt) in taken {
        let last = number == ATTEMPTS_EACH;
        answer_after(&state.at(ends), &study, &guests[guest], receipt.session(), last).await?;
    }
    Ok(studies::close_study(state, &owner, &study, true).await?)
}

async fn make_demo_study(state: &AppState, owner: &CurrentPerson, bundle: &ExerciseBundle) -> anyhow::Result<StudyId> {
    let wanted = StudyRequest {
        title: TITLE.to_owned(),
        exercises: vec![bundle.exercise.id.clone()],
        attempts: ATTEMPTS_EACH,
        groups: ["Novices", "Intermediates", "Experts"].map(str::to_owned).to_vec(),
        questions: ["Role", "Years of practice"].map(str::to_owned).to_vec(),
        after_each: vec![find_instrument(state, owner, "nasa-tlx").await?],
        at_end: vec![find_instrument(state, owner, "simulator-validity").await?],
        consent: "My attempts and answers are recorded under a pseudonym and analysed for this study. I can leave it at any time."
            .to_owned(),
        controller: "The demonstration school".to_owned(),
        contact: "study@demonstration.example".to_owned(),
        kept_months: 120,
        generated: true,
    };
    Ok(studies::make_study(state, owner, &wanted).await?)
}

async fn find_instrument(state: &AppState, owner: &CurrentPerson, id: &str) -> anyhow::Result<(RevisionId, String)> {
    let found = instruments::find_current_instrument(state.db.reader(), owner.school_id, id).await?;
    found.map(|found| (found.id, found.title)).context("the instrument is shipped")
}

async fn pair_station(state: &AppState, owner: &CurrentPerson) -> anyhow::Result<CallingStation> {
    let (code, _) = stations::make_pairing_code(state, owner).await?;
    let paired = stations::pair(state, &code, STATION, None).await?;
    Ok(CallingStation { school_id: owner.school_id, id: paired.station_id, name: paired.name })
}

/// Creates a code for each guest, and signs them in with it.
async fn invite_guests(
    state: &AppState,
    owner: &CurrentPerson,
    study: &Study,
    station: &CallingStation,
) -> anyhow::Result<Vec<StudyGuest>> {
    let (terms, mut guests) = (revision_of_terms(study), Vec::new());
    for (group, place) in (0..TOLD.len()).flat_map(|group| (0..EACH).map(move |place| (group, place))) {
        let (role, most_years) = TOLD[group];
        let years = most_years / 2 + u32::try_from(place)? * most_years / 16;
        let facts = vec![role.to_owned(), years.to_string()];
        let told = ParticipantFacts { group_place: u32::try_from(group)?, facts };
        let code = studies::add_guest(state, owner, study, &told).await?.code;
        let typed = TypedCode { code: &code, agreed: Some(&terms) };
        let StationVisit::SignedIn(person) = stations::sign_in(state, station, typed).await? else {
            anyhow::bail!("{}: a guest who agrees was not signed in", study.title);
        };
        guests.push(StudyGuest { person: *person, group, place });
    }
    Ok(guests)
}

/// Plans the attempts of all guests, in sequence, each with the guest's index and the number of the
/// attempt.
fn plan_attempts(
    begun: Moment,
    guests: &[StudyGuest],
    bundle: &ExerciseBundle,
    seed: u64,
) -> anyhow::Result<Vec<((usize, u32), AttemptTask)>> {
    let all = (1..=ATTEMPTS_EACH).flat_map(|number| (0..guests.len()).map(move |guest| (number, guest)));
    let task = |(n, (number, guest)): (usize, (u32, usize))| {
        let person = seed.wrapping_mul(11_000_003) ^ guest as u64;
        let task = AttemptTask {
            bundle: bundle.clone(),
            skill: skill_of_guest(&guests[guest], number),
            seed: seed.wrapping_mul(13_000_003) ^ n as u64,
            occasion: Occasion { person, day: seed, attempt: u64::from(number) },
            trainee: guests[guest].person.pseudonym.clone(),
            at: begun.plus_s(i64::try_from(n)? * APART_S),
        };
        Ok(((guest, number), task))
    };
    all.enumerate().map(task).collect()
}

/// Returns the skill of a guest: the group's mean with individual scatter, and a small gain by
/// practice.
fn skill_of_guest(guest: &StudyGuest, number: u32) -> Skill {
    let middle = [0.10, 0.55, 0.95][guest.group.min(2)];
    let own = 0.08 * scatter_of_seed(guest.place as u64 * 3 + guest.group as u64);
    let learned = 0.04 * f64::from(number - 1);
    Skill::novice().towards(&Skill::expert(), (middle + own + learned).clamp(0.0, 1.0))
}

/// Answers the surveys of the study after an attempt.
async fn answer_after(
    state: &AppState,
    study: &Study,
    guest: &StudyGuest,
    session: &Session,
    last: bool,
) -> anyhow::Result<()> {
    let basis = basis_of_attempt(state, session.key()).await?;
    let participant = Participant { place: guest.group * EACH + guest.place, professional: guest.group > 0, basis };
    for survey in stored::list_study_surveys(state.db.reader(), study).await? {
        if survey.at_end && !last {
            continue;
        }
        let instrument = surveys::instrument_of(state, &survey).await?;
        let given = instrument.items.iter().enumerate();
        let given =
            given.filter_map(|(at, item)| Some((item.id.clone(), invent_answer(&instrument, at, participant)?)));
        let answers: BTreeMap<String, Vec<String>> = given.map(|(id, answer)| (id, texts_of_answer(answer))).collect();
        let secret = format!("{}{}", session.id.uuid().simple(), survey.id.uuid().simple());
        let sheet = AnsweredSheet {
            session,
            survey: survey.id,
            secret: &secret,
            language: "en",
            answers: &answers,
            sent: true,
        };
        surveys::take(state, &sheet).await?;
    }
    Ok(())
}

/// Converts an answer to the form in which a station sends it.
fn texts_of_answer(answer: Answer) -> Vec<String> {
    match answer {
        Answer::Number(number) => vec![number.to_string()],
        Answer::Text(text) => vec![text],
        Answer::Several(ids) => ids,
    }
}
