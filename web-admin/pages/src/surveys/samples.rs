//! Renders every page of a survey from the shipped instruments. Pages must render in the correct
//! language, and input must never become markup.

use assessment::questionnaire::{Answer, Scorer};
use documents::Instrument;
use model::ids::ResponseId;
use model::letters::mail::LetterDelivery;
use model::surveys::Identity;
use model::surveys::results::{ResponseRow, Results, correlation, score_group};
use model::{Moment, Role};
use words::Language;

use super::form::{
    ConsentPage, EndPage, FormPage, FormQuestion, GivenField, SurveyAsker, SurveyContact, SurveyEnd, Terms,
};
use super::instrument::{EditPage, InstrumentPage, InstrumentPreview, InstrumentsPage};
use super::manage::{ManagePage, NewSurveyForm, NewSurveyPage, OwnSurveyRow, SurveyLinksPage, SurveyRow, SurveysPage};
use super::results::{
    AskedLine, CommentBlock, ResultsPage, ScatteredScore, ScatteredScores, SplitScore, SplitScores, SurveyComment,
};
use crate::charts::Extent;
use crate::form::{FilledForm, SelectOption};
use crate::samples::{NOW, keep_page, shell};

fn shipped(name: &str) -> Instrument {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments").join(name);
    Instrument::from_bytes(name, &std::fs::read(path).unwrap()).unwrap()
}

fn form(instrument: &Instrument, language: &str, page: usize) -> FormPage {
    let pages = instrument.pages();
    let refused = |at: usize| (at == 0).then(|| ("<b>9</b>".to_owned(), "\"<b>9</b>\"; allowed: 1 to 5".to_owned()));
    let question = |at: &usize| {
        let given = GivenField { refused: refused(*at), ..GivenField::default() };
        FormQuestion::new(instrument, &instrument.items[*at], language, &given)
    };
    FormPage {
        language: language.to_owned(),
        title: instrument.title.in_language(language).to_owned(),
        heading: pages[page].0.map(|s| (s.title.in_language(language).to_owned(), String::new())),
        step: (page + 1, pages.len()),
        is_last: page + 1 >= pages.len(),
        page,
        questions: pages[page].1.iter().map(question).collect(),
        action: "/survey/secret".to_owned(),
        preview: None,
    }
}

#[test]
fn the_form_asks_in_both_languages_and_escapes_what_was_typed() {
    for name in ["sus.toml", "nasa-tlx-weighted.toml", "simulator-validity.toml", "free-comment.toml"] {
        let instrument = shipped(name);
        for page in 0..instrument.pages().len() {
            let english = keep_page(&format!("survey-{}-{page}", instrument.id), &form(&instrument, "en", page));
            let german = || keep_page(&format!("survey-{}-{page}-de", instrument.id), &form(&instrument, "de", page));
            let german = words::within(Language::named("de").expect("German"), german);
            assert!(english.contains("<html lang=\"en\">") && german.contains("<html lang=\"de\">"));
            assert!(german.contains("Abbrechen, ohne zu senden") && !german.contains("Save and go on"), "{german}");
            assert!(!english.contains("<b>9"), "{english}");
        }
    }
}

fn terms_of(identity: Identity) -> Terms {
    Terms {
        language: "en".to_owned(),
        title: "What do you think?".to_owned(),
        intro: "A few questions.".to_owned(),
        duration_min: 1.5,
        questions: 10,
        identity,
        after_attempt: true,
        asker: SurveyAsker {
            school: "Nordklinik".to_owned(),
            contact: Some(SurveyContact { name: "Dr Osei".to_owned(), email: "osei@example.org".to_owned() }),
            data_notice: "Controller: Nordklinik.\nKept for 24 months.".to_owned(),
        },
    }
}

