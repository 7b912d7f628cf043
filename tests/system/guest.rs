//! A guest's way through the window: a study made on its pages, a code, what is agreed to at the station, the attempt, the answers, and
//! what the school then knows. Fails when anything is kept of whoever does not agree, when the code of one who went away is used up,
//! when an answer is not of the attempt after which it was given, and when a guest counts anywhere but in the study.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::Duration;

use serde_json::{Value, json};
use tests::{Service, program, run_ok};

use crate::browser::PASSWORD;
use crate::visitor::{INITIAL, Visitor, choose_password};
use crate::window::{Display, with_extension, within};

const EXERCISE: &str = "curricula/lower-back-basics/1-feel-the-layers.toml";
/// On a busy machine a key may go nowhere: so many more lead round everything on a debriefing.
const MOST_TABS: usize = 8;
/// What the study asks after each attempt.
pub(super) const INSTRUMENT: &str = r#"
id = "one-question"
title = { en = "One question" }
languages = ["en"]
duration_min = 1
source = "here"
licence = "any"
[[scale]]
id = "line"
kind = "slider"
min = 0
max = 100
step = 5
[[item]]
id = "mental"
text = { en = "How hard?" }
scale = "line"
"#;

/// A school with a study and a station.
struct StudySchool {
    service: Service,
    head: Visitor,
    teacher: Visitor,
    /// Its page.
    study: String,
}

/// A school with an administrator, an instructor, the shipped exercises and an instrument.
pub(super) fn found_service(folder: &Path, instrument: &str) -> Service {
    let data = folder.join("data");
    let data_dir = data.to_string_lossy().into_owned();
    run_ok("web-admin", &["migrate", "--data-dir", &data_dir]);
    for (role, email) in [("administrator", "head@example.org"), ("instructor", "ina@example.org")] {
        let add = ["user", "add", "--data-dir", &data_dir, "--school", "North", "--role", role];
        run_ok("web-admin", &[&add[..], &["--email", email, "--name", "Ina", "--password", INITIAL]].concat());
    }
    let instruments = folder.join("instruments");
    fs::create_dir(&instruments).expect("a folder");
    fs::write(instruments.join("one-question.toml"), instrument).expect("a file");
    for documents in ["curricula", &instruments.to_string_lossy()] {
        run_ok("web-admin", &["curricula", "import", documents, "--data-dir", &data_dir, "--school", "North"]);
    }
    let service = Service::start(&data);
    for email in ["head@example.org", "ina@example.org"] {
        choose_password(&service.url, email, PASSWORD);
    }
    service
}

impl StudySchool {
    fn found(folder: &Path) -> Self {
        let service = found_service(folder, INSTRUMENT);
        let [head, teacher] =
            ["head@example.org", "ina@example.org"].map(|email| Visitor::signed_in(&service.url, email, PASSWORD));
        let fields = [
            ("title", "Is it like a patient?"),
            ("exercise", "feel-the-layers"),
            ("attempts", "1"),
            ("groups", "Novices\r\nExperts"),
            ("questions", ""),
            ("after", "one-question"),
            ("consent", "I take part.\r\nI can leave."),
            ("controller", "North"),
            ("contact", "study@example.org"),
            ("kept", "12"),
        ];
        teacher.send("/studies/new", "/studies/new", &fields);
        let listed = teacher.page("/studies");
        let study = listed.split("href=\"/studies/").skip(1).filter_map(|rest| rest.split('"').next());
        let study = study.into_iter().find(|id| *id != "new").expect("the study is listed");
        let study = format!("/studies/{study}");
        Self { service, head, teacher, study }
    }

    /// The code of a guest, from the page that shows it once.
    fn add_guest(&self) -> String {
        let fields = [("group", "0"), ("consent", "yes")];
        code_on(&self.teacher.send(&self.study, &format!("{}/participants", self.study), &fields))
    }

    /// What the school says to a code that a station sends, and nothing else.
    fn type_code(&self, home: &Path, code: &str) -> (u16, Value) {
        let pairing = fs::read(home.join("config/stylet/station.json")).expect("the station is paired");
        let pairing: Value = serde_json::from_slice(&pairing).expect("JSON");
        let agent: ureq::Agent = ureq::Agent::config_builder().http_status_as_error(false).build().into();
        let answer = agent
            .post(format!("{}/api/v1/stations/sign-in", self.service.url))
            .header("Authorization", format!("Bearer {}", pairing["token"].as_str().expect("a token")))
            .content_type("application/json")
            .send(json!({ "code": code }).to_string())
            .expect("an answer");
        let status = answer.status().as_u16();
        (status, serde_json::from_str(&answer.into_body().read_to_string().expect("a body")).expect("JSON"))
    }

    /// The study's table, a row for each attempt.
    fn table(&self) -> String {
        self.teacher.page(&format!("{}/results/study.csv", self.study))
    }
}

fn code_on(page: &str) -> String {
    let code = page.split("code-to-type\">").nth(1).and_then(|rest| rest.split('<').next());
    code.expect("a code on the page").to_owned()
}

