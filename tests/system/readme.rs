//! Every command of the README and of the pages that it leads to, in their order, in a folder that holds nothing but what is shipped.
//! Fails when one does not do its work as it stands there, and when a command is added that neither runs nor is listed below with
//! the reason.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;
use tests::{Service, program, root};

/// The pages, in the order in which somebody follows them.
const PAGES: [&str; 6] =
    ["README.md", "docs/station.md", "docs/simulate.md", "docs/operate.md", "docs/measurements.md", "docs/recipes.md"];

/// Commands that are not run, by their beginnings, each with the reason.
const SKIPPED: [(&str, &str); 25] = [
    ("deploy/run", "builds for minutes, and serves until it is stopped"),
    ("deploy/test", "runs this"),
    ("deploy/windows", "changes the machine, and builds for minutes"),
    ("deploy/cluster", "as deploy/run: tests/system/cluster.rs"),
    ("STYLET_PUBLIC_URL=", "as podman"),
    ("kubectl ", "asks for a cluster: tests/system/cluster.rs"),
    ("sudo ", "changes the machine"),
    ("podman ", "asks for images of another machine"),
    ("cargo run --release --workspace --bin soak", "takes an hour"),
    ("STYLET_UPDATE_", "makes files of the tree anew"),
    ("stylet bench all", "measures for hours"),
    ("web-admin bench", "measures for hours"),
    ("tests/peers/run", "measures for hours"),
    ("createdb ", "asks for a server of PostgreSQL: web-admin/tests/main/support/postgres.rs"),
    ("STYLET_DATABASE=postgres", "as createdb"),
    ("pg_dump ", "as createdb: web-admin/tests/main/operations/dumps.rs"),
    ("pg_restore ", "as createdb"),
    ("web-admin move", "as createdb: web-admin/tests/main/operations/moving.rs"),
    ("stylet pair", "asks a school for a code: tests/system/station.rs"),
    ("stylet outbox send --watch", "goes on until it is stopped: tests/system/station.rs"),
    ("cargo build", "builds for minutes: the programs beside this test are taken"),
    (PLAY, "opens a window: tests/system/window.rs"),
    ("stylet replay", "opens a window: tests/system/window.rs"),
    ("stylet render attempt.mcap --frames", "draws hundreds of pictures: minutes without a graphics card"),
    ("web-admin certificate verify", "asks for a mastered course: tests/system/other_programs.rs"),
];

/// The command that leaves the recordings of which the next ones speak.
const PLAY: &str = "stylet play";
/// What it leaves.
const PLAYED: [&str; 2] = ["attempt.mcap", "expert.mcap"];
/// The command that runs until it is stopped, while the next ones speak to it.
const SERVE: &str = "web-admin serve --data-dir school";
/// Where it listens when nobody says.
const ADDRESS: &str = "127.0.0.1:8080";
/// Commands whose findings are about the machine: done with 0 or 1.
const FINDS: [&str; 1] = ["stylet doctor"];

/// The commands of a text, block by block; one that goes on in the next line is one.
fn blocks(text: &str) -> Vec<Vec<String>> {
    let fenced = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let commands = |block: &str| {
        let joined = block.replace("\\\n", "\u{0}");
        let lines = joined.lines().map(str::trim).filter(|line| !line.is_empty());
        lines.map(|line| line.replace('\u{0}', "\\\n")).collect()
    };
    fenced.map(commands).collect()
}

/// Somebody at a terminal.
struct Reader {
    folder: TempDir,
    aliases: Vec<String>,
    service: Option<Service>,
}

