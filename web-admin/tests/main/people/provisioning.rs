//! Provisioning by a directory (SCIM 2.0). Fails when a directory reaches another school, disables staff or the last administrator, erases
//! somebody, changes a resource that has changed meanwhile, or leaves no row in the audit log.

use axum::body::Body;
use axum::http::{Method, Request, header};
use model::Role;
use model::ids::SchoolId;
use model::people::directory::AccountState;
use serde_json::{Value, json};
use store::people::directory;

use super::school;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::{App, PASSWORD};

const ADMIN: &str = "/admin/provisioning";

/// A directory with a token.
struct Directory(Client);

impl Directory {
    /// Makes a token in the administrator's browser.
    async fn new(app: &App, head: &mut Client, staff: bool) -> Self {
        let csrf = csrf_in(&head.get(ADMIN).await.text());
        let mut fields = vec![("csrf", csrf.as_str()), ("name", "Entra"), ("password", PASSWORD)];
        if staff {
            fields.push(("may_disable_staff", "yes"));
        }
        let made = head.form(ADMIN, &fields).await;
        let page = made.text();
        let token = page.split("class=\"link-to-copy\">").nth(1).unwrap_or_else(|| panic!("no token: {page}"));
        let mut client = app.stranger();
        client.token = Some(token.split('<').next().unwrap().to_owned());
        Self(client)
    }

    async fn send(&mut self, method: Method, path: &str, body: &Value) -> Answer {
        self.send_if(method, path, body, "*").await
    }

    async fn send_if(&mut self, method: Method, path: &str, body: &Value, version: &str) -> Answer {
        let request = Request::builder().method(method).uri(format!("/scim/v2{path}"));
        let request = request.header(header::CONTENT_TYPE, "application/scim+json").header(header::IF_MATCH, version);
        self.0.send(request.body(Body::from(body.to_string())).unwrap()).await
    }

    async fn get(&mut self, path: &str) -> Answer {
        self.send(Method::GET, path, &Value::Null).await
    }

    /// Creates a user; returns the path.
    async fn create(&mut self, body: &Value) -> String {
        let made = self.send(Method::POST, "/Users", body).await;
        assert_eq!(made.status, 201, "{}", made.text());
        format!("/Users/{}", made.json()["id"].as_str().unwrap())
    }

    async fn patch(&mut self, path: &str, operations: Value) -> Answer {
        self.send(Method::PATCH, path, &json!({ "Operations": operations })).await
    }

    /// Ids of the users that a filter finds.
    async fn find(&mut self, filter: &str) -> Vec<String> {
        let found = self.get(&format!("/Users?filter={}", filter.replace(' ', "%20").replace('"', "%22"))).await;
        assert_eq!(found.status, 200, "{}", found.text());
        let found = found.json();
        let id = |one: &Value| one["id"].as_str().unwrap().to_owned();
        found["Resources"].as_array().unwrap().iter().map(id).collect()
    }
}

fn ada() -> Value {
    json!({
        "schemas": ["urn:ietf:params:scim:schemas:core:2.0:User"],
        "userName": "ada@uni.example",
        "externalId": "4711",
        "name": { "givenName": "Ada", "familyName": "Lovelace" },
        "emails": [{ "value": "Ada@uni.example", "type": "work", "primary": true }],
        "active": true,
    })
}

async fn state_of(app: &App, school: SchoolId, path: &str) -> AccountState {
    let id = path.rsplit('/').next().unwrap().parse().unwrap();
    directory::find_directory_entry(app.state.db.reader(), school, id).await.unwrap().unwrap().state
}

