# Shared by deploy/run and deploy/test: finds or installs what the build needs. Sourced, not run.
# shellcheck shell=bash

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Installs Debian packages that are missing. As root or with sudo; elsewhere it says what to install.
need_packages() {
    local missing=() package
    for package in "$@"; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return
    command -v apt-get >/dev/null || die "this system has no apt-get; install the equivalents of: ${missing[*]}"
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || die "run as root or install sudo, or install by hand: ${missing[*]}"
        as_root=(sudo)
    fi
    say "Installing ${missing[*]}"
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# On systems without dpkg the programs themselves are looked for.
need_programs_or_packages() {
    if command -v dpkg-query >/dev/null; then
        need_packages "$@"
        return
    fi
    local program
    for program in cc pkg-config; do
        command -v "$program" >/dev/null || die "install a C compiler and pkg-config with this system's package manager ('$program' is missing)"
    done
}

need_rust() {
    local wanted found
    wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    command -v cargo >/dev/null || die "Rust $wanted or newer is needed: https://rustup.rs"
    found=$(rustc --version | awk '{print $2}')
    [ "$(printf '%s\n%s\n' "$wanted" "$found" | sort -V | head -n 1)" = "$wanted" ] \
        || die "Rust $found is too old: $wanted or newer is needed (rustup update)"
}

# Takes what only a debugger needs out of programs and keeps it beside each as PROGRAM.debug, where gdb finds it by itself.
# Done again it does nothing, until cargo has built the program anew.
symbols_apart() {
    local program
    for program in "$@"; do
        case $(readelf --sections --wide "$program") in *.symtab*) ;; *) continue ;; esac
        objcopy --only-keep-debug "$program" "$program.debug"
        objcopy --strip-all --add-gnu-debuglink="$program.debug" "$program" "$program.stripped"
        mv "$program.stripped" "$program"
    done
}
