# Shared by deploy/run and deploy/test: finds or installs what the build needs. Sourced, not run.
# shellcheck shell=bash

# What the tests try besides what ships by default: one list, so that no call of cargo compiles a crate again with other features.
# shellcheck disable=SC2034 # Used where this is sourced.
tested_features=stylet/reports,web-admin/replicas

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Begins a phase; `print_phases` lists what each took.
phase_names=() phase_starts=()
phase() {
    say "$1"
    phase_names+=("$1")
    phase_starts+=("$SECONDS")
}

print_phases() {
    local n ends=("${phase_starts[@]:1}" "$SECONDS")
    echo "Seconds of each phase"
    for n in "${!phase_names[@]}"; do
        printf '%6d  %s\n' "$((ends[n] - phase_starts[n]))" "${phase_names[n]}"
    done
    printf '%6d  in all\n' "$SECONDS"
}

# Lists the 30 slowest tests of reports that nextest has written.
print_slowest() {
    echo "Seconds of the 30 slowest tests"
    sed -n 's/.*<testcase name="\([^"]*\)" classname="\([^"]*\)".* time="\([0-9.]*\)".*/\3 \2 \1/p' "$@" \
        | sort -rn | awk 'NR <= 30 { printf "%8.1f  %s %s\n", $1, $2, $3 }'
}

# Sums up the closing lines of logs of nextest.
print_counts() {
    awk '/^ *Summary \[/ {
        for (n = 2; n <= NF; n++) {
            if ($n ~ /^passed/) passed += $(n - 1)
            if ($n ~ /^(failed|timed)/) failed += $(n - 1)
            if ($n ~ /^skipped/) skipped += $(n - 1)
        }
    }
    END { printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped }' "$@"
}

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

# Where other people's programs are installed against which sign-in, provisioning and badges are tried.
counterparts() { realpath -sm "${CARGO_TARGET_DIR:-target}/counterparts"; }

# Makes a Python environment by a list of requirements, and makes it anew when the list has changed.
need_python_packages() {
    local environment=$1 list=$2
    cmp -s "$list" "$environment/ready" && return
    python3 -m venv "$environment"
    "$environment/bin/pip" install -q -r "$list"
    cp "$list" "$environment/ready"
}

# Installs a package of npm, by name and version, among the counterparts.
need_npm_package() {
    local folder package=$1 version=$2
    folder=$(counterparts)
    command -v npm >/dev/null || need_packages nodejs npm
    grep -qs "\"version\": \"$version\"" "$folder/node_modules/$package/package.json" && return
    say "Installing $package $version"
    mkdir -p "$folder"
    [ -e "$folder/package.json" ] || echo '{ "private": true }' > "$folder/package.json"
    npm install --prefix "$folder" --ignore-scripts --silent --no-audit --no-fund "$package@$version"
}

# Installs the OpenID provider of tests/counterparts.
need_oidc_provider() {
    need_npm_package oidc-provider 9.13.3
    [ "$(node -p 'process.versions.node.split(".")[0]')" -ge 20 ] || die "oidc-provider needs node 20 or newer"
}

# Installs the bridge and the identity provider of tests/counterparts.
need_bridge() {
    need_packages openssl python3-venv xmlsec1
    need_python_packages "$(counterparts)/venv" tests/counterparts/requirements.txt
}

# What is built for Windows, and with which programs.
# shellcheck disable=SC2034 # Some are used where this is sourced.
windows_triple=x86_64-pc-windows-gnu
windows_target=$(realpath -sm "${CARGO_TARGET_DIR:-target}")

# Debian's Rust, with the sources of its standard library, and MinGW's compilers and linker.
need_windows_toolchain() {
    local package
    # apt would remove these, which are older than what Stylet needs, in favour of rustc-web.
    for package in rustc cargo rustup; do
        ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' \
            || die "Debian's package $package excludes rustc-web, which builds for Windows; remove it first"
    done
    need_packages gcc libc6-dev pkg-config rustc-web cargo-web rust-web-src gcc-mingw-w64-x86-64-posix g++-mingw-w64-x86-64-posix
}

# Debian's cargo with Debian's rustc, also where another Rust comes first: their versions do not mix.
debian_cargo() {
    RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 RUSTC_WORKSPACE_WRAPPER='' CARGO_TARGET_DIR=$windows_target /usr/bin/cargo "$@"
}

# A command of cargo's for Windows. Debian has a standard library for Linux alone, so that one is built from its sources.
cargo_for_windows() {
    local command=$1
    shift
    debian_cargo "$command" -Z build-std=std,panic_unwind --release --locked --target "$windows_triple" "$@"
}

need_rust() {
    local wanted found
    wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    command -v cargo >/dev/null || die "Rust $wanted or newer is needed: https://rustup.rs"
    found=$(rustc --version | awk '{print $2}')
    [ "$(printf '%s\n%s\n' "$wanted" "$found" | sort -V | head -n 1)" = "$wanted" ] \
        || die "Rust $found is too old: $wanted or newer is needed (rustup update)"
}

# Finds cargo-nextest in the version that .config/nextest.toml names, or compiles it into the target folder.
need_nextest() {
    local wanted tools
    wanted=$(sed -n 's/^nextest-version = "\(.*\)"/\1/p' .config/nextest.toml)
    tools=$(realpath -sm "${CARGO_TARGET_DIR:-target}/tools")
    PATH=$tools/bin:$PATH
    [ "$(cargo nextest --version 2>/dev/null | awk 'NR == 1 { print $2 }')" = "$wanted" ] \
        || cargo install --quiet --locked --root "$tools" --version "$wanted" cargo-nextest
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
