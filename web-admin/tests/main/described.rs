//! Every route of the API is described, and nothing else is. Fails when a route is added past `routes!`, which serves and
//! describes an endpoint at once, or when a part of the API is served and left out of the description.

use std::collections::BTreeSet;
use std::process::Command;

use serde_json::Value;
use web_admin::routes;

use crate::support::App;

/// What has no description: the description itself.
const UNDESCRIBED: &str = "/openapi.json";

/// The API's paths, as the router lists them.
fn api(paths: Vec<String>) -> BTreeSet<String> {
    let below = paths.iter().filter_map(|path| path.strip_prefix("/api/v1"));
    below.filter(|path| *path != UNDESCRIBED).map(str::to_owned).collect()
}

#[tokio::test]
async fn every_route_is_described_and_the_command_prints_the_same() {
    let app = App::new().await;
    let served = app.stranger().get("/api/v1/openapi.json").await.json();
    let described: BTreeSet<String> = served["paths"].as_object().unwrap().keys().cloned().collect();
    assert_eq!(described, api(routes::all_routes(&app.state).paths()));
    let output = Command::new(env!("CARGO_BIN_EXE_web-admin")).arg("openapi").output().unwrap();
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, served);
}
