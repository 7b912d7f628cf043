//! The program `web-admin`: all code is in the library, where tests can reach it.

use rustix::fs::Mode;

fn main() -> std::process::ExitCode {
    // Files created by the process, including those of SQLite, are accessible to their owner only.
    rustix::process::umask(Mode::RWXG | Mode::RWXO);
    web_admin::cli::main()
}
