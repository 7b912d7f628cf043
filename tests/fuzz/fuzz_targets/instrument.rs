//! A questionnaire in TOML or JSON, as an instructor imports it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for name in ["fuzzed.toml", "fuzzed.json"] {
        let _ = documents::Instrument::from_bytes(name, bytes);
    }
});
