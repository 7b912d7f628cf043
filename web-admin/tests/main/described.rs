//! Every route of the API is described, and nothing else is. Fails when a route is added without its description, or a
//! description outlives its route.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::support::App;

/// What has no description: the description itself.
const UNDESCRIBED: &str = "/openapi.json";

/// The addresses in `.route("…", …)` of every file of the API.
fn routes() -> BTreeSet<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/routes/api");
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let source = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let quoted = source.split(".route(").skip(1).filter_map(|rest| rest.split('"').nth(1));
        found.extend(quoted.map(str::to_owned));
    }
    found.remove(UNDESCRIBED);
    found
}

#[tokio::test]
async fn every_route_is_described_and_the_command_prints_the_same() {
    let served = App::new().await.stranger().get("/api/v1/openapi.json").await.json();
    let described: BTreeSet<String> = served["paths"].as_object().unwrap().keys().cloned().collect();
    assert_eq!(described, routes());
    let output = Command::new(env!("CARGO_BIN_EXE_web-admin")).arg("openapi").output().unwrap();
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, served);
}
