//! Pages about attempts: their scores, replays, grades and reviews, ratings, marked pops.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr)]
extern crate words;

use routes_base::Routes;

mod recordings;
mod scoring;

pub use recordings::linked_routes;

/// Returns the pages for signed-in people.
#[must_use]
pub fn scoring_routes() -> Routes {
    recordings::attempt_routes().merge(scoring::grading_routes())
}
