//! `/people/{id}/erase`: shows which data of a person an erasure removes, and erases them.

use acts::error::Error;
use acts::privacy::erasing;
use acts::privacy::erasing::Eraser;
use axum::extract::State;
use model::CurrentPerson;
use model::ids::PersonId;
use model::people::directory::{AccountState, DirectoryEntry};
use model::people::email::normalize_email;
use pages::form::read_ticked_box;
use pages::privacy::erasing::ErasePage;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::operations::schools;
use store::privacy::texts::TextOwner;
use store::privacy::{retention, texts};

use crate::people::directory::{find_person, refuse_own_account};

pub(super) async fn show_erasing(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<ErasePage, PageError> {
    let person = find_erasable(&state, &visitor, id).await?;
    Ok(make_erase_page(&state, Visit::new(&visitor, &csrf), person).await?)
}

/// Returns a person of the administrator's school who is not erased yet and is not the
/// administrator.
async fn find_erasable(state: &AppState, visitor: &CurrentPerson, id: PersonId) -> Result<DirectoryEntry, PageError> {
    let person = find_person(state, visitor, id).await?;
    refuse_own_account(visitor, id)?;
    if person.state == AccountState::Erased {
        return Err(Error::Conflict(tr!("this person is anonymised; that cannot be undone").to_owned()).into());
    }
    Ok(person)
}

async fn make_erase_page(
    state: &AppState,
    Visit { person: visitor, csrf }: Visit<'_>,
    person: DirectoryEntry,
) -> Result<ErasePage, Error> {
    let (reader, school_id) = (state.db.reader(), visitor.school_id);
    let whose = TextOwner { school_id, person_id: person.id, until: state.clock.now() };
    let mentions = texts::list_mentions(reader, whose, &texts::words_of(&person.name)).await?;
    Ok(ErasePage {
        shell: Shell::new(visitor, csrf.token(), NavPlace::People),
        texts: texts::count_texts(reader, whose).await?,
        recordings: schools::erases_recordings(reader, school_id).await?,
        mentions: mentions.into_iter().map(|found| (format!("/sessions/{}", found.session_id), found.text)).collect(),
        held: retention::find_hold_time(reader, school_id, person.id).await?.is_some(),
        unconfirmed: false,
        person,
    })
}

/// Confirmation of an erasure, which cannot be undone, and the choice of what else to erase.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct EraseForm {
    confirm: String,
    #[serde(default, deserialize_with = "read_ticked_box")]
    written: bool,
    #[serde(default, deserialize_with = "read_ticked_box")]
    about: bool,
}

pub(super) async fn erase_person(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<EraseForm>,
) -> Result<FormAnswer<ErasePage>, PageError> {
    let person = find_erasable(&state, &visitor, id).await?;
    if normalize_email(&form.confirm) != normalize_email(&person.email) {
        let page = make_erase_page(&state, Visit::new(&visitor, &csrf), person).await?;
        return Ok(FormAnswer::Refused(ErasePage { unconfirmed: true, ..page }));
    }
    let wish = erasing::wish_of_school(&state, visitor.school_id, form.written, form.about).await?;
    erasing::erase(&state, Eraser::person(&visitor), &person, visitor.school_id, wish).await?;
    Ok(FormAnswer::lead_to(&format!("/people/{id}?done=erased")))
}
