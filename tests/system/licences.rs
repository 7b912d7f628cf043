//! Every dependency may be shipped under MIT OR Apache-2.0. Fails when a copyleft or unlicensed crate slips into the graph.

use tests::metadata;

/// Licences that may be linked into what we ship.
const ACCEPTED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "CDLA-Permissive-2.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Files under the Mozilla licence stay under it; linking them is allowed and nothing of ours is affected.
const FILE_COPYLEFT: &[&str] = &["MPL-2.0"];

/// True when one choice of an SPDX expression is accepted throughout.
fn accepted(expression: &str) -> bool {
    let flat = expression.replace('/', " OR ").replace(['(', ')'], " ");
    flat.split(" OR ")
        .any(|choice| choice.split(" AND ").map(str::trim).all(|l| ACCEPTED.contains(&l) || FILE_COPYLEFT.contains(&l)))
}

#[test]
fn every_dependency_may_be_shipped() {
    let refused: Vec<_> = metadata()
        .packages
        .iter()
        .filter(|p| !p.license.as_deref().is_some_and(accepted))
        .map(|p| format!("{} {}: {:?}", p.name, p.version, p.license))
        .collect();
    assert!(refused.is_empty(), "not accepted: {refused:#?}");
}

#[test]
fn the_check_refuses_copyleft() {
    assert!(!accepted("GPL-3.0-only"));
    assert!(!accepted("MIT AND GPL-2.0"));
    assert!(accepted("MIT OR GPL-2.0"));
    assert!(accepted("(MIT OR Apache-2.0) AND Unicode-3.0"));
}
