//! `/rate/{id}`: the page where a rater rates an attempt, addressed by the id of the rating only.
//! It discloses neither the trainee nor the time nor the score of the attempt.

use acts::error::Error;
use acts::scoring::ratings;
use acts::scoring::ratings::Rated;
use assessment::questionnaire::Answer;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use documents::Instrument;
use documents::instrument::Item;
use model::CurrentPerson;
use model::ids::RatingId;
use model::surveys::given::GivenAnswers;
use pages::charts::Drawing;
use pages::scoring::rating::RatePage;
use pages::scoring::replay_events::NamedHappenings;
use pages::surveys::form::{FormQuestion, GivenField, Refusals};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::scoring::{ratings as stored, scores};

use crate::recordings::sessions as attempts;
use crate::scoring::ratings::{own_ratings, round_href};

pub(super) async fn show_rating(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RatingId>,
    csrf: Csrf,
) -> Result<RatePage, PageError> {
    let rated = ratings::open(&state, &person, id).await?;
    Ok(make_rate_page(&state, Visit::new(&person, &csrf), &rated, &Refusals::default(), &GivenAnswers::default())
        .await?)
}

async fn make_rate_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    rated: &Rated,
    refusals: &Refusals,
    given: &GivenAnswers,
) -> Result<RatePage, Error> {
    let session = ratings::attempt(state, person, rated.rating.id).await?;
    let curve = scores::find_curve(state.db.reader(), session.key()).await?;
    let own = stored::own(state.db.reader(), person, rated.round.id).await?;
    let finished = rated.rating.finished_at.is_some();
    Ok(RatePage {
        shell: Shell::new(person, csrf.token(), NavPlace::Review),
        rating: rated.rating.id,
        round: (rated.round.title.clone(), round_href(rated.round.id)),
        exercise: attempts::title_of_exercise(state, &session).await?,
        drawing: curve.as_ref().map(|curve| Drawing::new(curve).leading_to("")),
        happened: NamedHappenings::new(curve.as_ref(), "", session.duration_s),
        questions: match finished {
            true => Vec::new(),
            false => {
                let input = RaterInput { refusals, given };
                list_rater_questions(&rated.instrument, &rated.rating.answers, input)
            }
        },
        own: own_ratings(&own, Some(rated.rating.id)),
        finished,
    })
}

/// Input of a rater's form: refused answers, and the fields as submitted.
#[derive(Clone, Copy)]
pub(in crate::scoring) struct RaterInput<'a> {
    /// Refused answers.
    pub refusals: &'a Refusals,
    /// Submitted fields.
    pub given: &'a GivenAnswers,
}

/// Returns the questions of an instrument with the answers so far, which are as many as its items.
pub(in crate::scoring) fn list_rater_questions(
    instrument: &Instrument,
    answers: &[Option<Answer>],
    RaterInput { refusals, given }: RaterInput<'_>,
) -> Vec<FormQuestion> {
    let question = |(at, item): (usize, &Item)| {
        let (answer, refused) = (answers[at].as_ref(), refusals.at(at));
        let left_out = given.is_left_out(item);
        let offered = (answer.is_none() && (left_out || refused.is_some())).then_some(left_out);
        let given = GivenField { answer, refused, left_out: offered };
        FormQuestion::new(instrument, item, instrument.language_for(words::current().code()), &given)
    };
    instrument.items.iter().enumerate().map(question).collect()
}

/// The submitted form.
#[derive(Deserialize)]
pub(in crate::scoring) struct RateForm {
    #[serde(rename = "do", default)]
    pub(in crate::scoring) step: String,
    #[serde(flatten)]
    pub(in crate::scoring) given: GivenAnswers,
}

pub(super) async fn act_on_rating(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RatingId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<RateForm>,
) -> Result<FormAnswer<RatePage>, PageError> {
    let mut rated = ratings::open(&state, &person, id).await?;
    let refused = rated.read(&form.given);
    if !refused.is_empty() {
        let refusals = Refusals::new(&rated.instrument, &form.given, &refused);
        let page = make_rate_page(&state, Visit::new(&person, &csrf), &rated, &refusals, &form.given).await?;
        return Ok(FormAnswer::Refused(page));
    }
    match form.step.as_str() {
        "save" => {
            rated.save(&state).await?;
            Ok(FormAnswer::Answered(StatusCode::NO_CONTENT.into_response()))
        }
        "keep" => {
            rated.save(&state).await?;
            Ok(FormAnswer::lead_to(&round_href(rated.round.id)))
        }
        "finish" => {
            let blank = rated.unanswered(&form.given);
            if !blank.is_empty() {
                rated.save(&state).await?;
                let refusals = Refusals::of_blanks(&blank);
                let page = make_rate_page(&state, Visit::new(&person, &csrf), &rated, &refusals, &form.given).await?;
                return Ok(FormAnswer::Refused(page));
            }
            rated.finish(&state, &person).await?;
            Ok(FormAnswer::lead_to(&next_rating_href(&state, &person, &rated).await?))
        }
        other => Err(Error::BadRequest(format!("do: \"{other}\"; allowed: save, keep, finish")).into()),
    }
}

/// Returns the address of the visitor's next open rating, or of the round's results.
async fn next_rating_href(state: &AppState, person: &CurrentPerson, rated: &Rated) -> Result<String, Error> {
    let own = stored::own(state.db.reader(), person, rated.round.id).await?;
    let open = own.iter().find(|rating| rating.finished_at.is_none());
    Ok(open.map_or_else(|| round_href(rated.round.id), |rating| format!("/rate/{}", rating.id)))
}
