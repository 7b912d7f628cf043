//! What starts several services: deploy/cluster, deploy/compose.yaml and deploy/kubernetes. Fails when a linter of its kind refuses one, when an
//! option or a variable in it is none of the program's, or when ports, paths, accounts and times that must agree do not.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use acts::operations::key_files::KEYS;
use tests::{Service, root, run_ok};

const MANIFESTS: [&str; 5] = ["namespace.yaml", "config.yaml", "replicas.yaml", "workers.yaml", "ingress.yaml"];

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).expect(path)
}

fn manifest(name: &str) -> String {
    text(&format!("deploy/kubernetes/{name}"))
}

/// Everything by which several services are started, by its path.
fn starters() -> Vec<(String, String)> {
    let manifests = MANIFESTS.map(|name| format!("deploy/kubernetes/{name}"));
    let paths = ["deploy/cluster", "deploy/compose.yaml"].map(str::to_owned).into_iter().chain(manifests);
    paths.map(|path| (path.clone(), text(&path))).collect()
}

/// Has a linter look at files, named from the root of the tree; it is one of `tests/python/requirements.txt`, or of the system.
#[expect(clippy::print_stderr, reason = "whoever runs the tests is told what was not tried")]
fn lint(program: &str, arguments: &[&str]) {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let beside = root().join(python).with_file_name(program);
    let program = if beside.exists() { beside } else { PathBuf::from(program) };
    let environment = [("BIND", "127.0.0.1:1"), ("REPLICA_1", "127.0.0.1:2"), ("REPLICA_2", "127.0.0.1:3")];
    let path = format!("{}:/usr/sbin", std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new(&program);
    match command.args(arguments).env("PATH", path).envs(environment).current_dir(root()).output() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            eprintln!("not tried: {} is not installed; deploy/test installs it", program.display());
        }
        output => {
            let output = output.expect("a linter starts");
            let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{} {arguments:?}: {said}", program.display());
        }
    }
}

#[test]
fn linters_of_their_kind_refuse_none() {
    let scripts = [
        "deploy/bridge",
        "deploy/cargo-for-tests",
        "deploy/cluster",
        "deploy/lib.sh",
        "deploy/lint-then-compile",
        "deploy/run",
        "deploy/test",
        "deploy/test-servers",
        "deploy/try-sign-in",
        "deploy/wheel",
        "tests/counterparts/run",
    ];
    for script in scripts {
        lint("bash", &["-n", script]);
    }
    lint("shellcheck", &[&["-x", "-P", "."][..], &scripts].concat());
    lint("yamllint", &["-s", "-c", "deploy/.yamllint", "deploy"]);
    lint("check-jsonschema", &["--builtin-schema", "vendor.compose-spec", "deploy/compose.yaml"]);
    let manifests = MANIFESTS.map(|name| format!("deploy/kubernetes/{name}"));
    let manifests: Vec<&str> = manifests.iter().map(String::as_str).collect();
    lint("kubernetes-validate", &[&["--strict"][..], &manifests].concat());
    lint("kubectl", &["kustomize", "deploy/kubernetes"]);
    lint("haproxy", &["-c", "-f", "deploy/haproxy.cfg"]);
}

/// Words of a text that begin so, and go on with what names are made of.
fn words<'a>(text: &'a str, begin: &str) -> BTreeSet<&'a str> {
    let of_name = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    text.match_indices(begin)
        .filter(|(at, _)| !text[..*at].ends_with(of_name))
        .map(|(at, _)| text[at..].split(|c| !of_name(c)).next().unwrap_or_default())
        .filter(|word| word.len() > begin.len())
        .collect()
}

/// Lines that call the program, as what it is called for and the whole line.
fn calls(text: &str) -> Vec<(&str, &str)> {
    let lines = text.lines().filter_map(|line| {
        let behind = line.split_once("\"$program\" ").or_else(|| line.split_once("[web-admin, "))?.1;
        Some((behind.split([' ', ',', ']']).next()?, behind.split('>').next()?))
    });
    lines.collect()
}

