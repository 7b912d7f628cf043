//! Fails when somebody is not found by what another keyboard types, a list is sorted wrongly or leaves somebody out between its pages,
//! or something is done to many people at once that was not shown, or to somebody who should have been left out.

use model::Role;
use model::ids::CohortId;

use crate::people::{post, school};
use crate::support::client::Client;

async fn names_at(client: &mut Client, address: &str) -> Vec<String> {
    let page = client.get(address).await.text();
    let rows = page.split("<tbody>").nth(1).unwrap_or_default().split("</tbody>").next().unwrap_or_default();
    let named = rows.split("scope=\"row\"").skip(1).filter_map(|row| row.split("\">").nth(2)?.split('<').next());
    named.map(str::to_owned).collect()
}

async fn add(head: &mut Client, name: &str, email: &str) -> String {
    let fields = [("name", name), ("email", email), ("role", "trainee"), ("cohort", "")];
    let added = post(head, "/people", "/people", &fields).await;
    assert_eq!(added.status, 303, "{name}: {}", added.text());
    added.header("location").split(['/', '?']).nth(2).unwrap().to_owned()
}

async fn id_of(head: &mut Client, email: &str) -> String {
    let page = head.get(&format!("/people?q={email}")).await.text();
    let boxed = page.split_once("name=\"person\" value=\"").unwrap().1;
    boxed.split('"').next().unwrap().to_owned()
}

#[tokio::test]
async fn search_ignores_accents_and_lists_people_alphabetically() {
    let (app, _, mut head) = school().await;
    for (name, email) in
        [("Jörg Größer", "z@example.org"), ("Zoe Ott", "a@example.org"), ("Åse Sørensen", "m@example.org")]
    {
        add(&mut head, name, email).await;
    }
    let number = "UPDATE people SET registrar_id = '0047', search = search || ' 0047' WHERE email = 'm@example.org'";
    let mut tx = app.state.db.write().await.unwrap();
    sqlx::raw_sql(number).execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    for (typed, found) in [("grosser", "Jörg Größer"), ("groesser+jorg", "Jörg Größer"), ("SORENSEN", "Åse Sørensen")]
    {
        assert_eq!(names_at(&mut head, &format!("/people?q={typed}")).await, [found], "{typed}");
    }
    assert!(names_at(&mut head, "/people?q=grosser+anna").await.is_empty());
    let trainees = "/people?role=trainee";
    assert_eq!(names_at(&mut head, trainees).await, ["Åse Sørensen", "Jörg Größer", "Zoe Ott"]);
    assert_eq!(names_at(&mut head, &format!("{trainees}&down=yes")).await, ["Zoe Ott", "Jörg Größer", "Åse Sørensen"]);
    let by_email = ["Zoe Ott", "Åse Sørensen", "Jörg Größer"];
    assert_eq!(names_at(&mut head, &format!("{trainees}&sort=email")).await, by_email);
}

#[tokio::test]
async fn whoever_was_here_before_is_found_after_the_next_start() {
    let (app, _, mut head) = school().await;
    add(&mut head, "Jörg Größer", "z@example.org").await;
    let mut tx = app.state.db.write().await.unwrap();
    let before = "UPDATE people SET sort_name = '', search = lower(display_name) || ' ' || email, registrar_id = 'M-47' WHERE email LIKE 'z@%'";
    sqlx::raw_sql(before).execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    assert!(names_at(&mut head, "/people?q=grosser").await.is_empty());
    app.state.db.migrate().await.unwrap();
    for typed in ["grosser", "m-47"] {
        assert_eq!(names_at(&mut head, &format!("/people?q={typed}")).await, ["Jörg Größer"], "{typed}");
    }
}

#[tokio::test]
async fn every_order_shows_everybody_once_over_its_pages() {
    let (_app, _, mut head) = school().await;
    let lines: String = (0..120).map(|n| format!("p{:03}@example.org,Person {n:03}\n", (n * 37) % 120)).collect();
    crate::people::import(&mut head, &format!("email,name\n{lines}"), &[]).await;
    for order in
        ["sort=name", "sort=name&down=yes", "sort=email", "sort=email&down=yes", "sort=number", "sort=number&down=yes"]
    {
        let (mut seen, mut address) = (Vec::new(), format!("/people?role=trainee&{order}"));
        for _ in 0..5 {
            seen.extend(names_at(&mut head, &address).await);
            let page = head.get(&address).await.text();
            let Some((before, _)) = page.split_once("\" rel=\"next\"") else { break };
            address = before.rsplit("href=\"").next().unwrap().replace("&#38;", "&");
        }
        let count = seen.len();
        seen.sort();
        seen.dedup();
        assert_eq!((count, seen.len()), (120, 120), "{order}");
    }
}

