//! Pages about surveys and studies.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

#[macro_use(sentence, tr)]
extern crate words;

use routes_base::Routes;

mod answering;
mod studies;
mod surveys;

pub use answering::survey_link_routes;

/// Pages for a person who is signed in.
#[must_use]
pub fn survey_routes() -> Routes {
    surveys::survey_routes().merge(studies::study_routes())
}