#[test]
fn every_option_and_variable_is_one_of_the_program() {
    let help = run_ok("web-admin", &["serve", "--help"]);
    let variables: BTreeSet<&str> = words(&help, "STYLET_");
    assert!(variables.len() > 10, "the help is read: {variables:?}");
    let mut called = BTreeSet::new();
    for (path, text) in starters() {
        for variable in words(&text, "STYLET_") {
            assert!(variables.contains(variable), "{path}: {variable} is no variable of web-admin serve");
        }
        for (command, line) in calls(&text) {
            let help = run_ok("web-admin", &[command, "--help"]);
            let known = words(&help, "--");
            let unknown: Vec<_> = words(line, "--").into_iter().filter(|option| !known.contains(option)).collect();
            assert!(unknown.is_empty(), "{path}: {unknown:?} are no options of web-admin {command}");
            called.insert((path.clone(), command.to_owned()));
        }
    }
    let served = |command: &str| called.iter().filter(|(_, called)| called == command).count();
    assert_eq!((served("serve"), served("work")), (3, 3), "the calls are found: {called:?}");
}

/// The number behind the first of some words.
fn number_behind(text: &str, words: &str) -> u32 {
    let behind = text.split_once(words).unwrap_or_else(|| panic!("{words} is not there")).1;
    let digits = behind.trim_start_matches([' ', '"', ',', ':', '=']);
    digits.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default().parse().expect(words)
}

#[test]
fn what_must_agree_does() {
    let (container, compose) = (text("deploy/Containerfile"), text("deploy/compose.yaml"));
    let (replicas, workers, config) = (manifest("replicas.yaml"), manifest("workers.yaml"), manifest("config.yaml"));
    let port = number_behind(&container, "STYLET_LISTEN=0.0.0.0:");
    assert_eq!(number_behind(&replicas, "containerPort:"), port);
    for replica in ["REPLICA_1: replica-1:", "REPLICA_2: replica-2:", "/dev/tcp/127.0.0.1/"] {
        assert_eq!(number_behind(&compose, replica), port, "{replica}");
    }
    let account = number_behind(&container, "--uid");
    for manifest in [&replicas, &workers] {
        for who in ["runAsUser:", "runAsGroup:", "fsGroup:"] {
            assert_eq!(number_behind(manifest, who), account, "{who}");
        }
        assert!(manifest.contains("mountPath: /keys,") && config.contains("STYLET_KEYS: /keys\n"));
        assert!(manifest.contains("mountPath: /data}") && container.contains("STYLET_DATA_DIR=/data "));
        assert!(manifest.contains("readOnlyRootFilesystem: true") && manifest.contains("drop: [ALL]"));
    }
    let applied = manifest("kustomization.yaml");
    assert!(MANIFESTS.iter().all(|name| applied.contains(&format!("  - {name}\n"))), "{applied}");
    for key in KEYS {
        assert!(compose.contains(&format!("  {0}: {{file: secrets/{0}}}", key.name)), "{} is no secret", key.name);
    }
    // Whoever leaves is left by the proxy first, and has ten seconds for what is under way.
    let patience = [("stop_grace_period:", &compose), ("terminationGracePeriodSeconds:", &replicas)];
    for (patience, text) in patience {
        assert!(number_behind(text, patience) > number_behind(text, "--leave-s, ") + 10, "{patience}");
    }
}

#[test]
fn the_addresses_that_are_asked_are_answered() {
    let folder = tempfile::tempdir().expect("a folder");
    let service = Service::start(folder.path());
    let asked: BTreeSet<String> = [text("deploy/haproxy.cfg"), text("deploy/compose.yaml"), manifest("replicas.yaml")]
        .iter()
        .flat_map(|text| text.split_whitespace().map(|word| word.trim_matches(['\'', ',', '"']).to_owned()))
        .filter(|word| word.starts_with('/') && word.ends_with('z'))
        .collect();
    assert_eq!(asked.len(), 2, "{asked:?}");
    for path in asked {
        let answer = ureq::get(format!("{}{path}", service.url.trim_end_matches('/'))).call().expect("an answer");
        assert_eq!(answer.status(), 200, "{path}");
    }
}
