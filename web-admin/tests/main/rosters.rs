//! The lists of other systems, by their real column names and with people who were invented. Fails when somebody is lost, taken for
//! somebody else or read under another name, when a line about nobody becomes a person, or when the school is asked twice.

use model::Role;
use store::directory;
use store::directory::Filter;

use super::people::{confirm, post, school, send};
use super::support::client::{Answer, Client};

/// Sends a file of the real column names of another system.
async fn import_shipped(head: &mut Client, name: &str) -> (String, Answer) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rosters");
    let sent = send(head, &std::fs::read(folder.join(name)).unwrap(), &[]).await;
    let address = sent.header("location").to_owned();
    let shown = head.get(&address).await;
    assert_eq!((sent.status.as_u16(), shown.status.as_u16()), (303, 200), "{name}: {}", shown.text());
    let done = confirm(head, &address, &shown.text()).await;
    (shown.text(), done)
}

#[tokio::test]
async fn the_lists_of_other_systems_are_read_as_they_come() {
    for (name, left_out, groups) in [
        ("moodle.csv", None, "Group 1, Group 2"),
        ("moodle-german.csv", None, "Gruppe 1"),
        ("canvas-gradebook.csv", Some("the points of a gradebook"), "Group A, Year 4"),
        ("canvas-sis.csv", Some("is deleted or inactive in the file"), "–"),
        ("studip.csv", None, "–"),
        ("hisinone.csv", None, "–"),
        ("oneroster-1.1.csv", Some("the role “guardian”"), "–"),
        ("oneroster-1.2.csv", Some("is deleted or inactive in the file"), "–"),
        ("excel.xlsx", None, "–"),
    ] {
        let (app, school, mut head) = school().await;
        let (shown, done) = import_shipped(&mut head, name).await;
        assert_eq!(done.header("location"), "/people?added=2&changed=0", "{name}: {shown}");
        if let Some(why) = left_out {
            assert!(shown.contains(why), "{name}: {shown}");
        }
        let people = directory::list_people(app.state.db.reader(), school, &Filter::default(), 10).await.unwrap();
        let told = |email: &str| {
            let person = people.iter().find(|person| person.email == email).unwrap();
            (person.name.clone(), person.registrar_id.clone().unwrap_or_default(), person.role, person.cohorts.clone())
        };
        let (ana, number, role, cohorts) = told("ana@uni.example");
        let wanted = if name == "excel.xlsx" { "0012345" } else { "4711" };
        assert_eq!((ana.as_str(), number.as_str(), role), ("Ana Lindqvist", wanted, Role::Trainee), "{name}");
        let mut sorted: Vec<&str> = cohorts.split(", ").filter(|cohort| !cohort.is_empty()).collect();
        sorted.sort_unstable();
        assert_eq!(if sorted.is_empty() { "–".to_owned() } else { sorted.join(", ") }, groups, "{name}");
        let teaches = ["canvas-sis.csv", "studip.csv", "oneroster-1.1.csv"].contains(&name);
        let bo = told("bo@uni.example");
        assert_eq!(bo.0, "Bo Größer", "{name}");
        assert_eq!(bo.2, if teaches { Role::Instructor } else { Role::Trainee }, "{name}");
    }
}

#[tokio::test]
async fn columns_that_are_not_recognised_are_said_once_for_the_school() {
    let (_app, _, mut head) = school().await;
    let file = "Kürzel;Wer;Konto;Kohorten\n4711;Ek, Ana;ana;\"A, B\"\n4712;Berg, Bo;bo@localhost;A\n";
    let sent = send(&mut head, file.as_bytes(), &[]).await;
    let address = sent.header("location").to_owned();
    let columns = format!("{address}/columns");
    assert_eq!(head.get(&address).await.header("location"), columns);
    let shown = head.get(&columns).await.text();
    assert!(shown.contains("No column is recognised as the email address") && shown.contains("Konto (ana)"), "{shown}");
    let refused = post(&mut head, &columns, &columns, &[("name", "1"), ("email", "1")]).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("chosen for two things"), "{}", refused.text());
    let chosen = [
        ("name", "1"),
        ("email", "2"),
        ("registrar_id", "0"),
        ("cohort", "3"),
        ("split", "comma"),
        ("domain", "uni.example"),
    ];
    let look = post(&mut head, &columns, &columns, &[&chosen[..], &[("look", "yes")]].concat()).await.text();
    assert!(look.contains("Ana Ek") && look.contains("ana@uni.example") && look.contains("A · B"), "{look}");
    assert_eq!(post(&mut head, &columns, &columns, &chosen).await.header("location"), address);
    let shown = head.get(&address).await.text();
    assert!(
        shown.contains("Kürzel → registrar’s number") && shown.contains("the address “bo@localhost” has no domain")
    );
    assert_eq!(confirm(&mut head, &address, &shown).await.header("location"), "/people?added=1&changed=0");
    let again = send(&mut head, "Kürzel;Wer;Konto;Kohorten\n9;Cy Old;cy;A\n".as_bytes(), &[]).await;
    let shown = head.get(again.header("location")).await.text();
    assert!(shown.contains("cy@uni.example") && shown.contains("joins A"), "remembered: {shown}");
}
