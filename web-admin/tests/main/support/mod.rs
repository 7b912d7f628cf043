//! What the tests share: a service in a folder of its own, clients, and recordings of real, short attempts.

pub mod assertions;
pub mod authenticator;
#[cfg(feature = "replicas")]
pub mod bucket;
pub mod client;
pub mod course_members;
pub mod database;
pub mod failing_disk;
pub mod forgery;
pub mod grade_book;
pub mod learning_platform;
pub mod mail;
pub mod postgres;
pub mod provider;
pub mod record_store;
pub mod recordings;
pub mod service;
pub mod signer;
pub mod statements;
pub mod university;

use std::path::{Path, PathBuf};
use std::process::Output;

use acts::authoring::publishing;
use axum::Router;
use client::Client;
use database::{config_in, place_schema, program};
use model::Role;
use model::ids::SchoolId;
use platform::clock::Clock;
use platform::config::Config;
use platform::secret;
use platform::secret::PasswordCost;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::auth::tokens;
use store::auth::tokens::TokenHolder;
use store::operations::schools;
use store::operations::schools::SchoolSettings;
use store::people::{self, NewPerson, Person};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership};
use tempfile::TempDir;
use web_admin::{AppState, routes};

/// The password of everybody.
pub const PASSWORD: &str = "a long enough password";

/// The course that is shipped.
pub fn course_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../curricula/lower-back-basics")
}

/// A service with an empty database, in a folder that goes with it.
pub struct App {
    pub state: AppState,
    pub router: Router,
    pub folder: TempDir,
}

/// Runs the program on a data folder.
pub fn web_admin(folder: &Path, arguments: &[&str]) -> Output {
    program(folder).args(arguments).output().unwrap()
}

/// Somebody with a token.
pub struct Member {
    pub person: Person,
    pub token: String,
}

impl App {
    pub async fn new() -> Self {
        Self::with(Clock::system(), |_| {}).await
    }

    /// With a clock, and a change to the configuration.
    pub async fn with(clock: Clock, change: impl FnOnce(&mut Config)) -> Self {
        Self::in_folder(tempfile::tempdir().unwrap(), clock, change).await
    }

    /// On what a folder holds already.
    pub async fn in_folder(folder: TempDir, clock: Clock, change: impl FnOnce(&mut Config)) -> Self {
        let mut config = config_in(folder.path());
        // Real hashing, at the least cost there is: what is tested is not its strength.
        config.password_cost = PasswordCost { memory_kib: 8, passes: 1 };
        change(&mut config);
        place_schema(&config.database).await;
        let state = AppState::open(config, clock).await.unwrap();
        Self { router: routes::router(state.clone()), state, folder }
    }

    pub async fn write<T>(&self, work: impl AsyncFnOnce(&mut Connection) -> T) -> T {
        let mut tx = self.state.db.write().await.unwrap();
        let made = work(&mut tx).await;
        tx.commit().await.unwrap();
        made
    }

    pub async fn school(&self, name: &str) -> SchoolId {
        let now = self.state.clock.now();
        self.write(async |tx| schools::find_or_create(tx, name, now).await.unwrap().id).await
    }

    /// Adds a person with a token, and the audit entry that says so.
    pub async fn member(&self, school: SchoolId, role: Role, email: &str) -> Member {
        let (now, token) = (self.state.clock.now(), secret::random_hex().unwrap());
        let hash = secret::hash_password(PASSWORD, self.state.config.password_cost).unwrap();
        let new = NewPerson { school_id: school, role, email, display_name: "Somebody", password_hash: &hash };
        let person = self
            .write(async |tx| {
                let person = people::add_person(tx, &new, now).await.unwrap();
                let holder = TokenHolder { school_id: school, person_id: Some(person.id), station: None };
                tokens::add_station_token(tx, &holder, &secret::token_sha256(&token), now).await.unwrap();
                let entry = AuditEntry::new(school, Actor::CommandLine, "person.added", person.id);
                entry.append(tx, now).await.unwrap();
                person
            })
            .await;
        Member { person, token }
    }

