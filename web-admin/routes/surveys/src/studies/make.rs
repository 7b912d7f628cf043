//! Creates studies.

use acts::error::Error;
use acts::studies as acting;
use acts::studies::StudyRequest;
use acts::surveys::list_titled_instruments;
use axum::extract::State;
use model::ids::RevisionId;
use model::single_line_text;
use pages::form::FilledForm;
use pages::studies::{NewStudyForm, NewStudyPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use store::authoring::exercises;
use store::operations::schools;
use store::surveys::instruments;
use store::surveys::instruments::InstrumentRevision;

/// Maximum number of exercises and of instruments of a study, of groups, and of questions to each
/// participant.
const MOST: usize = 10;
pub(super) const MOST_GROUPS: usize = 5;
pub(super) const MOST_QUESTIONS: usize = 6;
/// Maximum length of the name of a group or a question, and of the consent text, in characters.
const LONGEST_NAME: usize = 60;
const LONGEST_CONSENT: usize = 4000;

pub(super) async fn show_new_study(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<NewStudyPage, PageError> {
    let school = schools::find_school_name(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let blank = NewStudyForm {
        attempts: "3".to_owned(),
        groups: [tr!("Novices"), tr!("Intermediates"), tr!("Experts")].join("\n"),
        questions: [tr!("Role"), tr!("Speciality"), tr!("Years of practice")].join("\n"),
        consent: tr!(
            "My participation is voluntary. My attempts at the simulator and my answers are recorded under a pseudonym and analysed for this study. I can stop at any time and have my data deleted, without giving a reason."
        )
        .to_owned(),
        controller: school,
        kept: "120".to_owned(),
        ..NewStudyForm::default()
    };
    Ok(make_new_study_page(&state, Visit::new(&person, &csrf), FilledForm::new(blank)).await?)
}

async fn make_new_study_page(
    state: &AppState,
    visit: Visit<'_>,
    form: FilledForm<NewStudyForm>,
) -> Result<NewStudyPage, Error> {
    let (reader, school) = (state.db.reader(), visit.person.school_id);
    let taught = exercises::list_current_exercises(reader, school).await?;
    let known = list_titled_instruments(state, school).await?;
    Ok(NewStudyPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Surveys),
        exercises: taught.into_iter().map(|exercise| (exercise.exercise_id, exercise.title)).collect(),
        instruments: known.into_iter().map(|instrument| (instrument.instrument_id, instrument.title)).collect(),
        form,
    })
}

pub(super) async fn make_study(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<NewStudyForm>,
) -> Result<FormAnswer<NewStudyPage>, PageError> {
    let known =
        instruments::list_current_instruments(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let made = match read_study(&form, &known) {
        Ok(wanted) => split_refusal(acting::make_study(&state, &person, &wanted).await)?,
        Err(why) => Err(why),
    };
    match made {
        Ok(id) => Ok(FormAnswer::lead_to(&format!("/studies/{id}"))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_new_study_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

fn read_study(form: &NewStudyForm, known: &[InstrumentRevision]) -> Result<StudyRequest, String> {
    let title = single_line_text::title(&form.title)?.to_owned();
    if form.exercises.is_empty() || form.exercises.len() > MOST {
        return Err(tr!("exercises: {count}; choose 1 to {most}", count = form.exercises.len(), most = MOST));
    }
    let consent = read_consent(&form.consent)?;
    Ok(StudyRequest {
        title,
        exercises: form.exercises.clone(),
        attempts: read_count(tr!("attempts"), &form.attempts, 50)?,
        groups: read_names(tr!("groups"), &form.groups, 2, MOST_GROUPS)?,
        questions: read_names(tr!("questions"), &form.questions, 0, MOST_QUESTIONS)?,
        after_each: read_instruments(&form.after, known)?,
        at_end: read_instruments(&form.end, known)?,
        consent,
        controller: read_line(tr!("data controller"), &form.controller)?,
        contact: read_line(tr!("contact"), &form.contact)?,
        kept_months: read_count(tr!("months"), &form.kept, 360)?,
        generated: false,
    })
}

pub(super) fn read_consent(typed: &str) -> Result<String, String> {
    let consent = typed.replace("\r\n", "\n").trim().to_owned();
    if consent.is_empty() || consent.chars().count() > LONGEST_CONSENT {
        return Err(tr!("the consent text: allowed: 1 to {most} characters", most = LONGEST_CONSENT));
    }
    Ok(consent)
}

pub(super) fn read_count(field: &str, typed: &str, most: u32) -> Result<u32, String> {
    let count = typed.parse().ok().filter(|count| (1..=most).contains(count));
    count.ok_or_else(|| tr!("{field}: “{typed}”; allowed: 1 to {most}", field = field, typed = typed, most = most))
}

pub(super) fn read_line(field: &str, typed: &str) -> Result<String, String> {
    match typed.chars().count() {
        1..=200 => single_line_text::refusal(field, typed).map_or_else(|| Ok(typed.to_owned()), Err),
        count => Err(tr!("{field}: {count} characters; allowed: 1 to 200", field = field, count = count)),
    }
}

/// Parses unique names, one per line.
pub(super) fn read_names(field: &str, typed: &str, least: usize, most: usize) -> Result<Vec<String>, String> {
    let names: Vec<String> = typed.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect();
    if !(least..=most).contains(&names.len()) {
        let (count, field) = (names.len(), field);
        return Err(tr!(
            "{field}: {count} lines; allowed: {least} to {most}",
            field = field,
            count = count,
            least = least,
            most = most
        ));
    }
    for (at, name) in names.iter().enumerate() {
        if name.chars().count() > LONGEST_NAME || names[..at].contains(name) {
            return Err(tr!(
                "{field}: “{name}”; each once, at most {most} characters",
                field = field,
                name = name,
                most = LONGEST_NAME
            ));
        }
        if let Some(why) = single_line_text::refusal(field, name) {
            return Err(why);
        }
    }
    Ok(names)
}

/// Returns the chosen instruments in their current revisions.
fn read_instruments(chosen: &[String], known: &[InstrumentRevision]) -> Result<Vec<(RevisionId, String)>, String> {
    let find = |id: &String| {
        let found = known.iter().find(|instrument| instrument.instrument_id == *id);
        let found = found.map(|instrument| (instrument.id, instrument.title.clone()));
        found.ok_or_else(|| tr!("questionnaire: “{id}” does not exist in this school", id = id))
    };
    chosen.iter().take(MOST).map(find).collect()
}
