//! `stylet check` and `stylet schema`.

use crate::stylet;

#[test]
fn a_file_that_is_not_there_is_a_wrong_call() {
    stylet(&["check", "nowhere.toml"]).refused(&["nowhere.toml"]);
    stylet(&["check"]).refused(&["FILE"]);
}
