//! The service's log goes to another machine as `deploy/ship-log.conf` and `deploy/collect-log.conf` say. Fails when an entry does not
//! arrive, when it arrives changed, when somebody else's entries are taken, or when it is sent to somebody else.

use std::fs;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use tests::root;

const COLLECTOR: &str = "log.example.org";
const SENDER: &str = "stylet.example.org";
const OTHER: &str = "other.example.org";

/// Longest wait for what must come.
const PATIENCE: Duration = Duration::from_secs(60);
/// Ports that are tried.
const TRIES: u32 = 4;
/// What rsyslog says of another machine than it may speak to.
const REFUSED: &str = "peer name not authorized";

fn done(command: &mut Command) {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn openssl(folder: &Path, words: &str) {
    done(Command::new("openssl").args(words.split_whitespace()).current_dir(folder));
}

/// Whether something comes true while it is waited for.
fn soon(patience: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let step = Duration::from_millis(100);
    (0..patience.as_millis() / step.as_millis()).any(|_| {
        is_so() || {
            sleep(step);
            false
        }
    })
}

/// A CA, and a certificate of it for each machine.
fn certify(folder: &Path) {
    openssl(folder, "req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -days 2 -subj /CN=ca");
    for name in [COLLECTOR, SENDER, OTHER] {
        fs::write(folder.join("names"), format!("subjectAltName=DNS:{name}")).expect("a file");
        openssl(folder, &format!("req -newkey rsa:2048 -nodes -keyout {name}.key -out request -subj /CN={name}"));
        openssl(
            folder,
            &format!(
                "x509 -req -in request -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names -out {name}.pem"
            ),
        );
    }
}

/// An rsyslog by one of the shipped files, killed when dropped.
struct Logger {
    child: Child,
    /// Its own words.
    complaints: PathBuf,
}

impl Logger {
    fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Waits until it has refused the other machine.
    fn refuses(&self) {
        let refused = || fs::read_to_string(&self.complaints).is_ok_and(|words| words.contains(REFUSED));
        assert!(soon(PATIENCE, refused), "{} refuses nobody", self.complaints.display());
    }
}

impl Drop for Logger {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The two machines, both here.
struct Place<'a> {
    folder: &'a Path,
    port: u16,
}

impl Place<'_> {
    /// Starts rsyslog with a shipped file, its places and this machine's name changed, behind what `before` says.
    fn start(&self, file: &str, name: &str, before: &str) -> Logger {
        let at = |name: &str| self.folder.join(name).to_string_lossy().into_owned();
        let text = fs::read_to_string(root().join("deploy").join(file)).expect("a shipped file");
        let changes = [
            ("/etc/stylet/log/ca.pem", at("ca.pem")),
            ("/etc/stylet/log/certificate.pem", at(&format!("{name}.pem"))),
            ("/etc/stylet/log/key.pem", at(&format!("{name}.key"))),
            ("\"6514\"", format!("\"{}\"", self.port)),
            ("/var/log/stylet.log", at("kept")),
            ("target=\"log.example.org\"", "target=\"127.0.0.1\"".to_owned()),
        ];
        let text = changes.iter().fold(text, |text, (from, to)| text.replace(from, to));
        let own = self.folder.join(format!("{name}-{file}"));
        let work = own.with_extension("work");
        fs::create_dir_all(&work).expect("a folder");
        fs::write(&own, format!("global(workDirectory=\"{}\")\n{before}\n{text}", work.display())).expect("a file");
        done(Command::new("rsyslogd").arg("-N1").arg("-f").arg(&own));
        let complaints = own.with_extension("complaints");
        let mut command = Command::new("rsyslogd");
        command.args(["-n", "-i"]).arg(own.with_extension("pid")).arg("-f").arg(&own).stdout(Stdio::null());
        let child = command.stderr(fs::File::create(&complaints).expect("a file")).spawn().expect("rsyslogd starts");
        Logger { child, complaints }
    }

    /// The machine that keeps, under a name, once it listens. Where another program has taken the port meanwhile, another port.
    fn collector(&mut self, name: &str) -> Logger {
        for _ in 0..TRIES {
            let mut logger = self.start("collect-log.conf", name, "");
            if soon(PATIENCE / TRIES, || TcpStream::connect(("127.0.0.1", self.port)).is_ok()) && logger.is_running() {
                return logger;
            }
            self.port = free_port();
        }
        panic!("the collector does not listen");
    }

    /// The machine that serves, under a name; where its programs write to.
    fn sender(&self, name: &str) -> (Logger, PathBuf) {
        let socket = self.folder.join(format!("{name}.socket"));
        let before = format!(
            "module(load=\"imuxsock\" SysSock.Use=\"off\")\ninput(type=\"imuxsock\" Socket=\"{}\")",
            socket.display()
        );
        (self.start("ship-log.conf", name, &before), socket)
    }

    fn kept(&self) -> String {
        fs::read_to_string(self.folder.join("kept")).unwrap_or_default()
    }

    /// What was kept, once there is anything, or when there should have been.
    fn kept_soon(&self) -> String {
        soon(PATIENCE, || !self.kept().is_empty());
        self.kept()
    }
}

/// Writes an entry as the journal passes it on.
fn write(socket: &Path, program: &str, entry: &str) {
    assert!(soon(PATIENCE, || socket.exists()), "nothing listens for entries");
    done(Command::new("logger").arg("-u").arg(socket).args(["-t", program, "--", entry]));
}

fn free_port() -> u16 {
    let free = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    free.local_addr().expect("an address").port()
}

#[test]
fn log_entry_travels_only_between_the_certified_machines() {
    if Command::new("rsyslogd").arg("-v").output().is_err() {
        eprintln!("not tried: rsyslogd is not installed; deploy/test installs it");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    certify(folder.path());
    let entry = r#"{"level":"WARN","message":"request refused: no access, or not found","route":"/people/{id}","from":"10.0.0.1"}"#;
    let mut place = Place { folder: folder.path(), port: free_port() };
    let collector = place.collector(COLLECTOR);
    // Of the same CA, and not the machine that serves.
    let (stranger, socket) = place.sender(OTHER);
    write(&socket, "web-admin", "forged");
    collector.refuses();
    let (sender, socket) = place.sender(SENDER);
    write(&socket, "sshd", "of another program");
    write(&socket, "web-admin", entry);
    assert_eq!(place.kept_soon(), format!("{entry}\n"), "somebody else's entry is kept");
    drop((stranger, sender, collector));

    // Whoever stands where the other machine should is told nothing.
    let mut place = Place { folder: &folder.path().join("second"), port: free_port() };
    fs::create_dir(place.folder).expect("a folder");
    certify(place.folder);
    let _impostor = place.collector(OTHER);
    let (sender, socket) = place.sender(SENDER);
    write(&socket, "web-admin", entry);
    sender.refuses();
    assert_eq!(place.kept(), "", "it was sent to another machine");
}
