//! Terms and the comparison of cohorts through the front door. Fails when somebody but an administrator names a term, when a cohort is compared
//! with another week of the year before, and when figures of a few people whom a teacher does not teach are shown.

use acts::authoring::publishing;
use model::ids::SessionId;
use model::{Moment, Role};
use platform::clock::Clock;
use time::Duration;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, course_folder};

struct World {
    app: App,
    now: String,
    before: String,
}

/// Two cohorts, each with a trainee who has practised once: that of the teacher, and one of the year before.
async fn world() -> World {
    let attempt = Attempt::default();
    let app = App::with(Clock::fixed(Moment::from(attempt.started_at + Duration::days(10))), |_| {}).await;
    let school = app.school("North").await;
    app.publish(school).await;
    let member = async |role, name: &str| app.member(school, role, &format!("{name}@example.org")).await;
    let (ada, ben) = (member(Role::Trainee, "ada").await, member(Role::Trainee, "ben").await);
    let (teacher, colleague) = (member(Role::Instructor, "teacher").await, member(Role::Instructor, "colleague").await);
    member(Role::Administrator, "admin").await;
    app.cohort(school, "Now", &[&ada.person, &teacher.person]).await;
    app.cohort(school, "Before", &[&ben.person, &colleague.person]).await;
    practise(&app, &ada, Duration::ZERO).await;
    practise(&app, &ben, Duration::days(-365)).await;
    let known = store::training::cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap();
    let path = |name: &str| format!("/cohorts/{}", known.iter().find(|of| of.name == name).unwrap().id);
    World { now: path("Now"), before: path("Before"), app }
}