impl Reader {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        for shipped in ["curricula", "tests"] {
            symlink(root().join(shipped), at(shipped)).expect("what is shipped");
        }
        std::fs::create_dir(at("target")).expect("a folder");
        let built = program("stylet");
        symlink(built.parent().expect("a folder"), at("target/release")).expect("what is built");
        Self { folder, aliases: Vec::new(), service: None }
    }

    /// Does what stands in a block.
    fn follow(&mut self, block: &[String]) -> Vec<&'static str> {
        let mut skipped = Vec::new();
        for command in block {
            if let Some((beginning, _)) = SKIPPED.iter().find(|(beginning, _)| command.starts_with(beginning)) {
                skipped.push(*beginning);
                if *beginning == PLAY {
                    PLAYED.iter().for_each(|name| self.leave(name));
                }
            } else if command.starts_with("alias ") {
                self.aliases.push(command.clone());
            } else if command.starts_with(SERVE) {
                self.service = Some(Service::start(&self.folder.path().join("school")));
            } else {
                self.put_away(command);
                self.run(command);
            }
        }
        skipped
    }

    /// A recording as somebody who plays would leave it.
    fn leave(&self, name: &str) {
        let (exercise, out) = (tests::first_exercise(), self.folder.path().join(name));
        let operator = ["--operator", "constant:10", "--seed", "1", "--out"];
        tests::run_ok("stylet", &[&["simulate", &exercise], &operator[..], &[&out.to_string_lossy()]].concat());
    }

    /// Whoever makes a recording has none of that name: only what was left in place of playing is put away for it.
    fn put_away(&self, command: &str) {
        for name in PLAYED.iter().filter(|name| command.contains(&format!("--out {name}"))) {
            std::fs::remove_file(self.folder.path().join(name)).expect("it was left");
        }
    }

    fn run(&self, command: &str) {
        let address = self.service.as_ref().map(|service| service.url.trim_start_matches("http://").to_owned());
        let told = address.map_or_else(|| command.to_owned(), |address| command.replace(ADDRESS, &address));
        // What follows an alias's own line is read with it.
        let script = format!("shopt -s expand_aliases\n{}\n{told}\n", self.aliases.join("\n"));
        let own = |name: &str| self.folder.path().join("home").join(name);
        let output = Command::new("bash")
            .args(["-e", "-o", "pipefail", "-c", &script])
            .current_dir(self.folder.path())
            .envs([("XDG_DATA_HOME", own("data")), ("XDG_CONFIG_HOME", own("config"))])
            .env_remove("STYLET_TOKEN")
            .env_remove("STYLET_OUTBOX")
            .output()
            .expect("bash runs");
        let finds = FINDS.iter().any(|beginning| command.starts_with(beginning));
        let done = output.status.success() || (finds && output.status.code() == Some(1));
        let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        assert!(done, "{command}\nended with {}:\n{said}{complained}", output.status);
    }

    fn has(&self, name: &str) -> bool {
        let length = |path: &Path| std::fs::metadata(path).map_or(0, |found| found.len());
        length(&self.folder.path().join(name)) > 0
    }
}

#[test]
fn every_command_of_the_pages_does_its_work() {
    let read = |page: &&str| std::fs::read_to_string(root().join(page)).expect("a page");
    let blocks: Vec<_> = PAGES.iter().map(read).flat_map(|text| blocks(&text)).collect();
    let commands: usize = blocks.iter().map(Vec::len).sum();
    assert!(blocks.len() > 5 && commands > 25, "only {commands} commands in {} blocks were found", blocks.len());
    let mut reader = Reader::new();
    let skipped: Vec<&str> = blocks.iter().flat_map(|block| reader.follow(block)).collect();
    for (beginning, _) in SKIPPED {
        assert!(skipped.contains(&beginning), "{beginning} no longer stands in the pages");
    }
    for made in ["pop.png", "mine.toml", "token", "school.tar", "elsewhere/stylet.db"] {
        assert!(reader.has(made), "{made} was not made");
    }
}

#[test]
fn commands_are_found_as_they_are_typed() {
    let text = "# A\n```sh\na b   # why\n\nc \\\n    d\n```\n```toml\nx = 1\n```\n```sh\ne\n```\n";
    assert_eq!(blocks(text), [vec!["a b   # why".to_owned(), "c \\\n    d".to_owned()], vec!["e".to_owned()]]);
}