/// `stylet` at a station whose user's home is `home`.
pub(super) fn at_home(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program("stylet"));
    command.args(arguments).env("XDG_DATA_HOME", home.join("data")).env("XDG_CONFIG_HOME", home.join("config"));
    command.env_remove("STYLET_TOKEN").env_remove("STYLET_OUTBOX");
    command
}

/// A guest before the window.
pub(super) struct GuestAtWindow {
    pub display: Display,
    pub play: Child,
}

impl GuestAtWindow {
    pub(super) fn sit_down(home: &Path, kept: &Path) -> Self {
        let (display, kept) = (Display::open(), kept.to_string_lossy());
        let play = ["play", EXERCISE, "--device", "operator:constant:10", "--recordings", &kept, "--language", "de"];
        let play = display.open_window(&mut at_home(home, &play));
        Self { display, play }
    }

    /// Presses keys one after the other, no faster than a person and a slow picture.
    pub(super) fn press(&self, keys: &[&str]) {
        for key in keys {
            self.display.press(key);
            sleep(Duration::from_millis(700));
        }
    }

    /// Types a code into the first field, and waits until the school has answered.
    pub(super) fn type_code(&self, code: &str) {
        self.display.and_settles(|| self.display.press("Tab"));
        self.display.and_settles(|| self.display.write(code));
        self.display.and_settles(|| self.display.press("Return"));
    }

    /// Goes past the three buttons below the debriefing to what is asked, and answers the first question.
    pub(super) fn answer_first(&self, outbox: &Path) {
        self.press(&["Tab", "Tab", "Tab", "Tab", "Return"]);
        self.press(&["Tab", "Tab", "Tab"]);
        let answered = (0..MOST_TABS).any(|_| {
            self.press(&["Tab", "Right", "Right"]);
            with_extension(outbox, "draft").is_some()
        });
        assert!(answered, "no answer is on the disk");
    }
}

impl Drop for GuestAtWindow {
    fn drop(&mut self) {
        let _ = self.play.kill();
        let _ = self.play.wait();
    }
}

#[test]
fn a_guest_agrees_practises_and_answers_at_the_station() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, kept) = (folder.path().join("home"), folder.path().join("kept"));
    fs::create_dir(&kept).expect("a folder");
    let school = StudySchool::found(folder.path());
    let pairing_code = code_on(&school.head.press("/admin", "/admin/pairing-codes"));
    let pair = ["pair", "--server", &school.service.url, "--code", &pairing_code, "--name", "lab 2"];
    assert!(at_home(&home, &pair).output().expect("stylet starts").status.success());
    let code = school.add_guest();
    let guest = GuestAtWindow::sit_down(&home, &kept);

    // They read what they are asked, and go away: nothing has happened.
    guest.type_code(&code);
    guest.press(&["Tab", "Tab", "space"]);
    sleep(Duration::from_secs(1));
    let (status, terms) = school.type_code(&home, &code);
    assert_eq!((status, &terms["consent"]), (202, &json!("I take part.\nI can leave.")), "{terms}");
    assert!(fs::read_dir(&kept).expect("a folder").next().is_none(), "nothing is kept of whoever declines");
    assert!(!school.teacher.page("/studies").contains("signed in"));

    // They come back, agree, and practise.
    guest.type_code(&code);
    guest.press(&["Tab", "space"]);
    guest.display.begin_attempt(&kept);
    assert_eq!(school.type_code(&home, &code).0, 403, "a code is good once");
    let recording = within(90, "the recording", || with_extension(&kept, "mcap"));
    let session = recording.file_stem().expect("a name").to_string_lossy().into_owned();
    within(90, "the attempt in the study", || Some(()).filter(|()| school.table().contains(&session)));

    guest.answer_first(&home.join("data/stylet/outbox"));
    // Past the cross that takes the answer back.
    guest.press(&["Tab", "Tab", "Return"]);
    let row = within(60, "the answer beside its attempt", || {
        let table = school.table();
        let [names, row] = [table.lines().next()?, table.lines().find(|line| line.contains(&session))?]
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let answer = row.get(names.iter().position(|name| name == "q1_mental")?)?.clone();
        (!answer.is_empty()).then_some(row)
    });
    check_what_the_school_knows(&school, &session, &row[0]);
}

/// The study has the guest with their attempt and their answer, and nobody else knows of either.
fn check_what_the_school_knows(school: &StudySchool, session: &str, pseudonym: &str) {
    let page = school.teacher.page(&school.study);
    assert!(page.contains("1 of 1") && page.contains(pseudonym), "the study counts its guest: {page}");
    for path in ["/people", "/cohorts", "/progress", "/progress/attempts.csv", "/exercises/feel-the-layers", "/review"]
    {
        let page = school.head.page(path);
        assert!(!page.contains(pseudonym) && !page.contains(session), "{path} tells of a guest");
    }
    let log = school.head.page("/admin/audit.csv");
    assert!(log.contains("study.consented"), "the log tells that they agreed");
}
