//! The shipped scenes, embedded in the program so that every copy reads the same text.

use std::path::Path;

use documents::{DocumentError, Scene};

/// The text of every shipped scene.
pub const SHIPPED_SCENES: [&str; 17] = [
    include_str!("../../../curricula/scenes/lower-back-paper.toml"),
    include_str!("../../../curricula/scenes/lower-back-training.toml"),
    include_str!("../../../curricula/scenes/epidural-71kg.toml"),
    include_str!("../../../curricula/scenes/lower-back-lean.toml"),
    include_str!("../../../curricula/scenes/lower-back-obese.toml"),
    include_str!("../../../curricula/scenes/lower-back-thick-needle.toml"),
    include_str!("../../../curricula/scenes/lower-back-vessel.toml"),
    include_str!("../../../curricula/scenes/liver-18g.toml"),
    include_str!("../../../curricula/scenes/heart-18g.toml"),
    include_str!("../../../curricula/scenes/epidural-midline.toml"),
    include_str!("../../../curricula/scenes/epidural-off-bone.toml"),
    include_str!("../../../curricula/scenes/epidural-paramedian.toml"),
    include_str!("../../../curricula/scenes/lumbar-puncture.toml"),
    include_str!("../../../curricula/scenes/lumbar-puncture-25g.toml"),
    include_str!("../../../curricula/scenes/kidney-lower-pole.toml"),
    include_str!("../../../curricula/scenes/abdomen-veress.toml"),
    include_str!("../../../curricula/scenes/abdomen-trocar-12mm.toml"),
];

/// Returns the text of the shipped scene with an id.
#[must_use]
pub fn find_shipped_scene(id: &str) -> Option<&'static str> {
    let named = format!("id = \"{id}\"");
    SHIPPED_SCENES.into_iter().find(|text| text.lines().any(|line| line == named))
}

/// Reads every shipped scene.
///
/// # Errors
/// If an embedded document is refused.
pub fn read_shipped_scenes() -> Result<Vec<Scene>, DocumentError> {
    SHIPPED_SCENES.iter().map(|text| documents::load::read_scene_text(Path::new("shipped scene"), text)).collect()
}
