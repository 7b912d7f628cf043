//! Sends a job to the sandboxed helper process, or runs it in-process if no helper is configured.

use std::time::Duration;

use platform::helper::{Helper, HelperExit, run_helper};

use crate::sandbox_jobs::{SandboxRequest, SandboxResponse, answer};
use crate::service::Service;

/// Time limit for reading an uploaded recording.
const LONGEST_READING: Duration = Duration::from_secs(60);
/// Time limit for reading a workbook or an image.
const LONGEST_FILE: Duration = Duration::from_secs(10);

/// Runs a job and returns its result. Dropping the future kills the helper.
///
/// # Errors
/// Fails if the helper cannot be started or its output cannot be parsed. A crash or a timeout of
/// the helper is not an error but [`SandboxResponse::Died`].
pub async fn ask(state: &Service, question: SandboxRequest) -> anyhow::Result<SandboxResponse> {
    call_within(state, question, Duration::MAX).await
}

/// Like [`ask`], with an upper limit on the time. In-process jobs have no time limit.
///
/// # Errors
/// As [`ask`].
pub async fn call_within(state: &Service, question: SandboxRequest, most: Duration) -> anyhow::Result<SandboxResponse> {
    let Some(helper) = &state.config.helper else {
        let examine_draft = state.examine_draft;
        return Ok(state.parse(move || answer(question, examine_draft)).await?);
    };
    let time = match &question {
        SandboxRequest::Recording(_) => helper.time,
        SandboxRequest::Arrival(_) => helper.time.min(LONGEST_READING),
        SandboxRequest::Draft(_) => state.config.preview_time,
        SandboxRequest::Workbook(_) | SandboxRequest::Picture(_) => helper.time.min(LONGEST_FILE),
        SandboxRequest::Annotate(_) => helper.time.min(LONGEST_READING),
    };
    ask_helper(Helper { time: time.min(most), ..helper.clone() }, &question).await
}

async fn ask_helper(helper: Helper, question: &SandboxRequest) -> anyhow::Result<SandboxResponse> {
    let input = serde_json::to_vec(question)?;
    let (time_s, memory_mb) = (helper.time.as_secs(), helper.memory_mb);
    let ended = run_helper(helper, input).await?;
    Ok(match ended {
        HelperExit::Said(said) => serde_json::from_slice(&said)?,
        HelperExit::Late => SandboxResponse::Died(format!("exceeded the time limit of {time_s} s")),
        HelperExit::Died(how) => {
            SandboxResponse::Died(format!("the sandboxed process, limited to {memory_mb} MB of memory, crashed: {how}"))
        }
    })
}
