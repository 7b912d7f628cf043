//! Changes a study: everything while it has no participants, afterwards only what they have not
//! agreed to.

use acts::error::Error;
use acts::studies as acting;
use acts::studies::{StudyChange, StudyTerms};
use axum::extract::State;
use model::ids::StudyId;
use model::single_line_text;
use pages::form::FilledForm;
use pages::studies::{NewStudyForm, StudyChangePage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use store::studies::{self, Study};

use super::find_own_study;
use super::make::{MOST_GROUPS, MOST_QUESTIONS, read_consent, read_count, read_line, read_names};

pub(super) async fn show_study_change(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    csrf: Csrf,
) -> Result<StudyChangePage, PageError> {
    let study = find_own_study(&state, &person, id).await?;
    let typed = NewStudyForm {
        title: study.title.clone(),
        attempts: study.attempts.to_string(),
        groups: study.groups.0.join("\n"),
        questions: study.questions.0.join("\n"),
        consent: study.consent.clone(),
        controller: study.controller.clone(),
        contact: study.contact.clone(),
        kept: study.kept_months.to_string(),
        ..NewStudyForm::default()
    };
    Ok(make_change_page(&state, Visit::new(&person, &csrf), &study, FilledForm::new(typed)).await?)
}

async fn make_change_page(
    state: &AppState,
    visit: Visit<'_>,
    study: &Study,
    form: FilledForm<NewStudyForm>,
) -> Result<StudyChangePage, Error> {
    Ok(StudyChangePage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Surveys),
        href: format!("/studies/{}", study.id),
        title: study.title.clone(),
        is_agreed: studies::count_participants(state.db.reader(), study).await? > 0,
        most_kept: study.kept_months,
        consent: study.consent.clone(),
        form,
    })
}

pub(super) async fn change_study(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<NewStudyForm>,
) -> Result<FormAnswer<StudyChangePage>, PageError> {
    let study = find_own_study(&state, &person, id).await?;
    let agreed = studies::count_participants(state.db.reader(), &study).await.map_err(Error::from)? > 0;
    let changed = match read_change(&form, agreed) {
        Ok(wanted) => split_refusal(acting::change_study(&state, &person, &study, &wanted).await)?,
        Err(why) => Err(why),
    };
    match changed {
        Ok(()) => Ok(FormAnswer::lead_to(&format!("/studies/{id}?done=changed"))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_change_page(&state, Visit::new(&person, &csrf), &study, form).await?))
        }
    }
}

fn read_change(form: &NewStudyForm, agreed: bool) -> Result<StudyChange, String> {
    let terms = || -> Result<StudyTerms, String> {
        Ok(StudyTerms {
            attempts: read_count(tr!("attempts"), &form.attempts, 50)?,
            groups: read_names(tr!("groups"), &form.groups, 2, MOST_GROUPS)?,
            questions: read_names(tr!("questions"), &form.questions, 0, MOST_QUESTIONS)?,
            consent: read_consent(&form.consent)?,
            controller: read_line(tr!("data controller"), &form.controller)?,
        })
    };
    Ok(StudyChange {
        title: single_line_text::title(&form.title)?.to_owned(),
        contact: read_line(tr!("contact"), &form.contact)?,
        kept_months: read_count(tr!("months"), &form.kept, 360)?,
        terms: if agreed { None } else { Some(terms()?) },
    })
}
