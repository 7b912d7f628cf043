//! What strangers send is decoded by a helper process. Fails when another part of the service decodes it.

use crate::house::service_but;

/// What decodes a stranger's bytes, and the files that may have it done. A helper does it, with limits of memory and time, but for what a
/// helper has read at its arrival.
const DECODERS: &[(&str, &[&str])] = &[
    ("WorkbookSheet::read", &["acts/src/sandbox_jobs/mod.rs", "model/src/people/roster/table.rs"]),
    ("picture::copy_", &["acts/src/sandbox_jobs/mod.rs"]),
    ("copy_logo", &["acts/src/sandbox_jobs/mod.rs"]),
    ("recording_files::read", &["acts/src/sandbox_jobs/mod.rs", "acts/src/recordings/mod.rs"]),
    ("annotate::annotate", &["acts/src/sandbox_jobs/mod.rs"]),
    ("Recording::read", &["acts/src/sandbox_jobs/recording_files.rs"]),
    // Only a re-grading that lacks a metric reads a recording once more, two at once.
    ("recordings::with(", &["acts/src/scoring/regrading/mod.rs"]),
];
/// Crates that decode files. Only these of ours use them.
const DECODING_CRATES: &[(&str, &[&str])] = &[
    ("calamine", &["model/src/people/roster/"]),
    ("zip::", &["model/src/people/roster/"]),
    // Papers show a logo, which a helper has written anew at its arrival.
    ("image::", &["pages/src/training/paper/"]),
    ("mcap::", &[]),
];

#[test]
fn what_strangers_send_is_decoded_where_a_death_harms_nobody() {
    for (path, text) in service_but("demo") {
        // Tests beside the code make what they read.
        let shipped = text.split("#[cfg(test)]").next().unwrap_or_default();
        for (decoder, allowed) in DECODERS.iter().chain(DECODING_CRATES) {
            let is_allowed = allowed.iter().any(|place| path.to_string_lossy().contains(place));
            assert!(is_allowed || !shipped.contains(decoder), "{}: {decoder} runs in a helper alone", path.display());
        }
    }
}
