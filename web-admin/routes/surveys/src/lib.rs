//! Pages about surveys and studies.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(sentence, tr)]
extern crate words;

use routes_base::Routes;

mod studies;
mod surveys;

pub use surveys::answering::survey_link_routes;

/// Returns the pages for signed-in people.
#[must_use]
pub fn survey_routes() -> Routes {
    surveys::survey_routes().merge(studies::study_routes())
}
