//! Copies of pictures that somebody sent: made by a helper with limits of memory and time, a few at once and each school in its turn.

use std::time::Duration;

use data_encoding::BASE64;
use documents::picture::{PictureCopy, PictureKind};
use model::ids::SchoolId;

use crate::asking;
use crate::error::Error;
use crate::judging::{CopiedPicture, JudgeAnswer, JudgeQuestion, PictureQuestion};
use crate::service::Service;

/// Longest wait until it is one's turn.
const PATIENCE: Duration = Duration::from_secs(20);

/// The pixels of a picture, and nothing else of the file; or why it is refused, in the reader's language.
///
/// # Errors
/// [`Error::Busy`] when others of the school are before it, or nobody can be asked.
pub(crate) async fn copy_picture(
    state: &Service,
    school: SchoolId,
    sent: &[u8],
    is_logo: bool,
) -> Result<Result<PictureCopy, String>, Error> {
    let place = state.helpers.enter(school, PATIENCE).await;
    let _place = place.ok_or(Error::Busy { retry_after_s: PATIENCE.as_secs() })?;
    let language = words::current().code().to_owned();
    let question = JudgeQuestion::Picture(PictureQuestion { base64: BASE64.encode(sent), is_logo, language });
    match asking::ask(state, question).await? {
        JudgeAnswer::Copied(Ok(copied)) => read_copy(copied).map(Ok),
        JudgeAnswer::Copied(Err(why)) => Ok(Err(why)),
        JudgeAnswer::Died(how) => {
            tracing::warn!(%school, how, "a helper died of a picture, which was refused");
            Ok(Err(tr!("the picture takes too much memory or time to be read").to_owned()))
        }
        other => Err(anyhow::anyhow!("a picture was to be copied, and the answer was {other:?}").into()),
    }
}

fn read_copy(copied: CopiedPicture) -> Result<PictureCopy, Error> {
    let bytes = BASE64.decode(copied.base64.as_bytes()).map_err(anyhow::Error::from)?;
    let kind = PictureKind::of_bytes(&bytes).ok_or_else(|| anyhow::anyhow!("a copy is no picture"))?;
    Ok(PictureCopy { kind, size: copied.size, bytes })
}
