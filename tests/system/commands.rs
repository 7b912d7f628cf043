//! Every `stylet …` and `web-admin …` command that a page names is one that the program's own parser takes, as far as its flags and their
//! values. Fails when a page names a command, a flag or a value that is gone. What a command does is shown elsewhere.

use std::process::Command;

use tests::{pages, program, root, run_ok};

const PROGRAMS: [&str; 2] = ["stylet", "web-admin"];

/// Whether a text begins with a program of ours and a word behind it.
fn is_command(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let is_ours = words.next().is_some_and(|word| PROGRAMS.contains(&word.trim_start_matches("target/release/")));
    is_ours && words.next().is_some_and(|word| !["#", "=", "|"].contains(&word))
}

/// The commands of a page: lines of its blocks, joined where they go on, and what stands between backticks in its sentences.
fn named_commands(text: &str) -> Vec<String> {
    let level = text.lines().map(|line| if line.trim_start().starts_with("```") { line.trim_start() } else { line });
    let text = level.collect::<Vec<_>>().join("\n");
    let parts: Vec<&str> = text.split("\n```").collect();
    let blocks = parts.iter().skip(1).step_by(2).filter(|block| block.starts_with("sh\n"));
    let lines = blocks.flat_map(|block| {
        let joined = block.replace("\\\n", " ");
        joined.lines().map(|line| line.trim().to_owned()).collect::<Vec<_>>()
    });
    let sentences = parts.iter().step_by(2).flat_map(|prose| prose.split('`').skip(1).step_by(2));
    let quoted = sentences.map(|words| words.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.chain(quoted).filter(|text| is_command(text)).filter(|text| !text.contains('…')).collect()
}

/// Words of pages that stand for a value which the parser looks at.
const STANDS_FOR: [(&str, &str); 2] = [
    (" URL", " https://training.example.org"),
    (" HASH", " 0000000000000000000000000000000000000000000000000000000000000000"),
];

/// Asks the parser: with `--help` behind it a command is read up to its last flag, and nothing is done or missed.
fn complaint(command: &str) -> Option<String> {
    let told = PROGRAMS.map(|name| format!("{name}() {{ '{}' \"$@\" --help >&3; }}", program(name).display()));
    let filled = STANDS_FOR.iter().fold(command.to_owned(), |text, (word, value)| text.replace(word, value));
    let script =
        format!("set -f; exec 3>/dev/null; {}; {}", told.join("; "), filled.trim_start_matches("target/release/"));
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new("bash").args(["-c", &script]).current_dir(folder.path()).output().expect("bash runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (!output.status.success() || !said.is_empty()).then_some(said)
}

#[test]
fn every_command_on_a_page_is_accepted_by_the_program() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for page in pages().into_iter().filter(|page| page != "CHANGELOG.md") {
        let text = std::fs::read_to_string(root().join(&page)).expect("a readable page");
        for command in named_commands(&text) {
            count += 1;
            wrong.extend(complaint(&command).map(|said| format!("{page}: {command}\n{said}")));
        }
    }
    assert!(count > 60, "only {count} commands were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_option_of_the_service_is_explained() {
    let page = std::fs::read_to_string(root().join("docs/operate.md")).expect("docs/operate.md");
    let help = run_ok("web-admin", &["serve", "--help"]);
    let words = help.split_whitespace().map(|word| word.trim_end_matches([',', '.', ';']));
    let options: Vec<&str> = words.filter(|word| word.starts_with("--")).collect();
    assert!(options.len() > 15, "the help is read: {options:?}");
    let asks_for_help = |option: &&&str| ["--help", "--version"].contains(*option);
    let known = |option: &str| [" ", "`"].iter().any(|end| page.contains(&format!("`{option}{end}")));
    let missing: Vec<_> = options.iter().filter(|option| !asks_for_help(option) && !known(option)).collect();
    assert!(missing.is_empty(), "docs/operate.md does not explain {missing:?}");
}

#[test]
fn what_the_parser_refuses_is_found() {
    assert!(complaint("stylet simulate x.toml --operator expert --out y.mcap").is_none());
    assert!(complaint("stylet simulate x.toml --no-such-flag").is_some());
    assert!(complaint("web-admin serve --judges many").is_some());
    assert!(complaint("web-admin no-such-command").is_some());
    let text = "As `stylet check FILE…` and\n`web-admin\nverify`, not `stylet`:\n```sh\nstylet a \\\n    b\nls\n```\n`stylet c`\n";
    assert_eq!(named_commands(text), ["stylet a      b", "web-admin verify", "stylet c"]);
}
