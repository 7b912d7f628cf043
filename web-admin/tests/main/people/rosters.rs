//! The lists of other systems, by their real column names and with people who were invented. Fails when somebody is lost, taken for
//! somebody else or read under another name, when a line about nobody becomes a person, or when the school is asked twice.

use model::Role;
use model::letters::mail::MailKind;
use store::letters::mails::NewMail;
use store::people::directory;
use store::people::directory::Filter;

use crate::people::{confirm, import, link_in, mails, post, school, send};
use crate::support::client::{Answer, Client};

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
        ("canvas-gradebook.csv", Some("gradebook points"), "Group A, Year 4"),
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
    assert!(
        shown.contains("No column was recognised as the email address") && shown.contains("Konto (ana)"),
        "{shown}"
    );
    let refused = post(&mut head, &columns, &columns, &[("name", "1"), ("email", "1")]).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("used for two fields"), "{}", refused.text());
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

/// Sends a file and shows what it would change; or why it is refused.
async fn look_at(head: &mut Client, file: &[u8], fields: &[(&str, &str)]) -> (String, String) {
    let sent = send(head, file, fields).await;
    if sent.status == 422 {
        return (String::new(), sent.text());
    }
    let address = sent.header("location").to_owned();
    let shown = head.get(&address).await.text();
    (address, shown)
}

fn shipped(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rosters").join(name)).unwrap()
}

#[tokio::test]
async fn a_workbook_is_read_as_it_is_shown() {
    let (_app, _, mut head) = school().await;
    for (name, says, never) in [
        ("hidden.xlsx", "vera.visible@uni.example", "old.person@uni.example"),
        ("zeros.xlsx", "registrar’s number is 0012345", "number is 12345"),
        ("date.xlsx", "joins Oct-26", "46296"),
        ("formula.xlsx", "the formula under “E-Mail” has no result", "the email address is missing"),
    ] {
        let (_, shown) = look_at(&mut head, &shipped(name), &[]).await;
        assert!(shown.contains(says) && !shown.contains(never), "{name}: {shown}");
    }
}

#[tokio::test]
async fn a_file_that_is_no_list_is_refused_with_what_to_do() {
    let (_app, _, mut head) = school().await;
    let quote = "email,name,cohort\nq1@uni.example,Quentin,Q\nq3@uni.example,\"Quiz,Q\nq4@uni.example,Quax,Q\n";
    let sealed = [
        &[0xD0, 0xCF, 0x11, 0xE0][..],
        &"EncryptedPackage".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>(),
    ]
    .concat();
    for (file, says) in [(quote.as_bytes(), "line 3: a quotation mark"), (&sealed, "a password protects the workbook")]
    {
        let (address, shown) = look_at(&mut head, file, &[]).await;
        assert!(address.is_empty() && shown.contains(says), "{says}: {shown}");
    }
}

#[tokio::test]
async fn cohorts_and_people_that_look_alike_are_one() {
    let (app, school, mut head) = school().await;
    let first = "email,name,user_id,cohort\nr1@uni.example,Rita One,R1,Year 4\nr2@uni.example,Rolf Two,R2,Year 4\n";
    import(&mut head, first, &[]).await;
    let second = "email,name,user_id,cohort\nR1@uni.example,Rita\u{a0} One,r1,year  4\nr2@uni,Rolf Two,,YEAR 4\n";
    let (address, shown) = look_at(&mut head, second.as_bytes(), &[("remove_missing", "yes")]).await;
    assert!(shown.contains("Nothing to import") && !shown.contains("leaves"), "{shown}");
    let third = "email,name,user_id,cohort\nr3@uni.example,Rosa Three,R3,YEAR 4\nr3@uni.example,Rosa Three,R3,Year 5\n";
    let (added, shown) = look_at(&mut head, third.as_bytes(), &[]).await;
    assert_ne!(added, address);
    assert!(shown.contains("joins Year 4") && shown.contains("joins Year 5"), "{shown}");
    assert_eq!(confirm(&mut head, &added, &shown).await.header("location"), "/people?added=1&changed=0");
    let cohorts = store::training::cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap();
    assert_eq!(cohorts.iter().map(|cohort| cohort.name.as_str()).collect::<Vec<_>>(), ["Year 4", "Year 5"]);
}

#[tokio::test]
async fn somebody_signs_in_by_either_spelling_of_their_domain() {
    let (app, _, mut head) = school().await;
    import(&mut head, "email,name\nana@münchen.example,Ana Idn\n", &[]).await;
    let mails = mails(&app).await;
    assert!(mails.iter().any(|mail| mail.contains("ana@xn--mnchen-3ya.example")), "any server takes it: {mails:?}");
    let link = link_in(&mails[0]);
    let fields = [("password", "a fine password"), ("again", "a fine password")];
    post(&mut app.stranger(), &link, &link, &fields).await;
    for spelling in [
        "ana@münchen.example",
        "ana@xn--mnchen-3ya.example",
        "ANA@XN--MNCHEN-3YA.example",
        "ana@mu\u{308}nchen.example",
    ] {
        assert_eq!(app.stranger().sign_in(spelling, "a fine password").await.status, 303, "{spelling}");
    }
    assert_eq!(app.stranger().sign_in("ana@munchen.example", "a fine password").await.status, 401);
    let (_, again) = look_at(&mut head, "email,name\nana@xn--mnchen-3ya.example,Ana Idn\n".as_bytes(), &[]).await;
    assert!(again.contains("Nothing to import"), "{again}");
}

#[tokio::test]
async fn undelivered_letter_is_a_service_failure_until_one_is_sent() {
    let (app, _, mut head) = school().await;
    import(&mut head, "email,name\nana@uni.example,Ana Ek\nbo@uni.example,Bo Berg\n", &[]).await;
    assert!(head.get("/admin/service").await.text().contains("No failures"));
    let now = app.state.clock.now();
    let due = store::letters::mails::list_due_mails(app.state.db.reader(), now, 10).await.unwrap();
    let ana = due.iter().find(|mail| mail.email == "ana@uni.example").unwrap();
    let refuse = async |tx: &mut store::Connection| {
        assert!(store::letters::mails::claim_mail(tx, ana.id).await.unwrap());
        store::letters::mails::mark_mail_failed(tx, ana.id, "550 no such mailbox", None).await.unwrap();
    };
    app.write(refuse).await;
    let shown = head.get("/admin/service").await.text();
    assert!(!shown.contains("No failures") && shown.contains("1 email could not be sent"), "{shown}");
    assert!(shown.contains("Ana Ek</a>: 550 no such mailbox") && !shown.contains("Bo Berg"), "{shown}");
    app.state.clock.advance(60);
    let (school_id, person_id, now) = (ana.school_id, ana.person_id, app.state.clock.now());
    let again = NewMail { school_id, person_id, kind: MailKind::Invitation, assignment_id: None };
    app.write(async |tx| store::letters::mails::queue_mail(tx, again, now).await.unwrap()).await;
    mails(&app).await;
    assert!(head.get("/admin/service").await.text().contains("No failures"), "another letter went out");
}
