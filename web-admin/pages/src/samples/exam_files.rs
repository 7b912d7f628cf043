//! Exam files of an attempt, one of them erased.

use model::ids::{ExamFileId, SessionId};

use super::NOW;
use crate::scoring::exam_files::{ExamFileRow, ExamFiles};

pub(crate) fn exam_files() -> ExamFiles {
    let file = |number: u128, is_erased| ExamFileRow {
        id: ExamFileId::from_u128(number),
        by: "Dr Osei".to_owned(),
        at: NOW,
        bytes: 1_410_048,
        sha256: format!("{number:0>64}"),
        is_erased,
    };
    ExamFiles { session: SessionId::from_u128(400), is_scored: true, files: vec![file(1, true), file(2, false)] }
}
