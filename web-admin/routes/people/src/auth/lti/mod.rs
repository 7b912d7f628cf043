//! Launches from learning platforms (LTI 1.3).

use routes_base::{Routes, get, post};

mod choosing;
mod courses;
mod deliveries;
mod launching;
mod platforms;
mod registering;

/// Returns the routes for anonymous visitors.
pub(super) fn public_routes() -> Routes {
    Routes::new()
        .route("/lti/login", get(launching::begin_by_link).merge(post(launching::begin_by_form)))
        .route("/lti/launch", post(launching::finish_launch))
        .route("/lti/register", get(registering::show_registration))
}

/// Returns the routes for signed-in people.
pub(super) fn own_routes() -> Routes {
    Routes::new()
        .route("/lti/deep-link/{id}", get(choosing::show_content).merge(post(choosing::choose_content)))
        .route("/admin/platforms", get(platforms::show_platforms).merge(post(platforms::add_platform)))
        .route("/admin/platforms/register", post(registering::register_platform))
        .route("/admin/platforms/{id}", get(platforms::show_platform).merge(post(platforms::change_platform)))
        .route("/admin/platforms/{id}/admit", post(platforms::admit_deployment))
        .route("/admin/platforms/{id}/courses/{course}", post(courses::change_course))
        .route("/admin/platforms/{id}/deliveries", get(deliveries::show_deliveries))
        .route("/admin/platforms/{id}/deliveries/{delivery}/retry", post(deliveries::retry_delivery))
        .route("/admin/platforms/{id}/disable", post(platforms::disable_platform))
        .route("/admin/platforms/{id}/enable", post(platforms::enable_platform))
}
