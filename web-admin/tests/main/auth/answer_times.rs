//! What an answer takes tells nobody who has an account: signing in with a wrong password, and asking for a link, by addresses that are known
//! and that are not. Timings depend on the machine, so this prints and is run by hand:
//! `cargo test --workspace --test main answer_times -- --ignored --nocapture`.

use std::time::{Duration, Instant};

use axum::body::Body;
use axum::http::{Request, header};
use model::Role;
use platform::clock::Clock;
use platform::secret::PasswordCost;
use store::people;

use crate::support::App;
use crate::support::client::{Client, csrf_in, encoded};

/// Answers of each kind.
const ANSWERS: usize = 240;
/// People of each kind: nobody is tried so often that they are held up.
const PEOPLE: usize = 40;

/// Sends a form from an address of its own, and tells how long the answer took.
#[expect(clippy::disallowed_methods, reason = "it measures")]
async fn answered(client: &mut Client, (path, fields): (&str, &[(&str, &str)]), from: usize) -> (u16, Duration) {
    let request = Request::post(path)
        .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
        .header("x-forwarded-for", format!("10.{}.{}.{}", from / 65_536, from / 256 % 256, from % 256))
        .body(Body::from(encoded(fields)))
        .unwrap();
    let start = Instant::now();
    let status = client.send(request).await.status.as_u16();
    (status, start.elapsed())
}

fn quantile_ms(times: &mut [Duration], part: f64) -> f64 {
    times.sort();
    times[((times.len() - 1) as f64 * part) as usize].as_secs_f64() * 1e3
}

#[tokio::test]
#[ignore = "measures"]
async fn known_and_unknown_addresses_take_as_long() {
    let app = App::with(Clock::system(), |config| {
        config.behind_tls = true;
        config.password_cost = PasswordCost::RECOMMENDED;
    })
    .await;
    let school = app.school("North").await;
    let now = app.state.clock.now();
    for n in 0..PEOPLE {
        app.member(school, Role::Trainee, &format!("known{n}@example.org")).await;
        let disabled = app.member(school, Role::Trainee, &format!("disabled{n}@example.org")).await.person.id;
        app.write(async |tx| people::disable_person(tx, disabled, now).await.unwrap()).await;
    }
    let mut stranger = app.stranger();
    let csrf = csrf_in(&stranger.get("/login").await.text());
    for (path, kinds) in [("/login", &["known", "unknown", "disabled"][..]), ("/forgotten", &["known", "unknown"])] {
        let mut times = vec![Vec::new(); kinds.len()];
        for n in 0..ANSWERS {
            for (kind, times) in kinds.iter().zip(&mut times) {
                let email = format!("{kind}{}@example.org", n % PEOPLE);
                let fields = [("csrf", csrf.as_str()), ("email", &email), ("password", "a wrong password")];
                let (status, time) = answered(&mut stranger, (path, &fields), 1 + n * 8 + kind.len() % 8).await;
                assert_eq!(status, if path == "/login" { 401 } else { 200 }, "{kind}");
                times.push(time);
            }
        }
        for (kind, times) in kinds.iter().zip(&mut times) {
            let (p25, p50, p75) = (quantile_ms(times, 0.25), quantile_ms(times, 0.5), quantile_ms(times, 0.75));
            println!("{path} {kind}: median {p50:.2} ms, quartiles {p25:.2} and {p75:.2} ms, of {ANSWERS}");
        }
    }
}