    /// The token of a station.
    pub async fn station(&self, school: SchoolId) -> String {
        let (now, token) = (self.state.clock.now(), secret::random_hex().unwrap());
        let holder = TokenHolder { school_id: school, person_id: None, station: Some("room 2".to_owned()) };
        self.write(async |tx| {
            tokens::add_station_token(tx, &holder, &secret::token_sha256(&token), now).await.unwrap()
        })
        .await;
        token
    }

    /// Puts people into a cohort.
    pub async fn cohort(&self, school: SchoolId, name: &str, people: &[&Person]) {
        let now = self.state.clock.now();
        self.write(async |tx| {
            let cohort = cohorts::find_or_create(tx, school, name, now).await.unwrap();
            for person in people {
                let membership =
                    Membership { school_id: school, cohort_id: cohort.id, person_id: person.id, role: person.role };
                cohorts::join_cohort(tx, membership, Attribution { by: None, at: now }).await.unwrap();
            }
        })
        .await;
    }

    /// Publishes the shipped course.
    pub async fn publish(&self, school: SchoolId) -> Vec<publishing::Published> {
        let now = self.state.clock.now();
        let course = course_folder().join("course.toml");
        self.write(async |tx| publishing::course(tx, school, &course, now).await.unwrap()).await
    }

    /// Publishes the course once more, with another pass mark for its first exercise.
    pub async fn publish_with_pass_mark(&self, school: SchoolId, pass_mark: u32) {
        let (folder, scenes) = (self.folder.path().join("changed/course"), self.folder.path().join("changed/scenes"));
        for (from, to) in [(course_folder(), &folder), (course_folder().join("../scenes"), &scenes)] {
            std::fs::create_dir_all(to).unwrap();
            for file in std::fs::read_dir(from).unwrap() {
                let file = file.unwrap();
                std::fs::copy(file.path(), to.join(file.file_name())).unwrap();
            }
        }
        let exercise = folder.join("1-feel-the-layers.toml");
        let text = std::fs::read_to_string(&exercise).unwrap();
        let line = text.lines().find(|line| line.starts_with("pass_mark")).unwrap().to_owned();
        std::fs::write(&exercise, text.replace(&line, &format!("pass_mark = {pass_mark}"))).unwrap();
        let (now, course) = (self.state.clock.now(), folder.join("course.toml"));
        self.write(async |tx| publishing::course(tx, school, &course, now).await.unwrap()).await;
    }

    /// A client without anything.
    pub fn stranger(&self) -> Client {
        Client::new(self.router.clone())
    }

    /// A client with a token.
    pub fn with_token(&self, token: &str) -> Client {
        let mut client = self.stranger();
        client.token = Some(token.to_owned());
        client
    }

    /// A client that has signed in through the form.
    pub async fn signed_in(&self, email: &str) -> Client {
        let mut client = self.stranger();
        let answer = client.sign_in(email, PASSWORD).await;
        assert_eq!(answer.status, 303, "{}", answer.text());
        client
    }

    /// Lets a school keep the clock of a time zone.
    pub async fn keep_time_zone(&self, school: SchoolId, zone: &str) {
        let settled = schools::find_school_settings(self.state.db.reader(), school).await.unwrap();
        let settled = SchoolSettings { time_zone: zone.to_owned(), ..settled };
        assert!(self.write(async |tx| schools::put_school_settings(tx, school, &settled).await.unwrap()).await);
    }

    /// Every file in the recordings folder and below, relative to it.
    pub fn files(&self) -> Vec<PathBuf> {
        let root = &self.state.config.recordings_dir;
        let mut found = Vec::new();
        let mut open = vec![root.clone()];
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { open.push(path) } else { found.push(path.strip_prefix(root).unwrap().to_owned()) }
            }
        }
        found
    }
}
