//! Which licences may be linked into what we ship, and why.

use spdx::{Expression, LicenseReq, ParseMode};

/// Licences that any dependency may have, and why they may be linked into programs under MIT OR Apache-2.0.
pub const ACCEPTED: &[(&str, &str)] = &[
    ("0BSD", "asks for nothing"),
    ("Apache-2.0", "one of our own: keep the notices"),
    ("Apache-2.0 WITH LLVM-exception", "Apache-2.0, with less asked of programs"),
    ("BSD-2-Clause", "keep the notice"),
    ("BSD-3-Clause", "keep the notice; no endorsement"),
    ("BSL-1.0", "keep the notice in sources"),
    ("CC0-1.0", "public domain"),
    ("CDLA-Permissive-2.0", "data, of certificate authorities: keep the text"),
    ("ISC", "keep the notice"),
    ("MIT", "one of our own: keep the notice"),
    ("MIT-0", "asks for nothing"),
    (
        "MPL-2.0",
        "its files stay under it and are to be had, unchanged, where the notices say; nothing of ours is affected",
    ),
    ("Unicode-3.0", "tables of Unicode: keep the notice"),
    ("Unlicense", "public domain"),
    ("Zlib", "keep the notice in sources"),
];

/// Licences that one dependency may have and no other: its name, the licence, and why.
pub const ACCEPTED_FOR_ONE: &[(&str, &str, &str)] = &[
    (
        "epaint_default_fonts",
        "OFL-1.1",
        "the fonts of the window and of papers: they may be shipped inside a program, are not sold by themselves, and keep their licence",
    ),
    (
        "epaint_default_fonts",
        "Ubuntu-font-1.0",
        "the fonts of the window and of papers: shipped unchanged under their own name, with their licence; documents may embed them",
    ),
];

/// True when the licence of a package, an SPDX expression or an older list with slashes, leaves a choice that is
/// accepted throughout. An expression that does not parse is not accepted.
#[must_use]
pub fn may_ship(package: &str, expression: &str) -> bool {
    let accepted = |requirement: &LicenseReq| {
        let licence = requirement.to_string();
        let for_one = ACCEPTED_FOR_ONE.iter().any(|(name, one, _)| *name == package && *one == licence);
        for_one || ACCEPTED.iter().any(|(one, _)| *one == licence)
    };
    parse(expression).is_some_and(|parsed| parsed.evaluate(accepted))
}

/// The licences that an expression names, as SPDX writes them.
#[must_use]
pub fn named(expression: &str) -> Vec<String> {
    let parsed = parse(expression);
    parsed.iter().flat_map(Expression::requirements).map(|found| found.req.to_string()).collect()
}

fn parse(expression: &str) -> Option<Expression> {
    Expression::parse_mode(expression, ParseMode::LAX).ok()
}
