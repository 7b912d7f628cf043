//! Members of a course, as a learning platform lists them (LTI Names and Role Provisioning Services
//! 2.0).

use serde::Deserialize;
use serde_json::{Map, Value};
use url::Url;

use super::federation::{Claims, ProvenIdentity};
use super::lti::{LTI, NumberClaim, members_of, valid_id};
use crate::people::roster::CourseMember;

/// Media type of a page of members.
pub const MEMBERS_TYPE: &str = "application/vnd.ims.lti-nrps.v2.membershipcontainer+json";
/// Scope of an access token that reads members.
pub const MEMBERS_SCOPE: &str = "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly";
/// Prefix of the roles in a course, before `#` or `/`.
const MEMBERSHIP: &str = "http://purl.imsglobal.org/vocab/lis/v2/membership";
/// Role of those who learn.
const LEARNER: &str = "Learner";
/// Roles in a course of those who do more than learn.
const STAFF: [&str; 6] = ["Administrator", "ContentDeveloper", "Instructor", "Manager", "Officer", "TeachingAssistant"];

#[derive(Deserialize)]
struct MembersPage {
    #[serde(default)]
    members: Vec<Map<String, Value>>,
}

/// Reads a page of members; those who have left the course are left out.
///
/// # Errors
/// Returns the reason, in English.
pub fn read_members(body: &[u8], claim: Option<NumberClaim>) -> Result<Vec<CourseMember>, String> {
    let page: MembersPage = serde_json::from_slice(body).map_err(|error| error.to_string())?;
    let members = page.members.into_iter().map(Claims).filter(is_present);
    members.map(|member| read_member(&member, claim)).collect()
}

/// The status is optional; a member who is inactive or deleted has left.
fn is_present(member: &Claims) -> bool {
    member.text("status").is_none_or(|status| status == "Active")
}

fn read_member(member: &Claims, claim: Option<NumberClaim>) -> Result<CourseMember, String> {
    let subject = member.exact("user_id").and_then(valid_id).ok_or("a member without user_id")?;
    let number = match claim {
        Some(NumberClaim::PersonSourcedId) => member.text("lis_person_sourcedid"),
        Some(NumberClaim::StudentNumber) => find_custom(member).text("student_number"),
        None => None,
    };
    let described = ProvenIdentity::describe(member, subject);
    let has_name = ["name", "given_name", "family_name"].iter().any(|name| member.text(name).is_some());
    let roles = member.list("roles");
    let has_role = |word: &str| roles.iter().any(|role| is_role(role, word));
    Ok(CourseMember {
        name: Some(described.name).filter(|name| has_name && !name.is_empty()),
        subject: described.subject,
        email: described.email,
        number: number.filter(|number| NumberClaim::is_number(number)),
        is_learner: has_role(LEARNER) && !STAFF.iter().any(|staff| has_role(staff)),
    })
}

/// Returns the custom parameters in the messages of a member.
fn find_custom(member: &Claims) -> Claims {
    let messages = member.0.get("message").and_then(Value::as_array).into_iter().flatten();
    let messages = messages.filter_map(Value::as_object).cloned().map(Claims);
    let mut custom = messages.map(|message| members_of(&message, &format!("{LTI}custom")));
    Claims(custom.find(|custom| !custom.is_empty()).unwrap_or_default())
}

/// Returns whether a role in a course is a word, or a kind of it: `Learner`, `membership#Learner`,
/// `membership/Instructor#TeachingAssistant`.
fn is_role(role: &str, word: &str) -> bool {
    let own = role.strip_prefix(MEMBERSHIP).map(|rest| rest.trim_start_matches(['#', '/'])).unwrap_or(role);
    own.split('#').any(|part| part == word)
}

/// Returns the next page that the header `Link` names (RFC 8288), if it has the origin of the current
/// one: the access token is for no other.
///
/// # Errors
/// Returns the reason, in English.
pub fn find_next_page(link: &str, current: &Url) -> Result<Option<Url>, String> {
    for part in link.split('<').skip(1) {
        let Some((target, parameters)) = part.split_once('>') else { continue };
        let mut parameters = parameters.split([';', ',']).map(str::trim);
        let is_next = parameters.any(|parameter| {
            let value = parameter.strip_prefix("rel=").map(|value| value.trim_matches('"'));
            value.is_some_and(|value| value.split(' ').any(|rel| rel.eq_ignore_ascii_case("next")))
        });
        if is_next {
            let next = current.join(target).map_err(|error| error.to_string())?;
            if next.origin() != current.origin() {
                return Err("the next page is on another host".to_owned());
            }
            return Ok(Some(next));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_member_is_read_with_number_and_role() {
        let role = |role: &str| json!([format!("{MEMBERSHIP}{role}")]);
        let page = json!({ "id": "https://lms", "context": { "id": "5" }, "members": [
            { "user_id": "1", "name": "Ada", "email": "ADA@example.edu", "lis_person_sourcedid": "4711", "roles": role("#Learner") },
            { "user_id": 2, "roles": ["Learner", "Instructor"], "status": "Active" },
            { "user_id": "3", "roles": role("/Instructor#TeachingAssistant") },
            { "user_id": "4", "roles": role("#Learner"), "status": "Inactive" },
            { "user_id": "5", "roles": role("#Learner"), "lis_person_sourcedid": "$Person.sourcedId",
              "message": [{ format!("{LTI}custom"): { "student_number": "9" } }] },
        ]});
        let read = |claim| read_members(page.to_string().as_bytes(), claim).unwrap();
        let members = read(Some(NumberClaim::PersonSourcedId));
        let ids: Vec<_> = members.iter().map(|member| (member.subject.as_str(), member.is_learner)).collect();
        assert_eq!(ids, [("1", true), ("2", false), ("3", false), ("5", true)]);
        assert_eq!(
            (members[0].number.as_deref(), members[0].email.as_deref()),
            (Some("4711"), Some("ada@example.edu"))
        );
        assert_eq!((&members[0].name, &members[1].name), (&Some("Ada".to_owned()), &None));
        assert_eq!(members[3].number, None, "an unknown variable");
        assert_eq!(read(Some(NumberClaim::StudentNumber))[3].number.as_deref(), Some("9"));
        assert!(read_members(br#"{"members":[{"name":"x"}]}"#, None).is_err());
    }

    #[test]
    fn the_next_page_is_on_the_same_host() {
        let current = Url::parse("https://lms.example.edu/members?p=1").unwrap();
        let next = |link: &str| find_next_page(link, &current).map(|next| next.map(String::from));
        let second = "https://lms.example.edu/members?p=2&a=1,2";
        for link in [
            format!("<{second}>; rel=\"next\""),
            format!("<https://lms.example.edu/d>; rel=\"differences\", <{second}>;rel=next"),
            "</members?p=2&a=1,2>; rel=\"last next\"".to_owned(),
        ] {
            assert_eq!(next(&link), Ok(Some(second.to_owned())), "{link}");
        }
        assert_eq!(next("<https://lms.example.edu/d>; rel=\"differences\""), Ok(None));
        assert_eq!(next("nonsense"), Ok(None));
        assert!(next("<https://evil.example/members>; rel=next").is_err());
        assert!(next("<http://lms.example.edu/members>; rel=next").is_err());
    }
}
