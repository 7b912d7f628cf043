//! The service through its front door: the router in process, a real database file per test, one client per role.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

/// Ends a test here where the tests are run on the other engine: it is about this one alone, for this reason.
macro_rules! only_on {
    ($engine:ident, $why:literal) => {
        if crate::support::database::engine() != store::EngineKind::$engine {
            return;
        }
    };
}

mod access;
mod anchors;
mod answer_times;
mod api;
mod assignments;
mod audit;
mod audit_page;
mod belonging;
#[cfg(feature = "replicas")]
mod buckets;
mod bulk;
mod certificates;
mod cohorts;
mod commands;
mod crash;
mod crowd;
mod deeds;
mod described;
mod documents;
mod doors;
mod draft_forms;
mod draft_instruments;
mod drafts;
mod dumps;
mod earlier_school;
mod engines;
mod erasing;
mod erasures;
mod every_route;
mod experts;
mod fairness;
mod fatal;
mod faults;
mod initial_passwords;
mod killpoints;
mod logos;
mod moving;
mod nonsense;
mod notices;
mod oblique;
mod operation;
mod other_programs;
mod own_data;
mod pages;
mod passkeys;
mod people;
mod pictures;
mod plans;
mod previews;
mod progress;
mod proof;
mod ratings;
mod refusals;
mod regrading;
mod replaced;
mod replay;
mod replicas;
mod retention;
mod review;
mod room;
mod rosters;
mod scanning;
mod schema;
mod scoring;
mod second_factors;
mod segments;
mod settings;
mod signing_in;
mod station_surveys;
mod stations;
mod studies;
mod study_keeping;
mod support;
mod survey_exports;
mod survey_letters;
mod surveys;
#[cfg(feature = "replicas")]
mod telemetry;
mod tokens;
mod tus;
mod uploads;
mod waiting;
mod words;