#[test]
fn guest_at_a_station_is_referred_to_the_study_team() {
    let [own, guest] = [false, true].map(|guest| terms_of(Identity::Pseudonymous).at_a_station(guest).join("\n"));
    assert!(own.contains("page of your school") && !own.contains("study team"), "{own}");
    assert!(guest.contains("study team") && !guest.contains("page of your school"), "{guest}");
    assert_eq!(own.lines().count(), guest.lines().count(), "the same is told, paragraph by paragraph");
}

#[test]
fn before_the_first_question_it_is_said_what_leads_to_a_person() {
    for (identity, says) in
        [(Identity::Anonymous, "are anonymous"), (Identity::Pseudonymous, "pseudonym"), (Identity::Named, "your name")]
    {
        let page = ConsentPage {
            terms: terms_of(identity),
            action: "/survey/secret".to_owned(),
            hidden: vec![("csrf", "token".to_owned())],
            languages: vec![("en".to_owned(), "?lang=en".to_owned()), ("de".to_owned(), "?lang=de".to_owned())],
            refused: identity == Identity::Named,
            begun: false,
        };
        let html = keep_page(&format!("survey-consent-{}", identity.as_str()), &page);
        assert!(
            html.contains(says)
                && html.contains("Nordklinik")
                && html.contains("osei@example.org")
                && html.contains("24 months")
                && html.contains("voluntary")
                && html.contains("Deutsch"),
            "{html}"
        );
    }
}

#[test]
fn the_end_says_what_became_of_the_answers() {
    for (end, says) in [
        (SurveyEnd::Sent, "have been sent"),
        (SurveyEnd::Withdrawn, "are deleted"),
        (SurveyEnd::Discarded, "No answers were sent"),
    ] {
        let (language, title, action) = ("en".to_owned(), "Survey".to_owned(), "/survey/secret".to_owned());
        let page = EndPage { language, title, end, identity: Identity::Anonymous, action };
        assert!(keep_page(&format!("survey-end-{end:?}").to_lowercase(), &page).contains(says));
    }
}

/// Returns a sent letter, a waiting one, two with errors, and one with unknown state.
fn letters() -> Vec<LetterDelivery> {
    let at = Moment::from(NOW);
    let letter = |name: &str, sent_at, error: Option<&str>, next_run_at| LetterDelivery {
        name: name.to_owned(),
        email: "dr@example.org".to_owned(),
        sent_at,
        error: error.map(str::to_owned),
        next_run_at,
    };
    vec![
        letter("Dr A", Some(at), None, None),
        letter("", None, None, Some(at)),
        letter("Dr C", None, Some("no such mailbox <x>"), Some(at)),
        letter("Dr D", None, Some("invalid email address"), None),
        letter("Dr E", None, None, None),
    ]
}

#[test]
fn lists_and_the_page_of_a_survey() {
    let row = SurveyRow {
        title: "Validity <2026>".to_owned(),
        href: "/surveys/1".to_owned(),
        instrument: "Face and content validity".to_owned(),
        open: true,
        generated: true,
        created_at: NOW,
    };
    let page = SurveysPage { shell: shell(Role::Instructor), asked: vec![], surveys: Some(vec![row]) };
    let html = keep_page("surveys", &page);
    assert!(html.contains("Generated answers") && !html.contains("<2026>"), "{html}");
    let asked = OwnSurveyRow {
        title: "Usability".to_owned(),
        href: "/surveys/1".to_owned(),
        duration_min: 1.5,
        answered: false,
        closes_at: Some(NOW),
    };
    let page = SurveysPage { shell: shell(Role::Trainee), asked: vec![asked], surveys: None };
    assert!(keep_page("surveys-trainee", &page).contains("Answer"));
    let page = ManagePage {
        shell: shell(Role::Instructor),
        title: "Validity".to_owned(),
        href: "/surveys/1".to_owned(),
        instrument: ("Face and content validity".to_owned(), "/surveys/instruments/x".to_owned()),
        identity: Identity::Anonymous,
        facts: vec![("Links", "12, of which 3 answered".to_owned())],
        open: true,
        owner: true,
        labels: FilledForm::refused(" ".to_owned(), "0 lines; allowed: 1 to 200".to_owned()),
        letters: letters(),
        letters_left: 298,
        mailed: Some((2, 1)),
    };
    let html = keep_page("survey-manage", &page);
    assert!(html.contains("shown once") && html.contains("1 already received an email"), "{html}");
    for words in ["Sent", "Waiting", "no such mailbox &#60;x&#62;", "It may have been sent"] {
        assert!(html.contains(words), "{words}: {html}");
    }
    let links = vec![("Dr <A>".to_owned(), "https://x.example/survey/abc".to_owned())];
    let page = SurveyLinksPage {
        shell: shell(Role::Instructor),
        title: "Validity".to_owned(),
        href: "/surveys/1".to_owned(),
        links,
    };
    assert!(keep_page("survey-links", &page).contains("1 link"));
}

