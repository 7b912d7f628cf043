//! What the replay's own script draws in a browser, for every shipped exercise and one on a skin that bends: the corners of skin and boundaries as they go to the
//! graphics card, in every frame. Fails when a boundary is not where the tip presses it, when one passes another, or when the browser
//! shows another body than `stylet render`, which takes where boundaries stand from `attempt::Dents`.
//!
//! `STYLET_UPDATE_PICTURES=1 cargo test --workspace --test system replay_drawing` also draws both side by side, at the same moments, into
//! `sim/render/pictures`.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use attempt::{Dents, needle_axis};
use documents::ExerciseBundle;
use fantoccini::{Client, Locator};
use law::Skin;
use nalgebra::Point3;
use recording::{EventKind, Recording, Sample};
use serde::Deserialize;
use serde_json::{Value, json};
use tests::{Service, documents, root, run_ok};

use crate::browser::{Driver, sign_in_with};
use crate::visitor::choose_password;
use crate::whole_path::{PASSWORD, found_school, scored};

/// Needle and tissue agree so far, in mm: less than a pixel.
const MOST_MM: f64 = 0.1;
/// So far one boundary may pass another, in mm. Where skin is tented 6 to 10 mm deep over 14 mm of soft fat, what is drawn beside the needle does.
fn most_passed_mm(name: &str) -> f64 {
    if ["1-lower-pole", "2-under-x-rays", "3-paramedian"].contains(&name) { 0.6 } else { MOST_MM }
}

/// A second scene on the page's own canvases, made as the page makes its own, by the scripts that the service serves.
const OPEN: &str = "
    const done = arguments[arguments.length - 1];
    const root = document.querySelector('#replay');
    const part = (name) => root.querySelector(`[data-part=${name}]`);
    Promise.all(['data', 'scene'].map((name) => import(`/assets/replay-${name}.js`))).then(async ([data, drawing]) => {
        const attempt = await data.Attempt.open(root.dataset.address, JSON.parse(root.dataset.names));
        await attempt.loadFrames();
        window.drawn = new drawing.Scene(part('scene'), part('labels'), attempt);
        done('');
    }).catch((error) => done(String(error)));";

/// Draws every frame, and the moment half-way to the next, and reads from the corners where each boundary stands.
const MEASURE: &str = "
    const scene = window.drawn;
    const { frames, stage } = scene.attempt;
    const FLOATS = 10;
    const NEARER = 0.06;
    const plus = (a, b, k) => a.map((value, i) => value + k * b[i]);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const corner = (mesh, at) => Array.from(mesh.numbers.subarray(at * FLOATS, at * FLOATS + 3));
    // Where the line between two corners is closest to the needle's line: how far off, and how far beyond the tip.
    const closest = (a, b) => {
      const [from, way] = [plus(a, scene.tip, -1), plus(b, a, -1)];
      const [across, along] = [from, way].map((v) => plus(v, scene.axis, -dot(v, scene.axis)));
      const share = Math.min(Math.max(-dot(across, along) / (dot(along, along) || 1), 0), 1);
      return { off: Math.hypot(...plus(across, along, share)), beyond: dot(plus(from, way, share), scene.axis) };
    };
    const nearest = (found) => found.reduce((best, one) => (one.off < best.off ? one : best));
    const read = () => {
      const { lines, solid } = scene.moving;
      const onCut = (at) => plus(corner(lines, at), scene.away, NEARER);
      let [line, quad, thinnest] = [0, 0, Infinity];
      const boundaries = stage.layers.filter((layer) => layer.top_mm < scene.bottom).map((_, i) => {
        const found = [];
        for (const _ of scene.columns(i)) {
          found.push(closest(onCut(line), onCut(line + 1)));
          thinnest = Math.min(thinnest, dot(plus(corner(solid, 6 * quad + 2), corner(solid, 6 * quad + 1), -1), scene.axis));
          line += 2;
          quad += 1;
        }
        // The end of the block.
        quad += 1;
        return nearest(found);
      });
      const places = Array.from({ length: scene.columns(0).length * 12 }, (_, k) => corner(solid, 6 * (quad + k) + 1));
      return { t_s: frames.row[0], thinnest, boundaries, skin: nearest(places.map((place) => closest(place, place))) };
    };
    const at = (t) => { scene.draw(t); return read(); };
    // Only the graphics card and the names are left out.
    const { painter } = scene;
    scene.painter = { begin() {}, draw() {} };
    scene.drawLabels = () => {};
    const whole = Array.from({ length: frames.count }, (_, k) => at(frames.time(k)));
    const half = whole.slice(1).map((_, k) => at((frames.time(k) + frames.time(k + 1)) / 2).thinnest);
    scene.painter = painter;
    delete scene.drawLabels;
    return { whole, thinnest_half: Math.min(...half) };";

