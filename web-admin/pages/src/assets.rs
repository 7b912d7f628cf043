//! The style sheet, scripts and pictures, embedded in the program.

use std::sync::LazyLock;

use data_encoding::HEXLOWER;
use rust_embed::{Embed, EmbeddedFile};

#[derive(Embed)]
#[folder = "assets/"]
struct Assets;

/// Returns an asset and the hash of its content.
#[must_use]
pub fn find_asset(name: &str) -> Option<(EmbeddedFile, String)> {
    let file = Assets::get(name)?;
    let hash = HEXLOWER.encode(&file.metadata.sha256_hash()[..8]);
    Some((file, hash))
}

/// Returns the address of an asset. It contains the asset's hash, so that a browser may cache it
/// for a year.
#[must_use]
pub fn asset_address(name: &str) -> String {
    let hash = find_asset(name).map_or_else(String::new, |(_, hash)| hash);
    format!("/assets/{name}?v={hash}")
}

/// Returns the address of the style sheet.
#[must_use]
pub fn style_sheet() -> &'static str {
    static ADDRESS: LazyLock<String> = LazyLock::new(|| asset_address("style.css"));
    &ADDRESS
}

/// Returns the address of the script that sorts tables.
#[must_use]
pub fn table_script() -> &'static str {
    static ADDRESS: LazyLock<String> = LazyLock::new(|| asset_address("tables.js"));
    &ADDRESS
}

#[cfg(test)]
mod tests {
    //! Every page links to the style sheet: it must exist, under an address that contains its hash.

    use super::*;

    #[test]
    fn the_style_sheet_is_carried_and_its_address_holds_its_hash() {
        let (file, hash) = find_asset("style.css").expect("a style sheet");
        assert!(!file.data.is_empty());
        assert_eq!(style_sheet(), format!("/assets/style.css?v={hash}"));
        assert!(find_asset("../Cargo.toml").is_none());
    }
}
