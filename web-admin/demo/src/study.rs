//! A finished survey study of the demonstration: twelve professionals and twelve trainees on
//! workload and on the simulator's validity. The answers are generated from attempts, submitted
//! through the same form as real ones, and labelled as generated.

use acts::surveys;
use acts::surveys::answering::SurveyOccasion;
use acts::surveys::{SurveyRequest, answering};
use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::Instrument;
use documents::instrument::ScaleKind;
use model::ids::{SchoolId, SessionId};
use model::surveys::{Identity, Survey};
use model::{CurrentPerson, SessionKey};
use routes_base::AppState;
use store::people::{self, Person};
use store::scoring::scores;
use store::surveys as stored;
use store::surveys::instruments;
use store::training::{practice, reports};
use worker::outbox;

use crate::people::Trainee;
use crate::school::{self, COHORT_BEFORE, COHORTS};

/// Number of participants in each of the two groups.
const PEOPLE: usize = 12;

/// Professionals who are sent a link by mail: name and address.
const INVITED: [(&str, &str); 2] =
    [("Lena Vogt", "lena.vogt@clinic.example"), ("Samuel Adeyemi", "samuel.adeyemi@clinic.example")];

/// Free-text answers, in rotation; an empty text is no answer.
const COMMENTS: [&str; 12] = [
    "The pop at the fascia comes very close to what I know.",
    "",
    "Friction on the way out is too low.",
    "I looked at the picture too much; hide it for the experienced.",
    "",
    "Good for learning when to stop. A thicker patient would help.",
    "",
    "The skin gives way too suddenly.",
    "It took me three attempts to feel the second layer at all.",
    "",
    "More of this before the first patient, please.",
    "",
];

/// The attempt from which answers are generated.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnswerBasis {
    /// The attempt.
    session: SessionId,
    /// Its score, 0–1.
    score: f64,
    /// Its peak force, as a fraction of 10 N.
    force: f64,
}

/// A participant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Participant {
    /// Index within their group.
    pub(super) place: usize,
    /// Whether they are a professional rather than a trainee.
    pub(super) professional: bool,
    /// Their attempt; for a professional, one of the best in the school.
    pub(super) basis: AnswerBasis,
}

/// A survey of the study to create.
struct PlannedSurvey {
    /// Id of its instrument.
    instrument: &'static str,
    title: &'static str,
    /// Whether it follows each attempt, or is answered once.
    after_attempts: bool,
}

const SURVEYS: [PlannedSurvey; 2] = [
    PlannedSurvey { instrument: "nasa-tlx", title: "Study: workload of an attempt", after_attempts: true },
    PlannedSurvey {
        instrument: "simulator-validity",
        title: "Study: is the simulator like a patient?",
        after_attempts: false,
    },
];

/// Creates both surveys of the study, has them answered, and closes them.
///
/// # Errors
/// Fails if the instruments are missing, or the database fails.
pub(super) async fn hold_study(state: &AppState, school: SchoolId, trainees: &[Trainee]) -> anyhow::Result<()> {
    let mut bases = Vec::new();
    for trainee in trainees {
        if let Some(basis) = latest_basis(state, trainee).await? {
            bases.push((trainee, basis));
        }
    }
    let mut best: Vec<AnswerBasis> = bases.iter().map(|(_, basis)| *basis).collect();
    best.sort_by(|a, b| b.score.total_cmp(&a.score));
    best.truncate(PEOPLE.div_ceil(2));
    bases.truncate(PEOPLE);
    if best.is_empty() {
        return Ok(());
    }
    for plan in &SURVEYS {
        let owner = find_study_owner(state).await?;
        let survey = make_study_survey(state, &owner, school, plan).await?;
        let asked = surveys::instrument_of(state, &survey).await?;
        let study = SurveyStudy { state, survey: &survey, instrument: &asked };
        for (place, (trainee, basis)) in bases.iter().enumerate() {
            study.trainee(trainee, Participant { place, professional: false, basis: *basis }).await?;
        }
        study.professionals(&owner, &best).await?;
        study.invite(&owner).await?;
        surveys::close(state, &owner, &survey, true).await?;
    }
    Ok(())
}

