//! The simulator's window, opened for real on a virtual display and driven by a virtual operator and by keys: an attempt must come
//! to a recording that scores and re-simulates, whatever becomes of the program. Fails when the window shows nothing, when an attempt
//! does not end by itself, when a killed program loses more than the last second, or when a full disk, a key or the window's close
//! button loses anything.

use std::collections::BTreeSet;
use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use recording::{EventKind, Recording};
use serde_json::Value;
use tests::{first_exercise, program, root, run_ok};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ClientMessageEvent, ConnectionExt, EventMask, ImageFormat};

/// What ends the name of an attempt that is being recorded.
pub const DRAFT: &str = "stylet-part";
/// The page before an attempt has some hundreds, a drawn needle tens of thousands.
const MOST_COLOURS_OF_TEXT: usize = 2000;
/// A cursor in a text has fewer pixels, and the frame of a field that is chosen more.
const MOST_OF_A_CURSOR: usize = 120;
/// So many looks at the screen, ten a second, find the same picture where nothing is under way.
const STILL: usize = 10;
/// One window at a time: each is drawn by as many threads as there are cores.
static ONE_WINDOW: Mutex<()> = Mutex::new(());

/// A virtual display, ended when dropped.
pub struct Display {
    server: Child,
    number: String,
    _alone: MutexGuard<'static, ()>,
}

impl Display {
    pub fn open() -> Self {
        let alone = ONE_WINDOW.lock().unwrap_or_else(PoisonError::into_inner);
        let mut server = Command::new("Xvfb")
            // It would begin anew when the last client goes, which may be a look at the screen.
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is installed by deploy/test");
        let mut number = String::new();
        let mut pipe = server.stdout.take().expect("a pipe");
        let mut byte = [0];
        while pipe.read(&mut byte).expect("Xvfb names its display") == 1 && byte != *b"\n" {
            number.push(char::from(byte[0]));
        }
        Self { server, number: format!(":{number}"), _alone: alone }
    }

    /// Starts `stylet` on the display.
    fn stylet(&self, arguments: &[&str]) -> Child {
        self.start(Command::new(program("stylet")).args(arguments))
    }

    /// Starts a program on the display.
    pub fn start(&self, command: &mut Command) -> Child {
        let command = command.current_dir(root()).env("DISPLAY", &self.number).env_remove("WAYLAND_DISPLAY");
        command.spawn().expect("it starts")
    }

    /// Starts a program, and waits until its window is drawn.
    #[track_caller]
    pub fn open_window(&self, command: &mut Command) -> Child {
        let mut program = None;
        self.and_settles(|| program = Some(self.start(command)));
        program.expect("it was started")
    }

    /// Presses a key once the window is there.
    pub fn press(&self, key: &str) {
        self.on_window(&["key", key]);
    }

    /// Begins an attempt, as often as it takes: a key may come before the window listens. Gives the attempt's draft.
    #[track_caller]
    pub fn begin_attempt(&self, kept: &Path) -> PathBuf {
        within(60, "an attempt", || {
            self.press("Return");
            with_extension(kept, DRAFT)
        })
    }

    /// Waits until there is more than a page of text to be seen.
    #[track_caller]
    pub fn wait_for_picture(&self) {
        let colours = || self.screen().into_iter().collect::<BTreeSet<_>>().len();
        within(60, "a picture", || Some(()).filter(|()| colours() > MOST_COLOURS_OF_TEXT));
    }

    /// Does something at the window, and waits until it shows what comes of it: another picture, which then stays.
    #[track_caller]
    pub fn and_settles(&self, act: impl FnOnce()) {
        let before = self.screen();
        act();
        let mut last = within(60, "another picture", || Some(self.screen()).filter(|now| differs(now, &before)));
        let mut still = 0;
        within(60, "a picture that stays", || {
            let now = self.screen();
            still = if differs(&now, &last) { 0 } else { still + 1 };
            last = now;
            Some(()).filter(|()| still >= STILL)
        });
    }

    /// Types a text once the window is there.
    pub fn write(&self, text: &str) {
        self.on_window(&["type", text]);
    }

    #[track_caller]
    fn on_window(&self, then: &[&str]) {
        let window = self.window();
        let done = self.tool("xdotool", &[&["windowfocus", "--sync", &*window], then].concat());
        assert!(done.is_some(), "{then:?} could not be done");
    }

    fn window(&self) -> String {
        let search = || self.tool("xdotool", &["search", "--onlyvisible", "--name", "Stylet"]);
        let found = within(120, "a window", || search().filter(|found| !found.trim().is_empty()));
        found.lines().next().unwrap_or_default().to_owned()
    }

