//! Sanitizes uploaded images: a helper process with memory and time limits copies their pixels.
//! Schools are scheduled fairly.

use std::time::Duration;

use data_encoding::BASE64;
use documents::picture::{PictureCopy, PictureKind};
use model::ids::SchoolId;

use crate::error::Error;
use crate::sandbox;
use crate::sandbox_jobs::{CopiedPicture, PictureQuestion, SandboxRequest, SandboxResponse};
use crate::service::Service;

/// Maximum time in the queue.
const PATIENCE: Duration = Duration::from_secs(20);

/// Copies only the pixels of an image, without metadata. If the image is rejected, returns the
/// reason in the reader's language.
///
/// # Errors
/// Returns [`Error::Busy`] if the school's queue is full; fails if no helper can be started.
pub(crate) async fn copy_picture(
    state: &Service,
    school: SchoolId,
    sent: &[u8],
    is_logo: bool,
) -> Result<Result<PictureCopy, String>, Error> {
    let _place = state.helpers.enter(school, PATIENCE).await?;
    let language = words::current().code().to_owned();
    let question = SandboxRequest::Picture(PictureQuestion { base64: BASE64.encode(sent), is_logo, language });
    match sandbox::ask(state, question).await? {
        SandboxResponse::Copied(Ok(copied)) => read_copy(copied).map(Ok),
        SandboxResponse::Copied(Err(why)) => Ok(Err(why)),
        SandboxResponse::Died(how) => {
            tracing::warn!(%school, how, "sandboxed process crashed on a picture; picture rejected");
            Ok(Err(tr!("reading the picture takes too much memory or time; choose a smaller one").to_owned()))
        }
        other => Err(anyhow::anyhow!("unexpected answer to a request to copy a picture: {other:?}").into()),
    }
}

fn read_copy(copied: CopiedPicture) -> Result<PictureCopy, Error> {
    let bytes = BASE64.decode(copied.base64.as_bytes()).map_err(anyhow::Error::from)?;
    let kind = PictureKind::of_bytes(&bytes).ok_or_else(|| anyhow::anyhow!("the copy is not a picture"))?;
    Ok(PictureCopy { kind, size: copied.size, bytes })
}
