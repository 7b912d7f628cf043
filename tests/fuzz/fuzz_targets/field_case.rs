//! A case for `stylet field` in JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = documents::field_case::parse("fuzzed.json", text);
});