async fn practise(app: &App, member: &Member, later: Duration) {
    let first = Attempt::default();
    let started_at = first.started_at + later;
    let attempt = Attempt { session_id: SessionId::random(), started_at, ..first };
    assert_eq!(app.with_token(&member.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
}

impl World {
    async fn browser(&self, name: &str) -> Client {
        self.app.signed_in(&format!("{name}@example.org")).await
    }

    async fn add(&self, name: &str, day: &str) -> Answer {
        let mut admin = self.browser("admin").await;
        let csrf = csrf_in(&admin.get("/admin/terms").await.text());
        admin.form("/admin/terms", &[("csrf", csrf.as_str()), ("name", name), ("starts_on", day)]).await
    }

    /// Puts a cohort into a term by the form of its page.
    async fn choose(&self, cohort: &str, term: &str) {
        let mut admin = self.browser("admin").await;
        let page = admin.get(&format!("{cohort}/programme")).await.text();
        let (before, _) = page.split_once(&format!(">{term}</option>")).expect("the term is offered");
        let (_, value) = before.rsplit_once("value=\"").unwrap();
        let id = &value[..36];
        let fields = [("csrf", csrf_in(&page)), ("term", id.to_owned())];
        let fields: Vec<_> = fields.iter().map(|(name, value)| (*name, value.as_str())).collect();
        assert_eq!(admin.form(&format!("{cohort}/term"), &fields).await.status, 303);
    }

    /// Both cohorts in terms that begin two days before their attempts.
    async fn in_terms(&self) {
        let first = Attempt::default().started_at.date() - Duration::days(2);
        let day = |date: time::Date| date.to_string();
        assert_eq!(self.add("This term", &day(first)).await.status, 303);
        assert_eq!(self.add("Last year", &day(first - Duration::days(365))).await.status, 303);
        self.choose(&self.now, "This term").await;
        self.choose(&self.before, "Last year").await;
    }
}

#[tokio::test]
async fn a_cohort_is_compared_with_the_year_before() {
    let world = world().await;
    let none = world.browser("teacher").await.get(&format!("{}/programme", world.now)).await.text();
    assert!(none.contains("does not belong to a term yet"), "{none}");
    world.in_terms().await;
    let page = world.browser("admin").await.get(&format!("{}/programme", world.now)).await.text();
    assert!(page.contains("end of week 2 of their term"), "{page}");
    assert!(page.contains("Now · This term, n = 1") && page.contains("Before · Last year, n = 1"), "{page}");
    // The course of a year ago lasts longer than the one of now.
    assert!(page.contains(r#"data-label="Week">26<"#) && page.contains("polyline class=\"series s1\""), "{page}");
    // The earlier cohort has no year before: it is compared with none until one is chosen.
    let page = world.browser("admin").await.get(&format!("{}/programme", world.before)).await.text();
    assert!(page.contains(r#"<option value="" selected>Choose</option>"#), "{page}");
    assert!(!page.contains("Now · This term, n = 1"), "{page}");
}

/// A school may teach a course that comes first by its name and that nobody of the cohort has begun.
#[tokio::test]
async fn comparison_opens_with_the_course_that_most_have_begun() {
    let world = world().await;
    world.in_terms().await;
    let school = world.app.school("North").await;
    let folder = tempfile::tempdir().unwrap();
    for (from, to) in [(course_folder(), "course"), (course_folder().join("../scenes"), "scenes")] {
        std::fs::create_dir_all(folder.path().join(to)).unwrap();
        for file in std::fs::read_dir(from).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), folder.path().join(to).join(file.file_name())).unwrap();
        }
    }
    let course = folder.path().join("course/course.toml");
    let other = "id = \"a-first-course\"\ntitle = \"A first course\"\n[mastery]\nrule = \"passes\"\npasses = 1\nof = 1\n\
                 [[exercise]]\nfile = \"2-stop-in-the-fat.toml\"\n";
    std::fs::write(&course, other).unwrap();
    let now = world.app.state.clock.now();
    world.app.write(async |tx| publishing::course(tx, school, &course, now).await.unwrap()).await;
    let mut teacher = world.browser("teacher").await;
    let page = teacher.get(&format!("{}/programme", world.now)).await.text();
    assert!(page.contains("<option value=\"lower-back-basics\" selected"), "{page}");
    assert!(page.contains("<option value=\"a-first-course\">"), "{page}");
    let page = teacher.get(&format!("{}/programme?course=a-first-course", world.now)).await.text();
    assert!(page.contains("<option value=\"a-first-course\" selected"), "{page}");
}

#[tokio::test]
async fn few_people_of_others_are_hidden_from_a_teacher() {
    let world = world().await;
    world.in_terms().await;
    let page = world.browser("teacher").await.get(&format!("{}/programme", world.now)).await.text();
    assert!(page.contains("Now · This term, n = 1"), "own people are seen: {page}");
    assert!(page.contains("hidden: fewer than 5 people") && !page.contains("Last year, n = 1"), "{page}");
    assert!(!page.contains("polyline class=\"series s1\""), "{page}");
    assert_eq!(world.browser("teacher").await.get(&format!("{}/programme", world.before)).await.status, 404);
    assert_eq!(world.browser("ada").await.get(&format!("{}/programme", world.now)).await.status, 403);
}

#[tokio::test]
async fn nonsense_about_terms_is_refused() {
    let world = world().await;
    for (name, day) in [("", "2026-10-12"), ("a\u{202e}b", "2026-10-12"), ("Term", "2026-13-45"), ("Term", "soon")] {
        let answer = world.add(name, day).await;
        assert_eq!(answer.status, 422, "{name:?} {day}");
        assert!(answer.text().contains(r#"role="alert""#));
    }
    assert_eq!(world.add("Term", "2026-10-12").await.status, 303);
    assert!(world.add("Term", "2026-10-13").await.text().contains("There is a term “Term” already"));
    let mut teacher = world.browser("teacher").await;
    for query in ["with=x&pause=0&course=x", "pause=99999999999", "with=00000000-0000-0000-0000-000000000000"] {
        assert_eq!(teacher.get(&format!("{}/programme?{query}", world.now)).await.status, 200, "{query}");
    }
    let csrf = csrf_in(&teacher.get("/cohorts").await.text());
    assert_eq!(teacher.form(&format!("{}/term", world.now), &[("csrf", &csrf), ("term", "")]).await.status, 403);
    let mut admin = world.browser("admin").await;
    let csrf = csrf_in(&admin.get("/admin/terms").await.text());
    for term in ["x", "00000000-0000-0000-0000-000000000007"] {
        let answer = admin.form(&format!("{}/term", world.now), &[("csrf", &csrf), ("term", term)]).await;
        assert_eq!(answer.status, 404, "{term}");
    }
}