/// What is sent of a whole patient before anything plays, and how far it fades at a moment before the needle goes in and at its deepest; null
/// where there is none.
const PATIENT: &str = "
    const scene = window.drawn;
    const { frames, stage } = scene.attempt;
    if (!scene.hasPatient) return null;
    const faded = Array.from({ length: frames.count }, (_, k) => { scene.read(frames.at(frames.time(k))); return scene.faded; });
    return {
      shown: document.querySelector('[data-part=view]').value,
      triangles: stage.skin.triangles.length / 3,
      bytes: JSON.stringify(stage).length,
      faded: [faded[0], Math.max(...faded)],
    };";

/// The view of a whole patient.
#[derive(Deserialize)]
struct DrawnPatient {
    /// The view that the page begins with.
    shown: String,
    triangles: f64,
    /// Of the stage, before it is compressed.
    bytes: f64,
    /// Above the skin, and at the deepest.
    faded: [f64; 2],
}

/// Where a drawn boundary meets the needle's line, in mm.
#[derive(Clone, Copy, Deserialize)]
struct Crossing {
    /// Distance of the two.
    off: f64,
    /// Beyond the tip, along the needle.
    beyond: f64,
}

/// What the corners of a frame say, in mm.
#[derive(Deserialize)]
struct Drawn {
    t_s: f32,
    /// The least thickness of a layer at any corner, along the needle.
    thinnest: f64,
    /// Every boundary that is in the picture, from the skin down, on the cut.
    boundaries: Vec<Crossing>,
    /// The skin's surface behind the cut.
    skin: Crossing,
}

/// A recording as the simulator reads it, frame by frame.
struct Truth {
    recording: Recording,
    dents: Dents,
    skin: Skin,
    thicknesses_m: Vec<f64>,
    told: [usize; 2],
}

impl Truth {
    fn new(made: &DrawnAttempt) -> Self {
        let bundle = ExerciseBundle::read(&root().join(&made.exercise)).expect("an exercise");
        let recording = Recording::read(std::fs::File::open(&made.path).expect("a recording")).expect("a recording");
        let thicknesses_m: Vec<f64> = recording.session.patient_thickness_mm.iter().map(|mm| mm * 1e-3).collect();
        let skin = bundle.scene.skin_shape;
        let dents = Dents::new(skin, thicknesses_m.iter().copied(), bundle.scene.needle.tip_to_rim_mm * 1e-3);
        Self { recording, dents, skin, thicknesses_m, told: [0; 2] }
    }

    /// The sample of a frame, once everything up to it is told.
    fn at(&mut self, t_s: f32) -> Sample {
        let Recording { samples, events, tents, .. } = &self.recording;
        let sample = samples[samples.partition_point(|sample| sample.t_s as f32 <= t_s).saturating_sub(1)];
        while let Some(event) = events.get(self.told[0]).filter(|event| event.t_s <= sample.t_s) {
            self.dents.event(event);
            self.told[0] += 1;
        }
        while let Some(tent) = tents.get(self.told[1]).filter(|tent| tent.t_s as f32 <= t_s) {
            self.dents.tent(tent);
            self.told[1] += 1;
        }
        sample
    }

    /// Way along the needle from the skin to every resting boundary and to the tip, in mm.
    fn way_mm(&self, sample: &Sample) -> (Vec<f64>, f64) {
        let (tip_m, axis) = (Point3::from(sample.tip_m()), needle_axis(sample));
        let way_m = self.skin.displacement_m(&tip_m, &axis);
        let mut rest_m = Vec::new();
        let incidence = self.skin.incidence(&(tip_m - axis * way_m), &axis);
        incidence.lay_layers(self.thicknesses_m.iter().copied(), &mut rest_m);
        (rest_m.into_iter().map(|rest_m| rest_m * 1e3).collect(), way_m * 1e3)
    }

