//! What a survey's files are called inside, and when it opens and closes. Fails when a statistical program refuses a column or takes one for
//! another, or when a school's day begins in London.

use std::collections::BTreeSet;
use std::path::Path;

use acts::authoring::instruments;

use crate::support::client::csrf_in;
use crate::surveys::{School, send};

#[tokio::test]
async fn export_columns_have_unique_names_that_spss_accepts() {
    let school = School::new().await;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/instrument-names.toml");
    let (id, now) = (school.id, school.app.state.clock.now());
    school.app.write(async |tx| instruments::publish(tx, id, &path, now).await.map(drop).unwrap()).await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "tricky", &[("identity", "anonymous")]).await;
    let wide = teacher.get(&format!("{survey}/results/answers-wide.csv")).await.text();
    let names: Vec<&str> = wide.lines().next().unwrap().split(',').collect();
    let own = ["role_2", "a_b_3", "a_b", "a_b_2", "Q1", "q1_2", "score_total", "x_1st", "x_with"];
    assert!(own.iter().all(|name| names.contains(name)), "{names:?}");
    let folded: BTreeSet<String> = names.iter().map(|name| name.to_lowercase()).collect();
    assert_eq!(folded.len(), names.len(), "{names:?}");
    let codebook = teacher.get(&format!("{survey}/results/codebook.csv")).await.text();
    let told: Vec<&str> = codebook.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(told, names, "the codebook names the columns of the table");
    assert!(codebook.contains("no = \"\"No; never\"\"") && codebook.contains(",empty,a-b"), "{codebook}");
}

#[tokio::test]
async fn the_days_of_a_survey_are_days_of_the_school() {
    for (zone, last, taken) in [
        ("Pacific/Auckland", "2026-05-20", true),
        ("Pacific/Auckland", "2026-05-19", false),
        ("America/Los_Angeles", "2026-05-20", true),
        ("America/Los_Angeles", "2026-05-19", false),
    ] {
        // 20 May, 09:30 UTC: 21:30 in Auckland, 02:30 in Los Angeles.
        let school = School::new().await;
        school.app.keep_time_zone(school.id, zone).await;
        let mut teacher = school.app.signed_in("teacher@example.org").await;
        let csrf = csrf_in(&teacher.get("/surveys/new").await.text());
        let fields = [
            ("csrf", csrf.as_str()),
            ("instrument", "sus"),
            ("title", "Days"),
            ("identity", "anonymous"),
            ("opens", last),
            ("closes", last),
        ];
        let made = send(&mut teacher, "/surveys/new", &fields).await;
        assert_eq!(made.status == 303, taken, "{zone} {last}: {}", made.text());
        if taken {
            let page = teacher.get(made.header("location")).await.text();
            assert!(page.contains("20 May 2026, 00:00") && page.contains("21 May 2026, 00:00"), "{zone}: {page}");
        }
    }
}
