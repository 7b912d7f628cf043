//! An exam file, as a verifier receives it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = model::scoring::exam_file::check(bytes, "ea4a6c63e29c520abef5507b132ec5f9954776aebebe7b92421eea691446d22c");
});
