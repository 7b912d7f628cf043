//! Tests of the assessment through its front door.
#![expect(clippy::expect_used, clippy::panic, reason = "a test says what it expects by failing")]

mod closed_form;
mod coach;
mod field;
mod hostile;
mod known_groups;
mod learning;
mod questionnaire;
mod scoring;
mod shaft;
mod signed;
mod simulated;
mod statistics;
mod support;
mod versions;
mod void;
mod worth;
