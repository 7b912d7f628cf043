//! A recording as a stranger uploads it: read, recovered, and judged by the exercise that it carries.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(recording) = recording::Recording::read(bytes)
        && let Ok(bundle) = assessment::own_exercise(&recording)
    {
        let _ = assessment::assess(&recording, &bundle);
    }
});