pub(super) async fn find_study_owner(state: &AppState) -> anyhow::Result<CurrentPerson> {
    let instructor = people::find_person_by_email(state.db.reader(), &school::email_of(COHORTS[0].instructor)).await?;
    instructor.and_then(Person::into_current).context("the demonstration has an instructor")
}

/// Returns a trainee's latest attempt as the basis of answers, if any.
async fn latest_basis(state: &AppState, trainee: &Trainee) -> anyhow::Result<Option<AnswerBasis>> {
    let reader = state.db.reader();
    let attempts = practice::list_trainee_practice(reader, trainee.school_id, trainee.id).await?;
    let Some(attempt) = attempts.iter().max_by_key(|attempt| attempt.at) else { return Ok(None) };
    Ok(Some(basis_of_attempt(state, SessionKey { school_id: trainee.school_id, id: attempt.session }).await?))
}

/// Returns the basis of answers for a scored attempt.
pub(super) async fn basis_of_attempt(state: &AppState, attempt: SessionKey) -> anyhow::Result<AnswerBasis> {
    let reader = state.db.reader();
    let score = scores::find_newest_score(reader, attempt).await?.context("an attempt without a score")?.score / 100.0;
    let metrics = scores::list_score_metrics(reader, attempt).await?;
    let force_n = metrics.iter().find(|metric| metric.id == "peak_force_n").and_then(|metric| metric.value);
    let force = (force_n.unwrap_or(3.0) / 10.0).clamp(0.0, 1.0);
    Ok(AnswerBasis { session: attempt.id, score, force })
}

async fn make_study_survey(
    state: &AppState,
    owner: &CurrentPerson,
    school: SchoolId,
    plan: &PlannedSurvey,
) -> anyhow::Result<Survey> {
    let reader = state.db.reader();
    let current = instruments::find_current_instrument(reader, school, plan.instrument)
        .await?
        .context("the instrument is shipped")?;
    let administrator = people::find_person_by_email(reader, &school::email_of(school::ADMINISTRATOR)).await?;
    let administrator =
        administrator.and_then(Person::into_current).context("the demonstration has an administrator")?;
    let cohorts = reports::cohorts(reader, &administrator).await?;
    let wanted = SurveyRequest {
        revision_id: current.id,
        title: plan.title.to_owned(),
        identity: Identity::Pseudonymous,
        after_attempts: plan.after_attempts,
        // The attempts are days old, but their surveys should still be offered.
        fresh_hours: None,
        generated: true,
        opens_at: state.clock.now().plus_s(-28 * 24 * 3600),
        closes_at: None,
        cohorts: cohorts.iter().filter(|cohort| cohort.name != COHORT_BEFORE).map(|cohort| cohort.id).collect(),
    };
    let id = surveys::make(state, owner, &wanted).await?;
    stored::find(reader, school, id).await?.context("the survey that was made")
}

struct SurveyStudy<'a> {
    state: &'a AppState,
    survey: &'a Survey,
    instrument: &'a Instrument,
}

impl SurveyStudy<'_> {
    async fn trainee(&self, trainee: &Trainee, participant: Participant) -> anyhow::Result<()> {
        let person = people::find_person(self.state.db.reader(), trainee.id).await?;
        let person = person.and_then(Person::into_current).context("a trainee of the demonstration")?;
        let session = self.survey.after_attempts.then_some(participant.basis.session);
        let asked = SurveyOccasion { survey: self.survey, session, language: "en" };
        let token = answering::begin(self.state, &person, asked).await?;
        self.answer(&token, participant).await
    }

    async fn professionals(&self, owner: &CurrentPerson, best: &[AnswerBasis]) -> anyhow::Result<()> {
        let labels: Vec<String> = (1..=PEOPLE).map(|n| format!("Professional {n} (generated)")).collect();
        let links = surveys::make_links(self.state, owner, self.survey, &labels).await?;
        for (place, link) in links.iter().enumerate() {
            let basis = best[place % best.len()];
            self.answer(&link.token, Participant { place, professional: true, basis }).await?;
        }
        Ok(())
    }

    /// Mails links to two professionals who have not answered; the mails are files in the mail
    /// folder.
    async fn invite(&self, owner: &CurrentPerson) -> anyhow::Result<()> {
        let invited = INVITED.map(|(name, email)| (name.to_owned(), email.to_owned()));
        surveys::mail_links(self.state, owner, self.survey, &invited).await?;
        Ok(outbox::work_off_letters(self.state).await?)
    }

    async fn answer(&self, token: &str, participant: Participant) -> anyhow::Result<()> {
        let mut answering = answering::open(self.state, token).await?;
        let answers = 0..self.instrument.items.len();
        answering.response.answers.0 = answers.map(|at| invent_answer(self.instrument, at, participant)).collect();
        Ok(answering.send(self.state).await?)
    }
}

