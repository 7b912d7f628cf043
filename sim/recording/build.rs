//! Compiles `proto/stylet.proto` in Rust alone (protox), so that a build needs no `protoc`.

use std::error::Error;
use std::path::PathBuf;

use prost::Message;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=proto/stylet.proto");
    let mut descriptors = protox::compile(["stylet.proto"], ["proto"])?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    prost_build::Config::new().out_dir(&out).compile_fds(descriptors.clone())?;
    // Comments would travel in every recording, four times.
    for file in &mut descriptors.file {
        file.source_code_info = None;
    }
    std::fs::write(out.join("stylet.bin"), descriptors.encode_to_vec())?;
    Ok(())
}