    /// How far a drawn frame is off, in mm: from what presses each boundary, and from where the simulator's own picture has it.
    fn off_mm(&mut self, drawn: &Drawn) -> f64 {
        let sample = self.at(drawn.t_s);
        if sample.flags & recording::sample::flags::INSIDE == 0 {
            return 0.0;
        }
        let (rest_mm, tip_mm) = self.way_mm(&sample);
        let mut shown_m = self.dents.at(&sample);
        let mut most_mm = drawn.skin.off.max((drawn.skin.beyond - drawn.boundaries[0].beyond).abs());
        for (boundary, crossing) in drawn.boundaries.iter().enumerate() {
            let dent_mm = crossing.beyond + tip_mm - rest_mm[boundary];
            most_mm = most_mm.max(crossing.off).max((dent_mm - f64::from(shown_m[boundary]) * 1e3).abs());
            shown_m[boundary] = (dent_mm * 1e-3) as f32;
        }
        most_mm.max(self.dents.disagreement_m(&sample, &shown_m) * 1e3)
    }
}

/// A course whose skin bends.
const BENT: &str = "tests/data/lump";

/// A simulated attempt.
struct DrawnAttempt {
    /// Of the exercise's file.
    name: String,
    exercise: String,
    /// The recording's.
    path: String,
}

/// Simulates every shipped exercise, and the one on a skin that bends.
fn record_all(folder: &Path) -> Vec<DrawnAttempt> {
    let is_exercise =
        |path: &String| !path.contains("/scenes/") && !path.contains("/instruments/") && !path.ends_with("course.toml");
    let record = |exercise: String| {
        let name = Path::new(&exercise).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = folder.join(format!("{name}.mcap")).to_string_lossy().into_owned();
        run_ok("stylet", &["simulate", &exercise, "--operator", "constant:10", "--seed", "3", "--out", &path]);
        DrawnAttempt { name, exercise, path }
    };
    documents().into_iter().filter(is_exercise).chain([format!("{BENT}/exercise.toml")]).map(record).collect()
}

