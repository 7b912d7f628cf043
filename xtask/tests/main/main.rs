//! The commands of `xtask` as the scripts in `deploy` call them.

#![expect(clippy::expect_used, reason = "a test that cannot go on says why and stops")]

mod licences;
