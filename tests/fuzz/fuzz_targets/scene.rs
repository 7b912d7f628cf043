//! A scene in TOML, as somebody writes it by hand.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = documents::load::read_scene_text(std::path::Path::new("fuzzed.toml"), text);
});
