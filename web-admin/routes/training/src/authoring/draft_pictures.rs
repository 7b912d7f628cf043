//! `/drafts/{id}/pictures`: uploads pictures to the draft of an exercise, and serves them to its
//! form.

use acts::authoring::drafting::SaveOutcome;
use acts::authoring::images::SentPicture;
use acts::authoring::{SeenDraft, drafting, images};
use acts::error::Error;
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Redirect, Response};
use documents::picture::MOST_SENT_BYTES;
use model::authoring::EditedDocument;
use model::ids::{DraftId, SchoolId};
use pages::authoring::document_forms::{DraftPictures, place_id};
use pages::authoring::draft::DraftPage;
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfFileForm, Teacher};
use routes_base::authoring::pictures::{PictureQuery, answer_picture, place_picture};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use store::authoring::drafts::DocumentDraft;
use store::authoring::{drafts, pictures};

use super::drafts::{answer_conflict, make_draft_page, show_as};
use super::writing::SentDraft;

/// Maximum size of a form, in bytes. Larger than the largest allowed picture, so that an oversized
/// picture is refused with a message and the rest of the form is kept.
const MOST_FORM_BYTES: usize = 64 * 1024 * 1024;

/// Returns the routes of pictures in drafts.
pub(super) fn draft_picture_routes() -> Routes {
    Routes::new()
        .route(
            "/drafts/{id}/pictures",
            post(add_picture).layer(DefaultBodyLimit::max(MOST_FORM_BYTES)).get(lead_to_draft),
        )
        .route("/drafts/{id}/pictures/{name}", get(serve_draft_picture))
}

/// Returns the pictures of a draft as its form shows them.
pub(super) async fn list_at_hand(state: &AppState, school: SchoolId, draft: DraftId) -> Result<DraftPictures, Error> {
    let page = format!("/drafts/{draft}");
    let stored = pictures::list_draft_pictures(state.db.reader(), school, draft).await?;
    let placed = |picture: pictures::StoredPicture| place_picture(&page, &picture.name.clone(), picture);
    let at_hand = stored.into_iter().map(placed).collect();
    Ok(DraftPictures { href: format!("{page}/pictures"), at_hand })
}

/// Redirects to the draft when a browser reloads the address of a refused upload.
async fn lead_to_draft(Teacher(_): Teacher, PathId(id): PathId<DraftId>) -> Redirect {
    Redirect::to(&format!("/drafts/{id}"))
}

/// Saves the form with one more picture. If the picture is refused, nothing is saved, and the input
/// is shown again.
pub(super) async fn add_picture(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    csrf: Csrf,
    CsrfFileForm { fields, file }: CsrfFileForm<MOST_SENT_BYTES>,
) -> Result<FormAnswer<DraftPage>, PageError> {
    let alt = fields.iter().find(|(name, _)| name == "new.picture.alt").map(|(_, typed)| typed.clone());
    let alt = alt.unwrap_or_default();
    let sent = SentDraft::from_fields(fields)?;
    let (school, shown) = (person.school_id, sent.view.of(person.school_id));
    let seen = SeenDraft { id, version: sent.seen };
    let picture = SentPicture { bytes: file.bytes, is_cut: file.is_cut, alt: alt.clone() };
    let added = images::add_picture(&state, &person, seen, &sent.texts, picture).await;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    match split_refusal(added)? {
        Ok(SaveOutcome::Kept(draft)) => {
            let rows = EditedDocument::from_text(&draft.texts.document).map_or(0, |text| text.count_rows("picture"));
            let place = place_id(&format!("picture[{}]", rows.saturating_sub(1)));
            Ok(FormAnswer::lead_to(&format!("/drafts/{id}#{place}")))
        }
        Ok(SaveOutcome::Elsewhere(theirs)) => {
            let draft = theirs.clone();
            let page = show_as(&state, shown, &draft, answer_conflict(shell, theirs, sent.texts)).await?;
            Ok(FormAnswer::Answered((StatusCode::CONFLICT, page).into_response()))
        }
        Err(why) => {
            let draft = drafts::find_draft(state.db.reader(), school, id).await?.ok_or(Error::NotFound)?;
            // Keeps the version that was seen, so that a later save detects changes by another
            // person.
            let draft = DocumentDraft { texts: sent.texts, version: sent.seen, ..draft };
            let checked = drafting::check(&state, school, &draft).await?;
            let page = show_as(&state, shown, &draft.clone(), make_draft_page(shell, draft, &checked)).await?;
            Ok(FormAnswer::Refused(page.with_refused_picture(alt, why)))
        }
    }
}

pub(super) async fn serve_draft_picture(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path((id, name)): Path<(String, String)>,
    Query(asked): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, PageError> {
    let id: DraftId = id.parse().map_err(|_| Error::NotFound)?;
    let found = pictures::read_draft_picture(state.db.reader(), person.school_id, id, &name).await?;
    Ok(answer_picture(&found.ok_or(Error::NotFound)?, &asked, &headers)?)
}
