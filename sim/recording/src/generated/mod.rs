//! Rust types of the messages, generated from `sim/recording/proto`: `STYLET_UPDATE_MESSAGES=1
//! cargo test --workspace --test system messages` regenerates them.

pub(crate) mod stylet {
    include!("stylet.rs");
}

#[expect(clippy::enum_variant_names, reason = "the schema names them so")]
pub(crate) mod foxglove {
    include!("foxglove.rs");
}
