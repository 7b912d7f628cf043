//! Pages about training: courses, exercises, cohorts, assignments, progress, and the documents that
//! teachers write.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr, trn)]
extern crate words;

use routes_base::Routes;

mod authoring;
pub(crate) mod operations;
mod training;

/// Returns the pages for signed-in people.
#[must_use]
pub fn training_routes() -> Routes {
    operations::home_routes().merge(training::course_routes()).merge(authoring::draft_routes())
}

/// Returns the route of calendars, which have no session.
#[must_use]
pub fn calendar_routes() -> Routes {
    training::calendar_feed::calendar_routes()
}
