//! A patch that a directory sends must do what it means, and nothing must be taken for what it is
//! not.

use serde_json::json;

use super::*;

fn user() -> ScimUser {
    ScimUser {
        id: PersonId::nil(),
        user_name: "ada@example.org".to_owned(),
        display_name: "Ada Lovelace".to_owned(),
        external_id: Some("4711".to_owned()),
        email: "ada@example.org".to_owned(),
        role: Role::Trainee,
        disabled_at: None,
    }
}

const ADDRESS: ScimAddress<'static> = ScimAddress("https://stylet.example.org/scim/v2");

fn patched(operations: Value) -> Result<WantedUser, ScimError> {
    let mut fields = user().to_json(ADDRESS);
    PatchRequest::read(json!({ "Operations": operations }))?.apply(&mut fields)?;
    WantedUser::read(&fields, Some(&user()))
}

#[test]
fn patches_of_entra_and_okta_are_understood() {
    let off = patched(json!([{ "op": "Replace", "path": "active", "value": "False" }])).unwrap();
    assert!(!off.active);
    let off = patched(json!([{ "op": "replace", "value": { "active": false } }])).unwrap();
    assert!(!off.active);
    let work = json!([{ "op": "Add", "path": "emails[type eq \"work\"].value", "value": "New@example.org" }]);
    assert_eq!(patched(work).unwrap().email.as_deref(), Some("new@example.org"));
    let flat = json!([{ "op": "replace", "value": { "name.familyName": "King", "name.givenName": "Ada" } }]);
    assert_eq!(patched(flat).unwrap().display_name, "Ada King");
    let named =
        json!([{ "op": "replace", "path": "urn:ietf:params:scim:schemas:core:2.0:User:displayName", "value": "A" }]);
    assert_eq!(patched(named).unwrap().display_name, "A");
    let gone =
        patched(json!([{ "op": "remove", "path": "emails" }, { "op": "remove", "path": "externalId" }])).unwrap();
    assert_eq!((gone.email, gone.external_id), (None, None));
    let none = patched(json!([{ "op": "remove", "path": "emails[type eq \"work\"]" }])).unwrap();
    assert_eq!(none.email, None);
    let other =
        patched(json!([{ "op": "replace", "path": "emails[type eq \"home\"].value", "value": "h@example.org" }]));
    assert_eq!(other.unwrap().email.as_deref(), Some("ada@example.org"), "the primary one counts");
}

#[test]
fn members_are_added_and_removed_one_by_one() {
    let ids = [1, 2, 3].map(PersonId::from_u128);
    let group =
        ScimGroup { id: CohortId::nil(), name: "A".to_owned(), external_id: None, members: vec![ids[0], ids[1]] };
    let patched = |operations: Value| {
        let mut fields = group.to_json(ADDRESS);
        PatchRequest::read(json!({ "Operations": operations })).unwrap().apply(&mut fields).unwrap();
        WantedGroup::read(&fields).unwrap().members
    };
    let added =
        patched(json!([{ "op": "add", "path": "members", "value": [{ "value": ids[2] }, { "value": ids[0] }] }]));
    assert_eq!(added, [ids[1], ids[2], ids[0]], "nobody twice");
    let path = format!("members[value eq \"{}\"]", ids[0]);
    assert_eq!(patched(json!([{ "op": "remove", "path": path }])), [ids[1]]);
    let listed = patched(json!([{ "op": "Remove", "path": "members", "value": [{ "value": ids[1] }] }]));
    assert_eq!(listed, [ids[0]]);
    assert!(patched(json!([{ "op": "remove", "path": "members" }])).is_empty());
}

#[test]
fn malformed_requests_are_refused_with_their_keyword() {
    let kind = |operations: Value| patched(operations).unwrap_err().kind;
    assert_eq!(kind(json!([{ "op": "move", "path": "active" }])), Some("invalidSyntax"));
    assert_eq!(kind(json!([{ "op": "add", "path": "emails[type", "value": 1 }])), Some("invalidPath"));
    assert_eq!(kind(json!([{ "op": "add", "path": "emails[type co \"w\"]", "value": {} }])), Some("invalidFilter"));
    assert_eq!(kind(json!([{ "op": "add", "path": "active" }])), Some("invalidValue"));
    assert_eq!(kind(json!([{ "op": "replace", "value": 7 }])), Some("noTarget"));
    assert_eq!(kind(json!([{ "op": "replace", "path": "active", "value": "maybe" }])), Some("invalidValue"));
    assert_eq!(kind(json!([{ "op": "remove", "path": "userName" }])), Some("invalidValue"));
    for filter in ["", "userName", "userName eq", "userName co \"a\"", "userName eq \"a\" or id eq \"b\"", "(id eq 1)"]
    {
        assert_eq!(Filter::parse(filter).unwrap_err().kind, Some("invalidFilter"), "{filter}");
    }
}

#[test]
fn filters_compare_as_the_standard_says() {
    let fields = user().to_json(ADDRESS);
    for (filter, holds) in [
        ("userName eq \"ADA@example.org\"", true),
        ("username EQ \"ada@example.org\" and externalId eq \"4711\"", true),
        ("externalId eq \"4711\" and displayName eq \"x\"", false),
        ("emails.value eq \"ada@example.org\"", true),
        ("urn:ietf:params:scim:schemas:core:2.0:User:userName eq \"ada@example.org\"", true),
        ("active eq true", true),
        ("nickName eq \"ada\"", false),
    ] {
        assert_eq!(Filter::parse(filter).unwrap().matches(&fields), holds, "{filter}");
    }
}

#[test]
fn an_answer_contains_what_was_asked_for() {
    let names = |only, without| {
        let fields = Selection::parse(only, without).of(user().to_json(ADDRESS));
        fields.keys().cloned().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names(Some("username"), None), "id schemas userName");
    assert!(!names(None, Some("emails,userName,id")).contains("emails"));
    let part = Selection::parse(Some("emails.value"), None).of(user().to_json(ADDRESS));
    assert_eq!(part["emails"], json!([{ "value": "ada@example.org" }]));
}
