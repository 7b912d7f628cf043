//! The program `web-admin`: everything is in the library, where tests can reach it.

use rustix::fs::Mode;

fn main() -> std::process::ExitCode {
    // Whatever is written, also by SQLite, is its owner's alone.
    rustix::process::umask(Mode::RWXG | Mode::RWXO);
    web_admin::cli::main()
}
