//! The scoring keys of the shipped instruments, against the published vectors. Fails when an item is reversed that should
//! not be, when weights are not counted from the pairs, or when a missing answer quietly becomes a number.

use std::path::Path;

use assessment::questionnaire::{Answer, NoScore, read_answer, score_range, score_response};
use documents::instrument::Instrument;

type Answers = Vec<Option<Answer>>;

fn shipped(name: &str) -> Instrument {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments").join(name);
    Instrument::from_bytes(name, &std::fs::read(path.with_extension("toml")).expect("an instrument that is shipped"))
        .expect("a sound instrument")
}

fn numbers(answers: &[f64]) -> Answers {
    answers.iter().map(|x| Some(Answer::Number(*x))).collect()
}

/// The answers 70, 30, 55, 40, 65, 25, and pairs that choose the scales 4, 1, 3, 2, 4 and 1 times: effort loses to
/// frustration and wins against the others, which win by this order.
fn workload(instrument: &Instrument) -> Answers {
    let order = ["mental", "temporal", "performance", "physical", "frustration"];
    let place = |id: &String| order.iter().position(|known| known == id);
    let mut answers = numbers(&[70.0, 30.0, 55.0, 40.0, 65.0, 25.0]);
    for item in &instrument.items[6..] {
        let heavier = match (item.pair.iter().any(|id| id == "effort"), item.pair.iter().any(|id| id == "frustration"))
        {
            (true, true) => "frustration",
            (true, false) => "effort",
            _ => item.pair.iter().min_by_key(|id| place(id)).expect("a pair has two"),
        };
        answers.push(Some(Answer::Text(heavier.to_owned())));
    }
    answers
}

#[test]
fn sus_by_its_vector() {
    let sus = shipped("sus");
    let answers = numbers(&[5.0, 2.0, 4.0, 1.0, 5.0, 2.0, 5.0, 1.0, 4.0, 2.0]);
    assert!((score_response(&sus, &sus.scores[0], &answers).unwrap() - 87.5).abs() < 1e-4);
    assert_eq!(score_range(&sus, &sus.scores[0]), (0.0, 100.0));
    let neutral = score_response(&sus, &sus.scores[0], &numbers(&[3.0; 10])).unwrap();
    assert!((neutral - 50.0).abs() < 1e-12);
}

#[test]
fn workload_raw_and_weighted_by_their_vector() {
    let tlx = shipped("nasa-tlx-weighted");
    let answers = workload(&tlx);
    let by = |id: &str| score_response(&tlx, tlx.scores.iter().find(|s| s.id == id).unwrap(), &answers).unwrap();
    assert!((by("raw") - 47.5).abs() < 1e-4, "{}", by("raw"));
    assert!((by("weighted") - 56.0).abs() < 1e-4, "{}", by("weighted"));
    let raw = shipped("nasa-tlx");
    assert!((score_response(&raw, &raw.scores[0], &answers[..6]).unwrap() - 47.5).abs() < 1e-4);
}

#[test]
fn score_without_a_policy_names_the_missing_item() {
    let sus = shipped("sus");
    let mut answers = numbers(&[3.0; 10]);
    answers[3] = None;
    assert_eq!(score_response(&sus, &sus.scores[0], &answers), Err(NoScore::Missing(vec!["support".to_owned()])));
    let tlx = shipped("nasa-tlx-weighted");
    let mut answers = workload(&tlx);
    answers[8] = None;
    let refused = score_response(&tlx, &tlx.scores[1], &answers).unwrap_err();
    assert_eq!(refused.to_string(), "no answer to mental-or-performance");
    assert!(score_response(&tlx, &tlx.scores[0], &answers).is_ok(), "the raw score asks for no pairs");
}

#[test]
fn a_stated_policy_does_without_as_many_as_it_says() {
    let validity = shipped("simulator-validity");
    let key = &validity.scores[0];
    let mut answers: Answers = vec![None; validity.items.len()];
    for (id, x) in key.items.iter().zip([5.0, 4.0, 3.0]) {
        answers[validity.item(id).unwrap().0] = Some(Answer::Number(x));
    }
    let Err(NoScore::Missing(missing)) = score_response(&validity, key, &answers) else { panic!("three are too few") };
    assert_eq!(missing.len(), 3);
    answers[validity.item(&missing[0]).unwrap().0] = Some(Answer::Number(4.0));
    assert!((score_response(&validity, key, &answers).unwrap() - 4.0).abs() < 1e-12);
}

#[test]
fn an_answer_out_of_range_is_refused_with_what_is_allowed() {
    let validity = shipped("simulator-validity");
    let read = |id: &str, said: &str| {
        let (_, item) = validity.item(id).unwrap();
        read_answer(item, validity.scale(item).unwrap(), &[said])
    };
    for (id, said, allowed) in [
        ("pops", "6", "a whole number from 1 to 5"),
        ("pops", "0", "from 1 to 5"),
        ("pops", "2.5", "from 1 to 5"),
        ("years", "-1", "a number from 0 to 60\u{a0}years"),
        ("years", "NaN", "from 0 to 60"),
        ("years", "inf", "from 0 to 60"),
        ("punctures", "many", "none, up-to-20, up-to-100, more"),
        ("comment", &"ä".repeat(4001), "at most 4000 characters"),
    ] {
        let refused = read(id, said).expect_err(said).to_string();
        assert!(refused.contains(allowed), "{id} {said}: {refused}");
    }
    assert_eq!(read("years", " 2,5 "), Ok(Some(Answer::Number(2.5))));
    assert_eq!(read("comment", "<b>&\r\n"), Ok(Some(Answer::Text("<b>&\n".to_owned()))));
    assert_eq!(read("pops", " "), Ok(None));
    let tlx = shipped("nasa-tlx");
    assert!(read_answer(&tlx.items[0], tlx.scale(&tlx.items[0]).unwrap(), &["52"]).is_err(), "between two steps");
}

#[test]
fn answers_come_back_from_json_as_they_went() {
    let answers: Answers = vec![
        Some(Answer::Number(55.0)),
        Some(Answer::Number(-2.5)),
        None,
        Some(Answer::Text("5 \u{2013} \"so\"".to_owned())),
        Some(Answer::Several(vec!["a".to_owned(), "b".to_owned()])),
    ];
    let text = serde_json::to_string(&answers).unwrap();
    assert_eq!(serde_json::from_str::<Answers>(&text).unwrap(), answers);
    let whole: Answers = serde_json::from_str("[55, -2.5, null, \"5\", []]").unwrap();
    assert_eq!(whole[0], answers[0], "a whole number is a number");
    assert_eq!(whole[3..], [Some(Answer::Text("5".to_owned())), Some(Answer::Several(vec![]))]);
    assert!(serde_json::from_str::<Answers>("[{}]").is_err() && serde_json::from_str::<Answers>("[true]").is_err());
}
