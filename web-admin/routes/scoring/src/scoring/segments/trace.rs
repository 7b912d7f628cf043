//! `/segments/traces/{id}`: the page to mark a trace. Until the marks are submitted it contains
//! only the force over time.

use acts::error::Error;
use acts::recordings::replays;
use acts::scoring::segments;
use axum::extract::State;
use model::ids::TraceId;
use model::recordings::series::{AttemptStretch, TimeSpan};
use model::scoring::segments::{MarksVerdict, read_pop_marks, strips};
use model::{CurrentPerson, Role};
use pages::form::FilledForm;
use pages::scoring::segments::{StripView, TracePage, TraceTruth};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::scoring::segments as stored;
use store::scoring::segments::{SegmentTask, Trace};

use crate::scoring::segments::{list_own_traces, make_task_row, trace_href};

/// Time spans per strip: finer than a pixel of its drawing.
const SPANS: usize = 500;

/// A trace that the visitor may see, and its attempt.
struct OpenTrace {
    task: SegmentTask,
    trace: Trace,
    session: Session,
}

async fn open_trace(state: &AppState, person: &CurrentPerson, id: TraceId) -> Result<OpenTrace, Error> {
    let (task, trace) = segments::trace(state, person, id).await?;
    let session = sessions::find_session(state.db.reader(), person.school_id, trace.session_id).await?;
    Ok(OpenTrace { task, trace, session: session.ok_or(Error::NotFound)? })
}

pub(super) async fn show_trace(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<TraceId>,
    csrf: Csrf,
) -> Result<TracePage, PageError> {
    let open = open_trace(&state, &person, id).await?;
    let marks = stored::list_marks_of(state.db.reader(), id, person.id).await?;
    let sent = marks.as_ref().is_some_and(|marks| marks.sent_at.is_some());
    let marks = marks.map(|marks| marks.marks.0).unwrap_or_default();
    let found = truth_of_trace(&state, &person, &open, &marks, sent).await?;
    let form = FilledForm::new(marks.iter().map(f64::to_string).collect());
    Ok(make_trace_page(&state, Visit::new(&person, &csrf), &open, ShownTrace { marks, form, found }).await?)
}

/// Returns the true pops: to trainees after they have submitted their marks, to teachers always.
async fn truth_of_trace(
    state: &AppState,
    person: &CurrentPerson,
    open: &OpenTrace,
    marks: &[f64],
    sent: bool,
) -> Result<Option<TraceTruth>, Error> {
    let teaches = person.role != Role::Trainee;
    if !sent && !teaches {
        return Ok(None);
    }
    let pops = segments::truth(state, person.school_id, &open.trace).await?;
    let verdict = (!teaches).then(|| MarksVerdict::of(&pops, marks));
    Ok(Some(TraceTruth { verdict, pops }))
}

/// The parts of the page other than the force.
struct ShownTrace {
    marks: Vec<f64>,
    form: FilledForm<Vec<String>>,
    found: Option<TraceTruth>,
}

async fn make_trace_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    open: &OpenTrace,
    shown: ShownTrace,
) -> Result<TracePage, Error> {
    let strips = strips(open.session.duration_s);
    let spans = spans_of_strips(state, &open.session, &strips).await?;
    let pops = shown.found.as_ref().map_or(&[][..], |found| &found.pops);
    let own = list_own_traces(state, person, open.task.id).await?;
    let place = own.iter().position(|(trace, _)| trace.id == open.trace.id).ok_or(Error::NotFound)? + 1;
    Ok(TracePage {
        shell: Shell::new(person, csrf.token(), NavPlace::Assignments),
        task: make_task_row(state, &open.task),
        trace: open.trace.id,
        place: (place, own.len()),
        duration_s: open.session.duration_s,
        strips: StripView::all(&spans, &strips, &shown.marks, pops),
        next: own.iter().find(|(_, sent)| !sent).map(|(trace, _)| trace_href(trace)),
        form: shown.form,
        found: shown.found,
    })
}

async fn spans_of_strips(
    state: &AppState,
    session: &Session,
    strips: &[(f64, f64)],
) -> Result<Vec<Vec<TimeSpan>>, Error> {
    let pyramid = replays::pyramid(state, session).await?;
    let stretch = |(from_s, to_s): &(f64, f64)| AttemptStretch { from_s: Some(*from_s), to_s: Some(*to_s) };
    Ok(strips.iter().map(|strip| pyramid.spans(SPANS, stretch(strip))).collect())
}

/// The submitted form.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct MarksForm {
    #[serde(rename = "do")]
    step: String,
    /// One field per mark.
    mark: Vec<String>,
}

pub(super) async fn mark_trace(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<TraceId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<MarksForm>,
) -> Result<FormAnswer<TracePage>, PageError> {
    let open = open_trace(&state, &person, id).await?;
    if person.role != Role::Trainee {
        return Err(Error::Forbidden(tr!("only trainees can mark pops")).into());
    }
    let sent = match form.step.as_str() {
        "save" => false,
        "send" => true,
        other => return Err(Error::BadRequest(format!("do: \"{other}\"; allowed: save, send")).into()),
    };
    match read_pop_marks(&form.mark, open.session.duration_s) {
        Ok(marks) => {
            segments::mark(&state, &person, &open.trace, marks, sent).await?;
            Ok(FormAnswer::lead_to(&trace_href(&open.trace)))
        }
        Err(refused) => {
            let kept = stored::list_marks_of(state.db.reader(), id, person.id).await?;
            if kept.as_ref().is_some_and(|kept| kept.sent_at.is_some()) {
                return Err(Error::Conflict(tr!("these marks were already sent").to_owned()).into());
            }
            let shown = ShownTrace {
                marks: kept.map(|kept| kept.marks.0).unwrap_or_default(),
                form: FilledForm::refused(form.mark, refused.to_string()),
                found: None,
            };
            Ok(FormAnswer::Refused(make_trace_page(&state, Visit::new(&person, &csrf), &open, shown).await?))
        }
    }
}
