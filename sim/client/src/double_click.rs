//! `stylet-window`: starts `stylet play` with the shipped exercises, for a double click on Windows.
//!
//! It has no console, and gives none to `stylet`, which lies next to it or in its folder `bin`. An error is
//! shown in a message box.

#![cfg_attr(windows, windows_subsystem = "windows")]
#![cfg_attr(windows, expect(unsafe_code, reason = "a call of the Windows API"))]

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::{env, io};

fn main() -> ExitCode {
    match play() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            show(&why);
            ExitCode::FAILURE
        }
    }
}

/// Runs the window to its end; the error is what `stylet` printed.
fn play() -> Result<(), String> {
    let own = env::current_exe().map_err(|error| error.to_string())?;
    let folder = own.parent().unwrap_or(Path::new("."));
    let data = data_folder().ok_or("LOCALAPPDATA is not set: no folder to store recordings in")?;
    let mut command = Command::new(folder.join("bin").join("stylet.exe"));
    command.arg("play").arg(folder.join("curricula")).arg("--recordings").arg(data.join("attempts"));
    command.args(env::args_os().skip(1)).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let output = without_console(&mut command).output().map_err(|error: io::Error| {
        format!("{}: {error}. Unpack the whole archive.", command.get_program().display())
    })?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() { Ok(()) } else { Err(said.into_owned()) }
}

/// Returns the folder for recordings of this user: not one that Windows copies to other computers or to a cloud.
fn data_folder() -> Option<PathBuf> {
    env::var_os("LOCALAPPDATA").map(|folder| PathBuf::from(folder).join("stylet"))
}

#[cfg(windows)]
fn without_console(command: &mut Command) -> &mut Command {
    use std::os::windows::process::CommandExt;
    const CREATE_NO_WINDOW: u32 = 0x0800_0000;
    command.creation_flags(CREATE_NO_WINDOW)
}

#[cfg(windows)]
fn show(why: &str) {
    use std::ptr;

    use windows_sys::Win32::UI::WindowsAndMessaging::{MB_ICONERROR, MB_OK, MessageBoxW};
    use windows_sys::w;

    let why: Vec<u16> = why.encode_utf16().chain([0]).collect();
    // SAFETY: both texts end with a zero and outlive the call; there is no parent window.
    unsafe { MessageBoxW(ptr::null_mut(), why.as_ptr(), w!("Stylet"), MB_OK | MB_ICONERROR) };
}

#[cfg(not(windows))]
fn without_console(command: &mut Command) -> &mut Command {
    command
}

#[cfg(not(windows))]
fn show(why: &str) {
    use std::io::Write;
    // A failure to write to standard error cannot be reported.
    let _ = writeln!(io::stderr(), "error: {why}");
}