/// Opens the replay of a session, and a scene of the test's own in it.
async fn open(browser: &Client, address: &str) {
    browser.goto(address).await.expect("the replay");
    for _ in 0..200 {
        let ready = browser.execute("return document.querySelector('#replay').dataset.ready ?? ''", vec![]).await;
        if ready.expect("the page answers") == json!("yes") {
            break;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert_eq!(browser.execute_async(OPEN, vec![]).await.expect("the page answers"), "", "{address}");
}

#[tokio::test]
async fn browser_draws_tip_and_tissue_as_the_simulator_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let token = found_school(&data);
    let place = data.to_string_lossy();
    run_ok("web-admin", &["curricula", "import", BENT, "--data-dir", &place, "--school", "Test School"]);
    let service = Service::start(&data);
    choose_password(&service.url, "ada@example.org", PASSWORD);
    let recordings = record_all(folder.path());
    assert!(recordings.len() >= 9, "{} exercises", recordings.len());
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(at("token"), &token).expect("a file");
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    browser.set_window_size(1280, 900).await.expect("a window of that size");
    sign_in_with(&browser, &service.url, ("ada@example.org", PASSWORD)).await;
    let mut patients = 0;
    for made in &recordings {
        let DrawnAttempt { name, path, .. } = made;
        let (file, outbox) = (at("token"), at("outbox"));
        run_ok("stylet", &["upload", path, "--server", &service.url, "--token-file", &file, "--outbox", &outbox]);
        let session = Recording::read(std::fs::File::open(path).expect("a recording")).expect("one").session.session_id;
        scored(&service.url, &token, &session.to_string());
        open(&browser, &format!("{}/sessions/{session}/replay", service.url)).await;
        let mut truth = Truth::new(made);
        let measured = browser.execute(MEASURE, vec![]).await.expect("the frames");
        check(name, &mut truth, measured);
        let patient = browser.execute(PATIENT, vec![]).await.expect("the patient");
        patients += usize::from(check_patient(name, patient));
        if std::env::var_os("STYLET_UPDATE_PICTURES").is_some() && BESIDE.contains(&name.as_str()) {
            draw_beside(&browser, &truth.recording, made, folder.path()).await;
        }
    }
    browser.close().await.expect("the browser closes");
    assert_eq!(patients, 7, "exercises on a body");
}

/// A whole patient is little to send, is what the page begins with, and fades as in the simulator's own picture; whether there is one.
fn check_patient(name: &str, patient: Value) -> bool {
    let patient: Option<DrawnPatient> = serde_json::from_value(patient).expect("a patient or none");
    let Some(DrawnPatient { shown, triangles, bytes, faded: [before, deepest] }) = patient else { return false };
    assert_eq!(shown, "patient", "{name}");
    assert!((1000.0..=6000.0).contains(&triangles) && bytes < 400e3, "{name}: {triangles} triangles, {bytes} B");
    assert!(before <= 0.0 && (0.5..=0.8 + 1e-9).contains(&deepest), "{name}: faded {before}, then {deepest}");
    true
}

fn check(name: &str, truth: &mut Truth, mut measured: Value) {
    let half_mm = measured["thinnest_half"].as_f64().unwrap_or(f64::NEG_INFINITY);
    let frames: Vec<Drawn> = serde_json::from_value(measured["whole"].take()).expect("frames");
    assert!(frames.len() > 200 && frames.iter().all(|frame| frame.boundaries.len() > 2), "{name}: {}", frames.len());
    let mut touched = 0;
    for frame in &frames {
        let off_mm = truth.off_mm(frame);
        assert!(off_mm < MOST_MM, "{name} at {} s: {off_mm} mm off", frame.t_s);
        touched += usize::from(frame.boundaries.iter().any(|crossing| crossing.beyond.abs() < MOST_MM));
    }
    let thinnest_mm = frames.iter().map(|frame| frame.thinnest).fold(half_mm, f64::min);
    assert!(thinnest_mm > -most_passed_mm(name), "{name}: a boundary passes another by {} mm", -thinnest_mm);
    assert!(touched > 20, "{name}: a boundary is at the tip in {touched} frames only");
}

/// Exercises that are drawn side by side.
const BESIDE: [&str; 3] = ["1-feel-the-layers", "5-oblique-approach", "1-stop-in-the-epidural-space"];

/// Moments of an attempt at which the pictures are worth comparing, in s: tented skin, skin opened, deepest, on the way out.
fn moments_s(recording: &Recording) -> Vec<f64> {
    let first_s = |kind| recording.events.iter().find(|event| event.kind == kind).map(|event| event.t_s);
    let opened_s = first_s(EventKind::TipRupture).expect("the skin is opened");
    let deepest = recording.samples.iter().max_by(|a, b| a.x_m.total_cmp(&b.x_m)).expect("samples");
    let out_s = recording.events.iter().rev().find(|event| event.kind == EventKind::SkinExit);
    let out_s = out_s.expect("the needle comes out").t_s;
    vec![opened_s - 0.02, opened_s + 0.1, deepest.t_s, 0.5 * (deepest.t_s + out_s)]
}

/// Draws the same moments by `stylet render`, left, and by the browser, right.
async fn draw_beside(
    browser: &Client,
    recording: &Recording,
    DrawnAttempt { name, path, .. }: &DrawnAttempt,
    folder: &Path,
) {
    let mut pictures = Vec::new();
    for (row, t_s) in moments_s(recording).into_iter().enumerate() {
        let [ours, theirs] =
            ["render", "browser"].map(|who| folder.join(format!("{row}-{who}.png")).to_string_lossy().into_owned());
        run_ok(
            "stylet",
            &["render", path, "--at", &format!("{t_s:.4}"), "--view", "section", "--size", "960x600", "--out", &ours],
        );
        let show = "document.querySelector('[data-part=view]').value = 'side';
            window.drawn.look('side');
            window.drawn.draw(arguments[0])";
        browser.execute(show, vec![json!(t_s)]).await.expect("a moment is drawn");
        let canvas = browser.find(Locator::Css("[data-part=scene]")).await.expect("the picture");
        std::fs::write(&theirs, canvas.screenshot().await.expect("a picture")).expect("written");
        for (picture, who) in [(ours, "stylet render"), (theirs, "browser")] {
            pictures.extend(["-label".to_owned(), format!("{who}, {t_s:.2} s"), picture]);
        }
    }
    let out = root().join(format!("sim/render/pictures/beside-{name}.png"));
    let out = out.to_string_lossy();
    let run = |tool: &str, pictures: &[String], arguments: &[&str]| {
        let status = Command::new(tool).args(pictures).args(arguments).arg(&*out).status();
        assert!(status.is_ok_and(|status| status.success()), "ImageMagick draws {out}");
    };
    run("montage", &pictures, &["-tile", "2x", "-geometry", "x240+4+4"]);
    run("mogrify", &[], &["-dither", "None", "-colors", "64", "-define", "png:format=png8"]);
}
