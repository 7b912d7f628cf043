//! Pages about training: courses, exercises, cohorts, assignments, progress, and the documents that teachers write.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

#[macro_use(tr, trn)]
extern crate words;

use routes_base::Routes;

mod authoring;
mod home;
mod progress;
mod training;

/// Pages for a person who is signed in.
#[must_use]
pub fn training_routes() -> Routes {
    home::home_routes()
        .merge(training::course_routes())
        .merge(progress::progress_routes())
        .merge(authoring::draft_routes())
}
