//! One email address with an account at each of two schools. Fails when a password opens the other school, when an account at one school
//! gives more attempts at the other, or when a link is mailed for one of them only.

use std::net::IpAddr;

use acts::auth::rate_limits;
use acts::people::accounts;
use model::Role;
use platform::secret;
use store::people;

use crate::support::client::{Client, csrf_in};
use crate::support::{App, Member, PASSWORD};

const EMAIL: &str = "ada@example.org";
const OTHER_PASSWORD: &str = "vier Käse im Wind";

/// Two schools, and a person of each with the same address.
async fn two_accounts() -> (App, Member, Member) {
    let app = App::new().await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    let at_north = app.member(north, Role::Trainee, EMAIL).await;
    let at_south = app.member(south, Role::Trainee, EMAIL).await;
    let hash = secret::hash_password(OTHER_PASSWORD, app.state.config.password_cost).unwrap();
    app.write(async |tx| people::set_password(tx, at_south.person.id, &hash).await.unwrap()).await;
    (app, at_north, at_south)
}

async fn pseudonym(browser: &mut Client) -> String {
    browser.get("/account/export").await.json()["person"]["pseudonym"].as_str().unwrap_or_default().to_owned()
}

/// Signs in on the page of a school.
async fn sign_in_at(app: &App, school: &str, password: &str) -> (Client, u16) {
    let mut browser = app.stranger();
    let page = browser.get(&format!("/login?school={school}")).await.text();
    assert!(page.contains(&format!("name=\"school\" value=\"{school}\"")), "{page}");
    let fields = [("csrf", &*csrf_in(&page)), ("email", EMAIL), ("password", password), ("school", school)];
    let answer = browser.form("/login", &fields).await;
    (browser, answer.status.as_u16())
}

#[tokio::test]
async fn each_password_opens_the_account_it_belongs_to() {
    let (app, at_north, at_south) = two_accounts().await;
    for (password, member) in [(PASSWORD, &at_north), (OTHER_PASSWORD, &at_south)] {
        let mut browser = app.stranger();
        assert_eq!(browser.sign_in(EMAIL, password).await.status, 303);
        assert_eq!(pseudonym(&mut browser).await, member.person.pseudonym);
    }
    assert_eq!(app.stranger().sign_in(EMAIL, "wrong").await.status, 401);
    assert_eq!(sign_in_at(&app, "South", PASSWORD).await.1, 401, "the password of the other school");
}

#[tokio::test]
async fn the_page_of_a_school_opens_its_account() {
    let (app, at_north, at_south) = two_accounts().await;
    let hash = secret::hash_password(PASSWORD, app.state.config.password_cost).unwrap();
    app.write(async |tx| people::set_password(tx, at_south.person.id, &hash).await.unwrap()).await;
    for (school, member) in [("North", &at_north), ("South", &at_south)] {
        let (mut browser, status) = sign_in_at(&app, school, PASSWORD).await;
        assert_eq!((status, pseudonym(&mut browser).await), (303, member.person.pseudonym.clone()), "{school}");
    }
}

#[tokio::test]
async fn an_account_elsewhere_gives_no_more_attempts() {
    let (app, at_north, at_south) = two_accounts().await;
    let ids = vec![at_north.person.id, at_south.person.id];
    let reach = async |host: u8| {
        rate_limits::take_sign_in(&app.state, IpAddr::from([192, 0, 2, host]), EMAIL, ids.clone()).await
    };
    // Someone who administers the school South signs in to its account from many addresses.
    for host in 1..=200 {
        rate_limits::welcome(&app.state, [192, 0, 2, host].into(), at_south.person.id).await.unwrap();
    }
    let mut guesses = 0;
    for host in 1..=200 {
        guesses += u32::from(reach(host).await.unwrap().accounts.contains(&at_north.person.id));
    }
    assert!((50..150).contains(&guesses), "{guesses} attempts on the account at North");
    let left = reach(1).await.unwrap();
    assert_eq!((left.accounts, left.is_known), (vec![at_south.person.id], true), "the own account stays open");
}

#[tokio::test]
async fn a_forgotten_password_gets_a_link_for_each_account() {
    let (app, ..) = two_accounts().await;
    accounts::ask_for_link(&app.state, EMAIL).await.unwrap();
    accounts::answer_asked(&app.state).await.unwrap();
    let queued = "SELECT count(*) FROM mails WHERE kind = 'reset'";
    let queued: i64 = sqlx::query_scalar(queued).fetch_one(app.state.db.reader()).await.unwrap();
    assert_eq!(queued, 2);
}

#[tokio::test]
async fn own_password_is_compared_with_the_own_account() {
    let (app, _, at_south) = two_accounts().await;
    let south = at_south.person.into_current().unwrap();
    assert!(accounts::is_own_password(&app.state, &south, OTHER_PASSWORD).await.unwrap());
    assert!(!accounts::is_own_password(&app.state, &south, PASSWORD).await.unwrap());
}
