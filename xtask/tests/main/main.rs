//! The commands of `xtask` as the scripts in `deploy` call them.

mod licences;