#[test]
fn a_new_survey_keeps_what_was_typed() {
    let typed = NewSurveyForm {
        title: "My \"study\"".to_owned(),
        identity: "named".to_owned(),
        after_attempts: true,
        fresh: "24".to_owned(),
        opens: String::new(),
        closes: "2026-06-01".to_owned(),
        ..NewSurveyForm::default()
    };
    let page = NewSurveyPage {
        shell: shell(Role::Instructor),
        instruments: vec![("sus".to_owned(), "Usability".to_owned(), true)],
        cohorts: vec![("1".to_owned(), "Spring".to_owned(), true)],
        form: FilledForm::refused(typed, "last day: 2026-06-01; allowed: a day that is not over".to_owned()),
    };
    let html = keep_page("survey-new", &page);
    assert!(html.contains("2026-06-01") && html.contains("checked") && html.contains("&#34;study&#34;"), "{html}");
}

#[test]
fn the_author_of_a_draft_sees_the_form_and_can_send_nothing() {
    let instrument = shipped("simulator-validity.toml");
    let german = || keep_page("survey-preview", &FormPage::of_draft(&instrument, "/drafts/1", "de", 1));
    let html = words::within(Language::named("de").expect("German"), german);
    for wanted in
        ["Nichts wird gespeichert", "nur nach bestimmten Antworten", "lang=en&#38;page=1", "lang=de&#38;page=2"]
    {
        assert!(html.contains(wanted), "{wanted} is missing in {html}");
    }
    assert!(!html.contains("<form") && !html.contains("<script"), "{html}");
}

#[test]
fn instruments_are_listed_shown_and_edited() {
    let rows = vec![("Usability".to_owned(), "/surveys/instruments/sus".to_owned(), "sus".to_owned(), NOW)];
    assert!(
        keep_page("instruments", &InstrumentsPage { shell: shell(Role::Instructor), instruments: rows })
            .contains("sus")
    );
    let preview = InstrumentPreview::new(&shipped("simulator-validity.toml"));
    let href = "/surveys/instruments/simulator-validity".to_owned();
    let courses = vec![SelectOption { value: "c".to_owned(), label: "A course".to_owned(), chosen: false }];
    let page =
        InstrumentPage { shell: shell(Role::Instructor), href, preview: preview.clone(), published: true, courses };
    let html = keep_page("instrument", &page);
    for wanted in
        ["at least 4 must be answered", "Published.", "/surveys/new?instrument=simulator-validity", "A course"]
    {
        assert!(html.contains(wanted), "{wanted} is missing in {html}");
    }
    let page = EditPage {
        shell: shell(Role::Instructor),
        heading: "Edit an instrument",
        action: "/surveys/instruments/x/edit".to_owned(),
        form: FilledForm::refused("</textarea><script>".to_owned(), vec!["document:1:1: id: missing".to_owned()]),
        preview: Some(preview),
    };
    assert!(!keep_page("instrument-edit", &page).contains("</textarea><script>"));
}