#[tokio::test]
async fn a_directory_creates_changes_and_disables_a_trainee() {
    let (app, school, mut head) = school().await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    let path = entra.create(&ada()).await;
    let id = path.rsplit('/').next().unwrap().to_owned();
    let read = entra.get(&path).await.json();
    assert_eq!((&read["displayName"], &read["externalId"]), (&json!("Ada Lovelace"), &json!("4711")));
    for filter in ["userName eq \"ADA@UNI.example\"", "externalId eq \"4711\"", "displayName eq \"ada lovelace\""] {
        assert_eq!(entra.find(filter).await, std::slice::from_ref(&id), "{filter}");
    }
    assert_eq!(entra.find("userName eq \"nobody\"").await, Vec::<String>::new());
    let search = json!({ "filter": "externalId eq \"4711\"", "attributes": ["userName"] });
    let searched = entra.send(Method::POST, "/Users/.search", &search).await.json();
    assert_eq!(
        (&searched["totalResults"], &searched["Resources"][0]["userName"]),
        (&json!(1), &json!("ada@uni.example"))
    );
    assert!(searched["Resources"][0].get("externalId").is_none(), "{searched}");
    assert_eq!(entra.send(Method::POST, "/Users", &ada()).await.status, 409, "once");
    let renamed = entra.patch(&path, json!([{ "op": "replace", "path": "name.familyName", "value": "King" }])).await;
    assert_eq!(renamed.json()["displayName"], "King", "{}", renamed.text());
    let off = entra.patch(&path, json!([{ "op": "Replace", "path": "active", "value": "False" }])).await;
    assert_eq!(off.json()["active"], false);
    assert_eq!(state_of(&app, school, &path).await, AccountState::Disabled);
    entra.patch(&path, json!([{ "op": "replace", "value": { "active": true } }])).await;
    assert_ne!(state_of(&app, school, &path).await, AccountState::Disabled);
    let query = "SELECT action FROM audit_log WHERE actor = 'directory' ORDER BY seq";
    let rows: Vec<String> = sqlx::query_scalar(query).fetch_all(app.state.db.reader()).await.unwrap();
    assert_eq!(rows, ["person.added", "person.changed", "person.changed", "person.disabled", "person.enabled"]);
}

#[tokio::test]
async fn a_deleted_user_is_disabled_and_can_come_back() {
    let (app, school, mut head) = school().await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    let path = entra.create(&ada()).await;
    assert_eq!(entra.send(Method::DELETE, &path, &Value::Null).await.status, 204);
    assert_eq!(entra.get(&path).await.status, 404);
    assert_eq!(entra.find("userName eq \"ada@uni.example\"").await, Vec::<String>::new());
    assert_eq!(state_of(&app, school, &path).await, AccountState::Disabled, "nobody is erased");
    assert_eq!(entra.create(&ada()).await, path, "the same person again");
    assert_ne!(state_of(&app, school, &path).await, AccountState::Disabled);
}

#[tokio::test]
async fn staff_are_safe_and_the_last_administrator_stays() {
    let (app, school, mut head) = school().await;
    app.member(school, Role::Instructor, "teacher@uni.example").await;
    let mut plain = Directory::new(&app, &mut head, false).await;
    let mut strong = Directory::new(&app, &mut head, true).await;
    let off = json!([{ "op": "replace", "path": "active", "value": false }]);
    let teacher = format!("/Users/{}", plain.find("userName eq \"teacher@uni.example\"").await[0]);
    assert_eq!(plain.patch(&teacher, off.clone()).await.status, 403);
    assert_eq!(plain.send(Method::DELETE, &teacher, &Value::Null).await.status, 403);
    assert_eq!(strong.patch(&teacher, off.clone()).await.status, 200);
    let query = "SELECT id FROM people WHERE role = 'administrator' AND school_id = $1";
    let heads: Vec<model::ids::PersonId> =
        sqlx::query_scalar(query).bind(school).fetch_all(app.state.db.reader()).await.unwrap();
    for (left, head) in (0..heads.len()).rev().zip(&heads) {
        let status = strong.patch(&format!("/Users/{head}"), off.clone()).await.status;
        assert_eq!(status == 403, left == 0, "{left} are left: {status}");
    }
}

#[tokio::test]
async fn a_token_opens_one_school_and_nothing_else() {
    let (app, _, mut head) = school().await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    let south = app.school("South").await;
    let abroad = app.member(south, Role::Trainee, "abroad@uni.example").await;
    let path = format!("/Users/{}", abroad.person.id);
    assert_eq!(entra.find("userName eq \"abroad@uni.example\"").await, Vec::<String>::new());
    for method in [Method::GET, Method::DELETE] {
        assert_eq!(entra.send(method, &path, &Value::Null).await.status, 404);
    }
    assert_eq!(entra.send(Method::PUT, &path, &ada()).await.status, 404);
    assert_eq!(entra.0.get("/api/v1/sessions").await.status, 401, "no token of the API");
    let mut namesake = ada();
    namesake["emails"][0]["value"] = "abroad@uni.example".into();
    assert_eq!(entra.send(Method::POST, "/Users", &namesake).await.status, 201, "an address of another school is free");
    let mut person = app.with_token(&abroad.token);
    assert_eq!(person.get("/scim/v2/Users").await.status, 401, "no token of a directory");
    let page = head.get(ADMIN).await.text();
    let revoke = page.split("action=\"/admin/provisioning/").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let revoked = head.form(&format!("{ADMIN}/{revoke}"), &[("csrf", &csrf_in(&page))]).await;
    assert_eq!(revoked.status, 303);
    assert_eq!(entra.get("/Users").await.status, 401);
}

