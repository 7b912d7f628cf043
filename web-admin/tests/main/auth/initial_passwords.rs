//! A password that somebody else has set. Fails when it signs in, when it becomes the one that stays, when it is good for longer than it should
//! be, and when one's own is asked to be changed.

use acts::people::accounts;
use model::{Moment, Role};
use platform::clock::Clock;
use store::people;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::database::program;
use crate::support::{App, PASSWORD};

const OWN: &str = "seven quiet herons wade";

fn web_admin(app: &App, words: &[&str]) -> String {
    let output = program(app.folder.path()).arg("user").args(words).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

async fn choose(client: &mut Client, path: &str, password: &str) -> Answer {
    let csrf = csrf_in(&client.get(path).await.text());
    client.form(path, &[("csrf", &csrf), ("password", password), ("again", password)]).await
}

#[tokio::test]
async fn a_password_of_the_command_line_is_good_to_choose_ones_own() {
    let app = App::new().await;
    web_admin(
        &app,
        &["add", "--email", "ada@example.org", "--name", "Ada", "--school", "North", "--password", PASSWORD],
    );
    let mut ada = app.stranger();
    let led = ada.sign_in("ada@example.org", PASSWORD).await;
    let path = led.header("location").to_owned();
    assert!(led.status == 303 && path.starts_with("/join/"), "{} {path}", led.status);
    assert_eq!(ada.get("/account").await.status, 303, "nobody is signed in");

    let kept = choose(&mut ada, &path, PASSWORD).await;
    assert!(kept.status == 422 && kept.text().contains("was created for you"), "{}", kept.text());
    let chosen = choose(&mut ada, &path, OWN).await;
    assert_eq!((chosen.status.as_u16(), chosen.header("location")), (303, "/"));
    assert_eq!(ada.get("/account").await.status, 200);
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.status, 401);
    assert_eq!(app.stranger().sign_in("ada@example.org", OWN).await.header("location"), "/", "it is asked for once");

    let said = web_admin(&app, &["reset-password", "--email", "ada@example.org"]);
    let made = said.lines().find_map(|line| line.strip_prefix("password: ")).unwrap();
    assert!(app.stranger().sign_in("ada@example.org", made).await.header("location").starts_with("/join/"));
    assert_eq!(ada.get("/account").await.status, 303, "a new password ends what was signed in");
}

#[tokio::test]
async fn it_is_good_for_three_days_and_says_what_to_do_then() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await.person.id;
    let until = app.state.clock.now().plus_s(accounts::INITIAL_PASSWORD_S);
    app.write(async |tx| people::make_initial(tx, ada, until).await.unwrap()).await;
    app.state.clock.advance(accounts::INITIAL_PASSWORD_S - 1);
    assert!(app.stranger().sign_in("ada@example.org", PASSWORD).await.header("location").starts_with("/join/"));
    app.state.clock.advance(1);
    let late = app.stranger().sign_in("ada@example.org", PASSWORD).await;
    assert!(late.status == 401 && late.text().contains("has expired"), "{}", late.text());
    let wrong = app.stranger().sign_in("ada@example.org", OWN).await;
    assert!(wrong.status == 401 && !wrong.text().contains("has expired"), "who guesses is told nothing of it");
}

#[tokio::test]
async fn a_school_may_ask_everybody_for_a_second_factor() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let (mut head, mut ada) = (app.signed_in("head@example.org").await, app.signed_in("ada@example.org").await);
    for (rule, of_ada, of_head) in [("teachers", 200, 303), ("everybody", 303, 303), ("nobody", 200, 200)] {
        // Who sets it owes one by then.
        let anew = sqlx::query("UPDATE schools SET second_factor_of = 'nobody'");
        app.write(async |tx| anew.execute(tx).await.unwrap()).await;
        let csrf = csrf_in(&head.get("/admin").await.text());
        let set = head.form("/admin/second-factor", &[("csrf", &csrf), ("rule", rule)]).await;
        assert_eq!(set.header("location"), "/admin/settings?saved=true#second-factor", "{}", set.text());
        let (ada, head) = (ada.get("/").await, head.get("/").await);
        assert_eq!([ada.status.as_u16(), head.status.as_u16()], [of_ada, of_head], "{rule}");
    }
    let page = app.signed_in("head@example.org").await.get("/admin/settings").await.text();
    assert!(page.contains("Everybody, including trainees"), "{page}");
}