    /// Asks the window to close, as the button in its frame does: there is no window manager here to press it.
    pub fn close(&self) {
        let window = self.window().parse().expect("a window's number");
        let (server, _) = x11rb::connect(Some(&self.number)).expect("the display");
        let [protocols, delete] = [&b"WM_PROTOCOLS"[..], b"WM_DELETE_WINDOW"].map(|name| {
            let asked = server.intern_atom(false, name).expect("a request");
            asked.reply().expect("an answer").atom
        });
        let message = ClientMessageEvent::new(32, window, protocols, [delete, x11rb::CURRENT_TIME, 0, 0, 0]);
        server.send_event(false, window, EventMask::NO_EVENT, message).expect("a request").check().expect("sent");
        server.flush().expect("sent");
    }

    /// What a tool prints, if it succeeds.
    fn tool(&self, name: &str, arguments: &[&str]) -> Option<String> {
        let output = Command::new(name).args(arguments).env("DISPLAY", &self.number).output().expect("installed");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// The colour of each pixel of the screen.
    fn screen(&self) -> Vec<[u8; 4]> {
        let (server, number) = x11rb::connect(Some(&self.number)).expect("the display");
        let screen = &server.setup().roots[number];
        let (width, height) = (screen.width_in_pixels, screen.height_in_pixels);
        let asked = server.get_image(ImageFormat::Z_PIXMAP, screen.root, 0, 0, width, height, u32::MAX);
        let picture = asked.expect("a request").reply().expect("a picture of the screen");
        picture.data.as_chunks().0.to_vec()
    }
}

/// Whether two pictures of the screen differ in more than a cursor that blinks.
fn differs(one: &[[u8; 4]], other: &[[u8; 4]]) -> bool {
    one.iter().zip(other).filter(|(one, other)| one != other).count() > MOST_OF_A_CURSOR
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Asks until there is an answer, for so many seconds.
#[track_caller]
pub fn within<T>(seconds: u64, what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    for _ in 0..seconds * 10 {
        if let Some(answer) = ask() {
            return answer;
        }
        sleep(Duration::from_millis(100));
    }
    panic!("{what} did not come within {seconds} s");
}

pub fn with_extension(folder: &Path, extension: &str) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    entries.filter(|path| path.extension().is_some_and(|found| found == extension)).max()
}

fn score(recording: &Path) -> Value {
    let told = run_ok("stylet", &["score", &recording.to_string_lossy(), "--json"]);
    serde_json::from_str(&told).expect("JSON")
}

#[test]
fn attempt_in_the_window_ends_by_itself_and_is_recorded() {
    let (display, folder) = (Display::open(), tempfile::tempdir().expect("a folder"));
    let kept = folder.path().to_string_lossy().into_owned();
    let mut play =
        display.stylet(&["play", &first_exercise(), "--device", "operator:constant:10", "--recordings", &kept]);
    display.begin_attempt(folder.path());
    display.wait_for_picture();
    let recording = within(60, "the recording", || with_extension(folder.path(), "mcap"));
    assert!(with_extension(folder.path(), DRAFT).is_none(), "the draft has its name");
    let value = score(&recording);
    assert!(value["score"].as_f64().is_some_and(|score| score > 0.0), "{value}");
    let verified = run_ok("stylet", &["verify", &recording.to_string_lossy(), "--json"]);
    let verified: Value = serde_json::from_str(&verified).expect("JSON");
    assert_eq!(verified["largest_deviation_n"], 0.0, "it re-simulates to the bit: {verified}");
    let _ = play.kill();
    let _ = play.wait();
}

#[test]
fn recording_of_a_killed_program_is_recovered_at_next_start() {
    let (display, folder) = (Display::open(), tempfile::tempdir().expect("a folder"));
    let kept = folder.path().to_string_lossy().into_owned();
    let arguments = ["play", &first_exercise(), "--device", "operator:constant:1", "--recordings", &kept];
    let mut play = display.stylet(&arguments);
    display.begin_attempt(folder.path());
    sleep(Duration::from_secs(4));
    play.kill().expect("killed");
    play.wait().expect("gone");
    let mut again = display.stylet(&arguments);
    let recording = within(30, "the recovered recording", || with_extension(folder.path(), "mcap"));
    let metrics = score(&recording)["metrics"].as_array().cloned().unwrap_or_default();
    let total =
        metrics.iter().find(|metric| metric["id"] == "time_total_s").and_then(|metric| metric["value"].as_f64());
    assert!(total.is_some_and(|total_s| total_s > 3.0), "{total:?} s of four or more were kept");
    let _ = again.kill();
    let _ = again.wait();
}

/// What the disk takes of a file before it is full, in blocks of 512 bytes.
const ROOM_BLOCKS: u64 = 200;

/// A program has a thread of this name.
fn has_thread(program: &Child, name: &str) -> bool {
    let tasks = fs::read_dir(format!("/proc/{}/task", program.id())).expect("it runs").flatten();
    tasks.filter_map(|task| fs::read_to_string(task.path().join("comm")).ok()).any(|found| found.trim() == name)
}

#[test]
fn attempt_on_a_full_disk_is_kept_until_it_is_saved() {
    let (display, folder) = (Display::open(), tempfile::tempdir().expect("a folder"));
    let kept = folder.path().to_string_lossy().into_owned();
    let full = format!("trap '' XFSZ; ulimit -S -f {ROOM_BLOCKS}; exec \"$@\"");
    let exercise = first_exercise();
    let arguments = ["play", &exercise, "--device", "operator:constant:10", "--recordings", &kept];
    let mut play = display.start(Command::new("sh").args(["-c", &full, "sh"]).arg(program("stylet")).args(arguments));
    let draft = display.begin_attempt(folder.path());
    within(60, "the servo", || has_thread(&play, "servo").then_some(()));
    within(60, "the end", || (!has_thread(&play, "servo")).then_some(()));
    assert!(fs::metadata(&draft).is_ok_and(|file| file.len() <= 512 * ROOM_BLOCKS), "the disk was meant to be full");
    for _ in 0..3 {
        ["r", "Escape", "s"].iter().for_each(|key| display.press(key));
        sleep(Duration::from_millis(500));
    }
    for _ in 0..2 {
        display.close();
        sleep(Duration::from_secs(1));
        assert!(
            play.try_wait().expect("its state").is_none(),
            "a window does not close on an attempt that is not on disk"
        );
    }
    assert!(with_extension(folder.path(), "mcap").is_none(), "nothing half written has a recording's name");

    let id = play.id().to_string();
    assert!(Command::new("prlimit").args(["--pid", &id, "--fsize=unlimited"]).status().is_ok_and(|s| s.success()));
    let recording = within(60, "the recording", || {
        display.press("s");
        with_extension(folder.path(), "mcap")
    });
    assert!(fs::metadata(&recording).is_ok_and(|file| file.len() > 512 * ROOM_BLOCKS), "all of it is there");
    let verified = run_ok("stylet", &["verify", &recording.to_string_lossy(), "--json"]);
    let verified: Value = serde_json::from_str(&verified).expect("JSON");
    assert_eq!(verified["largest_deviation_n"], 0.0, "it re-simulates to the bit: {verified}");
    display.close();
    let ended = within(30, "the end of the program", || play.try_wait().expect("its state"));
    assert!(ended.success(), "what is saved may be closed: {ended}");
}

/// Presses of the space bar, and how long each is held and left.
const TAPS: usize = 5;
const TAP: Duration = Duration::from_millis(80);
/// Turns of the wheel by a notch, and what each is worth.
const NOTCHES: usize = 12;
const NOTCH_M: f64 = 0.75e-3;

/// What is on disk of the attempt that runs.
fn drafted(folder: &Path) -> Option<Recording> {
    let draft = fs::read(with_extension(folder, DRAFT)?).ok()?;
    let mut whole = Cursor::new(Vec::new());
    recording::recover::recover(&*draft, &mut whole).ok()?;
    Recording::read(&*whole.into_inner()).ok()
}

fn confirmations(recording: &Recording) -> usize {
    recording.events.iter().filter(|event| event.kind == EventKind::Confirm).count()
}

#[test]
fn keys_and_wheel_lose_no_tap_or_notch_at_any_frame_rate() {
    let (display, folder) = (Display::open(), tempfile::tempdir().expect("a folder"));
    let kept = folder.path().to_string_lossy().into_owned();
    let mut play = display.stylet(&["play", &first_exercise(), "--device", "mouse", "--recordings", &kept]);
    display.begin_attempt(folder.path());
    display.wait_for_picture();
    let press = |action: &[&str]| assert!(display.tool("xdotool", action).is_some(), "{action:?} could not be done");
    press(&["mousemove", "400", "300"]);
    within(60, "the servo's first ticks", || drafted(folder.path()).filter(|draft| !draft.samples.is_empty()));
    // A notch without a wheel is a press and a release of a button, which winit 0.30 takes for a notch each (its pull request 4386).
    for half in 0..NOTCHES {
        press(&[if half % 2 == 0 { "mousedown" } else { "mouseup" }, "5"]);
    }
    for _ in 0..TAPS {
        for action in ["keydown", "keyup"] {
            press(&[action, "space"]);
            sleep(TAP);
        }
    }
    // A busy machine draws seldom, and what comes with the Escape in one frame is not carried out any more.
    within(60, "the last tap", || drafted(folder.path()).filter(|draft| confirmations(draft) >= TAPS));
    sleep(Duration::from_secs(1));
    display.press("Escape");
    let path = within(60, "the recording", || with_extension(folder.path(), "mcap"));
    let recording = Recording::read(fs::File::open(path).expect("it is there")).expect("a recording");
    assert_eq!(confirmations(&recording), TAPS, "in the air they end nothing, and none counts twice");
    let way_m = recording.samples.last().map_or(0.0, |last| last.x_m) - recording.samples[0].x_m;
    assert!((way_m - NOTCHES as f64 * NOTCH_M).abs() < 1e-4, "{way_m} m for {NOTCHES} notches");
    let _ = play.kill();
    let _ = play.wait();
}
