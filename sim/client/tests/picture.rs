//! Pictures without a window, on the software adapter. Would fail if a size or a time were taken for another, if two pictures of one
//! moment differed, if OpenGL drew another than Vulkan, if the needle did not move, or if a wrong call left a file behind.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::{Run, program, repository, run, stylet, text};

fn exercise() -> PathBuf {
    repository("curricula/lower-back-basics/1-feel-the-layers.toml")
}

/// A recording of a straight, fast insertion.
fn recorded(folder: &Path) -> PathBuf {
    let file = folder.join("attempt.mcap");
    let fixed = ["--operator", "constant:10", "--seed", "1", "--out", text(&file)];
    stylet(&[&["simulate", text(&exercise())], &fixed[..]].concat()).ends(0);
    file
}

fn render(what: &Path, out: &Path, more: &[&str]) -> Run {
    stylet(&[&["render", text(what), "--size", "320x180", "--out", text(out)], more].concat())
}

/// The pixels of a picture that was drawn.
fn drawn(what: &Path, out: &Path, more: &[&str]) -> image::RgbaImage {
    render(what, out, more).ends(0);
    image::open(out).expect("a picture").into_rgba8()
}

#[test]
fn a_picture_has_its_size_and_is_the_same_twice() {
    let folder = TempDir::new().expect("a folder");
    let recording = recorded(folder.path());
    for view in ["whole", "tip", "section"] {
        let (one, two) = (folder.path().join("one.png"), folder.path().join("two.png"));
        let picture = drawn(&recording, &one, &["--at", "2.5", "--view", view]);
        assert_eq!(picture.dimensions(), (320, 180));
        drawn(&recording, &two, &["--at", "2.5", "--view", view]);
        assert!(fs::read(&one).expect("bytes") == fs::read(&two).expect("bytes"), "{view}: identical bytes");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn opengl_draws_what_vulkan_draws() {
    let folder = TempDir::new().expect("a folder");
    let recording = recorded(folder.path());
    for view in ["whole", "tip", "section"] {
        let [vulkan, gl] = ["vulkan", "gl"].map(|backend| {
            let out = folder.path().join(backend);
            let mut command = program();
            command.args(["render", text(&recording), "--size", "320x180", "--at", "2.5", "--view", view, "--out"]);
            run(command.arg(out.with_extension("png")).env("WGPU_BACKEND", backend)).ends(0);
            image::open(out.with_extension("png")).expect("a picture").into_rgba8()
        });
        let off = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
        let mean = vulkan.iter().zip(gl.iter()).map(off).sum::<f64>() / vulkan.len() as f64;
        // Edges fall on other samples; a tile or a tent that is missing is off by tens.
        assert!(mean < 2.0, "{view}: {mean} of 255 apart at the mean");
    }
}

#[test]
fn the_needle_moves_and_an_exercise_shows_it_at_its_start() {
    let folder = TempDir::new().expect("a folder");
    let recording = recorded(folder.path());
    let out = folder.path().join("p.png");
    let picture = |what: &Path, more: &[&str]| drawn(what, &out, more);
    let inside = picture(&recording, &["--at", "2.5"]);
    for (waiting, what) in
        [(picture(&recording, &["--at", "0"]), "the recording's start"), (picture(&exercise(), &[]), "the exercise")]
    {
        let differing = waiting.pixels().zip(inside.pixels()).filter(|(a, b)| a != b).count();
        assert!(differing > 300, "{what} and the needle inside differ in {differing} pixels only");
    }
}

#[test]
fn a_film_has_a_frame_for_every_moment() {
    let folder = TempDir::new().expect("a folder");
    let (recording, film) = (recorded(folder.path()), folder.path().join("film"));
    stylet(&["render", text(&recording), "--size", "64x36", "--frames", text(&film), "--fps", "2"]).ends(0);
    let score = stylet(&["score", text(&recording), "--json"]).ends(0).json();
    let total_s = score["metrics"].as_array().and_then(|metrics| {
        metrics.iter().find(|metric| metric["id"] == "time_total_s").and_then(|metric| metric["value"].as_f64())
    });
    let frames = (total_s.expect("a length") * 2.0).floor() as usize + 1;
    assert_eq!(fs::read_dir(&film).expect("a folder").count(), frames);
    assert!(film.join("00000.png").exists());
}

#[test]
fn a_wrong_call_names_what_is_allowed_and_leaves_nothing() {
    let folder = TempDir::new().expect("a folder");
    let (recording, out) = (recorded(folder.path()), folder.path().join("p.png"));
    render(&recording, &out, &["--at", "1000"]).refused(&["--at 1000 s", "the attempt lasts"]);
    render(&recording, &out, &["--at", "-1"]).refused(&["--at"]);
    render(&recording, &out, &["--view", "above"]).refused(&["above", "whole, patient, tip or section"]);
    stylet(&["render", text(&recording), "--size", "0x10", "--out", text(&out)]).refused(&["0x10", "1 to 8192"]);
    stylet(&["render", text(&recording)]).refused(&["--out"]);
    stylet(&["render", "nothing.mcap", "--out", text(&out)]).refused(&["nothing.mcap"]);
    assert!(!out.exists());
}

#[test]
fn a_radiograph_shows_the_needle_and_its_dose() {
    let folder = TempDir::new().expect("a folder");
    let kidney = repository("curricula/percutaneous-kidney-access/1-lower-pole.toml");
    let recording = folder.path().join("kidney.mcap");
    stylet(&["simulate", text(&kidney), "--operator", "expert", "--seed", "3", "--out", text(&recording)]).ends(0);
    let take = |at: &str, more: &[&str]| {
        let out = folder.path().join("radiograph.png");
        let call = ["render", text(&recording), "--at", at, "--x-ray", "30,0", "--out", text(&out)];
        let run = stylet(&[&call, more].concat()).ends(0);
        assert!(run.stdout.contains("mAs") && run.stdout.contains("µGy at the reference point"), "{}", run.stdout);
        image::open(&out).expect("a picture").into_luma8()
    };
    let dark = |picture: &image::GrayImage| picture.pixels().filter(|pixel| pixel.0[0] < 20).count();
    let [before, inside] = ["0", "40"].map(|at| take(at, &[]));
    assert_eq!(inside.dimensions(), (512, 512));
    assert_ne!(before, inside, "the needle has moved");
    // Seen at 30°, the needle is some 150 pixels long and 3 wide; noise brightens some.
    assert!((100..3000).contains(&dark(&inside)), "{} pixels of steel", dark(&inside));
    let [empty, filled] = [inside.clone(), take("40", &["--contrast-ml", "8"])]
        .map(|picture| picture.pixels().map(|pixel| u64::from(pixel.0[0])).sum::<u64>());
    assert_ne!(empty, filled, "contrast medium shows");
}

#[test]
fn a_radiograph_names_what_it_refuses() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("radiograph.png");
    let refused = |exercise: &str, more: &[&str], words: &str| {
        let exercise = repository(exercise);
        let run = stylet(&[&["render", text(&exercise), "--out", text(&out)], more].concat()).ends(2);
        assert!(run.stderr.contains(words), "{}", run.stderr);
        assert!(!out.exists());
    };
    let kidney = "curricula/percutaneous-kidney-access/1-lower-pole.toml";
    refused("curricula/lower-back-basics/1-feel-the-layers.toml", &["--x-ray", "0,0"], "a scene without a body");
    refused(kidney, &["--x-ray", "95,0"], "orbital = 95°; allowed: -45 to 90°");
    refused(kidney, &["--x-ray", "0,0", "--field-mm", "20"], "field = 20 mm; allowed: 60 to 300 mm");
    refused(kidney, &["--x-ray", "0"], "two numbers in degrees");
    refused(kidney, &["--x-ray", "0,0", "--contrast-ml", "-1"], "--contrast-ml");
    refused(kidney, &["--contrast-ml", "5"], "--x-ray");
    refused(kidney, &["--x-ray", "0,0", "--dose", "none"], "low, normal, boost");
}
