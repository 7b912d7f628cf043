//! Asks whoever judges: a helper, or where there is none this very process.

use std::time::Duration;

use crate::helper::{Helper, HelperExit, run_helper};
use crate::judging::{JudgeAnswer, JudgeQuestion, answer};
use crate::service::Service;

/// Longest that reading what has just arrived may take.
const LONGEST_READING: Duration = Duration::from_secs(60);
/// Longest that reading a workbook or a picture may take.
const LONGEST_FILE: Duration = Duration::from_secs(10);

/// Has a question answered. Dropped, the helper that works on it is ended.
///
/// # Errors
/// When nobody can be asked.
pub async fn ask(state: &Service, question: JudgeQuestion) -> anyhow::Result<JudgeAnswer> {
    ask_within(state, question, Duration::MAX).await
}

/// Has a question answered, in no more than a time.
///
/// # Errors
/// When nobody can be asked.
pub async fn ask_within(state: &Service, question: JudgeQuestion, most: Duration) -> anyhow::Result<JudgeAnswer> {
    let Some(helper) = &state.config.helper else {
        let examine_draft = state.examine_draft;
        return Ok(state.parse(move || answer(question, examine_draft)).await?);
    };
    let time = match &question {
        JudgeQuestion::Recording(_) => helper.time,
        JudgeQuestion::Arrival(_) => helper.time.min(LONGEST_READING),
        JudgeQuestion::Draft(_) => state.config.preview_time,
        JudgeQuestion::Workbook(_) | JudgeQuestion::Picture(_) => helper.time.min(LONGEST_FILE),
        JudgeQuestion::Annotate(_) => helper.time.min(LONGEST_READING),
    };
    ask_helper(Helper { time: time.min(most), ..helper.clone() }, &question).await
}

async fn ask_helper(helper: Helper, question: &JudgeQuestion) -> anyhow::Result<JudgeAnswer> {
    let input = serde_json::to_vec(question)?;
    let (time_s, memory_mb) = (helper.time.as_secs(), helper.memory_mb);
    let ended = run_helper(helper, input).await?;
    Ok(match ended {
        HelperExit::Said(said) => serde_json::from_slice(&said)?,
        HelperExit::Late => JudgeAnswer::Died(format!("it took longer than {time_s} s")),
        HelperExit::Died(how) => {
            JudgeAnswer::Died(format!("whoever worked on it, with {memory_mb} MB of memory at most, has died: {how}"))
        }
    })
}