#[tokio::test]
async fn a_changed_resource_is_not_overwritten() {
    let (app, _, mut head) = school().await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    let path = entra.create(&ada()).await;
    let read = entra.get(&path).await;
    let version = read.header("etag").to_owned();
    assert_eq!(read.json()["meta"]["version"], json!(version));
    let renamed = json!({ "userName": "ada@uni.example", "displayName": "A" });
    assert_eq!(entra.send_if(Method::PUT, &path, &renamed, &version).await.status, 200);
    assert_eq!(entra.send_if(Method::PUT, &path, &renamed, &version).await.status, 412);
    assert_eq!(entra.send_if(Method::DELETE, &path, &Value::Null, &version).await.status, 412);
}

#[tokio::test]
async fn a_group_is_a_cohort_of_trainees() {
    let (app, school, mut head) = school().await;
    app.member(school, Role::Instructor, "teacher@uni.example").await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    let path = entra.create(&ada()).await;
    let ada = path.rsplit('/').next().unwrap().to_owned();
    let teacher = entra.find("userName eq \"teacher@uni.example\"").await.remove(0);
    let members = json!([{ "value": ada }, { "value": teacher }]);
    let made = entra.send(Method::POST, "/Groups", &json!({ "displayName": "Spring", "members": members })).await;
    assert_eq!(made.status, 201, "{}", made.text());
    let made = made.json();
    let group = format!("/Groups/{}", made["id"].as_str().unwrap());
    assert_eq!(made["members"].as_array().unwrap().len(), 1, "who teaches is no trainee of it");
    let path = format!("members[value eq \"{ada}\"]");
    let left = entra.patch(&group, json!([{ "op": "remove", "path": path }])).await;
    assert!(left.json().get("members").is_none(), "{}", left.text());
    let unknown = json!([{ "op": "add", "path": "members", "value": [{ "value": uuid::Uuid::nil() }] }]);
    assert_eq!(entra.patch(&group, unknown).await.status, 400);
    assert_eq!(entra.send(Method::POST, "/Groups", &json!({ "displayName": "Spring" })).await.status, 409);
    assert_eq!(entra.send(Method::DELETE, &group, &Value::Null).await.status, 204);
    assert_eq!(entra.get(&group).await.status, 404);
    assert!(head.get("/people").await.text().contains("Spring"), "the cohort itself stays");
}

#[tokio::test]
async fn nonsense_is_refused_in_the_words_of_the_standard() {
    let (app, _, mut head) = school().await;
    let mut entra = Directory::new(&app, &mut head, false).await;
    for (body, kind) in [
        (json!([]), "invalidSyntax"),
        (json!({}), "invalidValue"),
        (json!({ "userName": 7 }), "invalidValue"),
        (json!({ "userName": "a\u{202e}b" }), "invalidValue"),
        (json!({ "userName": "x".repeat(201) }), "invalidValue"),
        (json!({ "userName": "a", "emails": [{ "value": "no address" }] }), "invalidValue"),
        (json!({ "userName": "a", "active": 7 }), "invalidValue"),
    ] {
        let refused = entra.send(Method::POST, "/Users", &body).await;
        let error = refused.json();
        assert_eq!((refused.status.as_u16(), &error["scimType"]), (400, &json!(kind)), "{body}: {error}");
        assert_eq!(refused.header("content-type"), "application/scim+json");
    }
    for path in ["/Users/x", "/Nothing", "/Schemas/x"] {
        let missing = entra.get(path).await;
        assert_eq!((missing.status.as_u16(), &missing.json()["status"]), (404, &json!("404")), "{path}");
    }
    assert_eq!(entra.get("/Users?filter=userName%20co%20%22a%22").await.json()["scimType"], "invalidFilter");
}