/// Returns answers of `n` people, spread over the points by a formula.
fn answers(instrument: &Instrument, n: usize) -> Vec<Vec<Option<Answer>>> {
    let answer = |person: usize, at: usize| {
        let scale = instrument.scale(&instrument.items[at])?;
        match scale.range() {
            Some((least, largest)) => {
                let share = ((person * 7 + at * 3) % 5 + person % 3 + at % 2) as f64 / 7.0;
                Some(Answer::Number((least + share * (largest - least)).round()))
            }
            None => scale.options().get(person % 3).map(|option| Answer::Text(option.id.clone())),
        }
    };
    (0..n).map(|person| (0..instrument.items.len()).map(|at| answer(person, at)).collect()).collect()
}

/// Returns results of the validity questionnaire.
pub(crate) fn sample_survey_results() -> Results {
    results_page(&shipped("simulator-validity.toml"), true).results
}

fn results_page(instrument: &Instrument, owner: bool) -> ResultsPage {
    let given = answers(instrument, 24);
    let rows: Vec<ResponseRow<'_>> = given
        .iter()
        .enumerate()
        .map(|(n, answers)| ResponseRow {
            id: ResponseId::from_u128(n as u128),
            role: if n % 2 == 0 { "professional" } else { "trainee" },
            attempt: [Some("stop-in-the-fat"), None, None],
            month: "2026-05".to_owned(),
            scores: Scorer::all(instrument).iter().map(|scorer| scorer.score(answers).ok()).collect(),
            answers,
        })
        .collect();
    let rows: Vec<&ResponseRow<'_>> = rows.iter().collect();
    let points: Vec<(f64, f64)> =
        rows.iter().zip(1..).filter_map(|(row, n)| Some((f64::from(n), row.scores[0]?))).collect();
    let comment = SurveyComment {
        response: ResponseId::nil().to_string(),
        who: "professional".to_owned(),
        text: "<script>alert(1)</script>".to_owned(),
        tags: vec!["picture".to_owned()],
    };
    ResultsPage {
        shell: shell(Role::Instructor),
        survey: ("Validity".to_owned(), "/surveys/1".to_owned()),
        instrument: "Face and content validity".to_owned(),
        identity: Identity::Pseudonymous,
        generated: true,
        owner,
        asked: vec![AskedLine { who: "Professionals, by link", asked: 15, answered: 12 }],
        results: Results::new(instrument, &rows, owner),
        split: SplitScores {
            ways: vec![("month", "month", true), ("device", "device", false)],
            scores: vec![SplitScore {
                title: "Realism".to_owned(),
                range: Extent::new(1.0, 5.0),
                groups: vec![score_group("2026-05 · trainee", &rows, 0)],
            }],
            hidden: 3,
        },
        against: ScatteredScores {
            metrics: vec![("peak_force_n", "peak force (N)", true)],
            scores: vec![ScatteredScore {
                title: "Realism".to_owned(),
                points: points.clone(),
                rho: correlation(&points),
            }],
        },
        comments: vec![
            CommentBlock {
                item: "comment".to_owned(),
                text: "What is missing?".to_owned(),
                comments: Some(vec![comment]),
            },
            CommentBlock { item: "else".to_owned(), text: "What else?".to_owned(), comments: None },
        ],
        tags: vec![("picture".to_owned(), 1)],
    }
}

#[test]
fn results_show_pictures_tables_and_why_something_is_missing() {
    let html = keep_page("survey-results", &results_page(&shipped("simulator-validity.toml"), true));
    for wanted in ["S-CVI/Ave", "ICC(2,1)", "Spearman", "80\u{a0}%", "generated by a program", "fewer than five people"]
    {
        assert!(html.contains(wanted), "{wanted} is not in {html}");
    }
    assert!(!html.contains("<script>alert"), "{html}");
    keep_page("survey-results-tlx", &results_page(&shipped("nasa-tlx.toml"), false));
}

#[test]
fn alpha_of_one_item_is_not_computable_and_says_so() {
    let mut one = shipped("nasa-tlx.toml");
    one.scores[0].items.truncate(1);
    let html = keep_page("survey-results-one", &results_page(&one, true));
    assert!(html.contains("not computable: 1 items, at least 2 needed"), "{html}");
}
