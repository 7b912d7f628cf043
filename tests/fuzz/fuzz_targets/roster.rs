//! A roster in CSV or as a workbook, as a registrar's system or Excel saves it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = model::people::roster::read(bytes);
});