/// Asks for something below the list, and does what is shown then.
async fn do_to_many(head: &mut Client, fields: &[(&str, &str)]) -> (String, String) {
    let asked = post(head, "/people", "/people/bulk", fields).await;
    assert_eq!(asked.status, 200, "{}", asked.text());
    let shown = asked.text();
    let hidden = shown.split("<input type=\"hidden\" name=\"").skip(1).map(|field| {
        let (name, rest) = field.split_once("\" value=\"").unwrap();
        (name.to_owned(), rest.split('"').next().unwrap().to_owned())
    });
    let sent: Vec<(String, String)> =
        hidden.filter(|(name, _)| ["act", "cohort", "person"].contains(&name.as_str())).collect();
    let sent: Vec<(&str, &str)> = sent.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
    let done = post(head, "/people", "/people/bulk/do", &sent).await;
    assert_eq!(done.status, 303, "{}", done.text());
    let said = head.get(done.header("location")).await.text();
    (shown, said)
}

#[tokio::test]
async fn bulk_actions_change_eligible_people_and_skip_the_others() {
    let (app, school, mut head) = school().await;
    let ana = add(&mut head, "Ana", "ana@example.org").await;
    let bo = add(&mut head, "Bo", "bo@example.org").await;
    let own = id_of(&mut head, "head@example.org").await;
    let active = app.member(school, Role::Trainee, "cy@example.org").await.person.id.to_string();
    let all =
        [("person", ana.as_str()), ("person", bo.as_str()), ("person", own.as_str()), ("person", active.as_str())];
    let with = |act: &'static str, cohort: &'static str| [&all[..], &[("act", act), ("cohort", cohort)]].concat();

    let (shown, said) = do_to_many(&mut head, &with("invite", "")).await;
    assert!(shown.contains("Resend 2 invitations") && shown.contains("has already chosen a password"), "{shown}");
    assert!(said.contains("2 invitations were saved as files"), "{said}");
    let (shown, said) = do_to_many(&mut head, &with("disable", "")).await;
    assert!(
        shown.contains("you cannot disable your own account") && said.contains("3 accounts were disabled"),
        "{shown} {said}"
    );
    assert_eq!(names_at(&mut head, "/people?state=disabled").await.len(), 3);
    let (_, said) = do_to_many(&mut head, &with("enable", "")).await;
    assert!(said.contains("3 accounts were enabled"), "{said}");

    let made = post(&mut head, "/cohorts", "/cohorts", &[("name", "Spring")]).await;
    let cohort: CohortId = made.header("location").split('/').nth(2).unwrap().parse().unwrap();
    let cohort = cohort.to_string();
    let joining = [&all[..], &[("act", "join"), ("cohort", cohort.as_str())]].concat();
    let (shown, said) = do_to_many(&mut head, &joining).await;
    assert!(
        shown.contains("administrators cannot be in a cohort") && said.contains("3 people were added"),
        "{shown} {said}"
    );
    let everybody = [("everybody", "yes"), ("q", "bo@example"), ("act", "leave"), ("cohort", cohort.as_str())];
    let (shown, said) = do_to_many(&mut head, &everybody).await;
    assert!(shown.contains("Remove 1 person from “Spring”") && said.contains("1 person was removed"), "{shown} {said}");
    assert_eq!(names_at(&mut head, &format!("/people?cohort={cohort}")).await, ["Ana", "Somebody"]);
}

#[tokio::test]
async fn what_is_missing_is_said_and_what_was_ticked_stays() {
    let (_app, _, mut head) = school().await;
    let ana = add(&mut head, "Ana", "ana@example.org").await;
    let refused = [
        (vec![("act", "disable")], "Nobody is selected"),
        (vec![("person", ana.as_str())], "Choose an action"),
        (vec![("person", ana.as_str()), ("act", "join")], "Choose a cohort"),
    ];
    for (fields, why) in refused {
        let answer = post(&mut head, "/people", "/people/bulk", &fields).await;
        assert!(answer.status == 422 && answer.text().contains(why), "{why}: {}", answer.text());
        let ticked = format!("value=\"{ana}\" aria-label=\"Ana\" checked");
        assert_eq!(answer.text().contains(&ticked), fields.iter().any(|(name, _)| *name == "person"), "{why}");
    }
    let bare = [("person", ana.as_str()), ("act", "join")];
    assert_eq!(post(&mut head, "/people", "/people/bulk/do", &bare).await.status, 400);
    assert_eq!(post(&mut head, "/people", "/people/bulk/do", &[("person", "x"), ("act", "join")]).await.status, 400);
}
