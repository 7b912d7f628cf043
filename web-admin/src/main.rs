//! The program `web-admin`: everything is in the library, where tests can reach it.

fn main() -> std::process::ExitCode {
    web_admin::cli::main()
}