/// Generates an answer from the attempt, with a realistic scatter; one in forty is left out.
pub(super) fn invent_answer(instrument: &Instrument, at: usize, participant: Participant) -> Option<Answer> {
    let item = instrument.items.get(at)?;
    let seed = (participant.place * 131 + at * 17 + usize::from(participant.professional) * 7) as u64;
    if scatter_of_seed(seed ^ 0x5eed) > 0.95 {
        return None;
    }
    // Some people rate higher than others throughout; without this, no scale would be internally
    // consistent.
    let person = scatter_of_seed(participant.place as u64 * 2 + u64::from(participant.professional));
    let lean = lean_of_item(&item.id, participant)
        + 0.18 * person
        + 0.14 * (scatter_of_seed(seed) + scatter_of_seed(seed + 1000))
        - 0.05;
    match instrument.scale(item)? {
        ScaleKind::Likert { points, .. } => {
            let last = f64::from(*points) - 1.0;
            Some(Answer::Number(1.0 + (lean.clamp(0.0, 1.0) * last).round()))
        }
        ScaleKind::Slider { min, max, step, .. } => {
            let steps = (lean.clamp(0.0, 1.0) * (max - min) / step).round();
            Some(Answer::Number(min + steps * step))
        }
        ScaleKind::Choice { options } => {
            let place = if participant.professional { 2 + participant.place % 2 } else { participant.place % 2 };
            options.get(place).map(|option| Answer::Text(option.id.clone()))
        }
        ScaleKind::Number { .. } => {
            let years = if participant.professional { 3 + participant.place % 8 * 2 } else { 1 };
            Some(Answer::Number(years as f64))
        }
        ScaleKind::Text { .. } => {
            let text = COMMENTS[(participant.place + usize::from(participant.professional) * 5) % COMMENTS.len()];
            (!text.is_empty()).then(|| Answer::Text(text.to_owned()))
        }
        ScaleKind::Pair | ScaleKind::Choices { .. } => None,
    }
}

/// Returns the mean of an answer between the ends of its scale, 0–1, before scatter.
fn lean_of_item(item: &str, Participant { professional, basis, .. }: Participant) -> f64 {
    let failed = 1.0 - basis.score;
    let ease = if professional { 0.15 } else { 0.0 };
    match item {
        "mental" => 0.30 + 0.45 * failed - ease,
        "physical" => 0.10 + 0.80 * basis.force - ease,
        "temporal" => 0.25 + 0.25 * failed - ease,
        "performance" => 0.85 * failed,
        "effort" => 0.25 + 0.35 * failed + 0.40 * basis.force - ease,
        "frustration" => 0.10 + 0.60 * failed - ease,
        "pops" | "layers" | "training" | "c-stop" | "c-recognise" => 0.82,
        "friction" | "looks" => {
            if professional {
                0.45
            } else {
                0.65
            }
        }
        "assessment" => {
            if professional {
                0.55
            } else {
                0.50 + 0.3 * basis.score
            }
        }
        _ => 0.68 + 0.15 * basis.score,
    }
}

/// Returns a deterministic pseudo-random number from −1 to 1 (the finalizer of splitmix64).
pub(super) fn scatter_of_seed(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
