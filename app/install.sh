# shellcheck shell=bash
# Installs what a fresh machine lacks. app/run, tests/run and .ci/run source this and call
# `install_for headless|window|tests|ci [c++] [denoiser]`. It speaks on stderr only: stdout belongs to the program.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." >/dev/null && pwd)
needed_rust=$(sed -n 's/^rust-version = "\([0-9]*\.[0-9]*\).*/\1/p' "$root/Cargo.toml")

# Cargo runs in the repository, but a relative folder was meant from where the caller stands.
if [[ -n ${CARGO_TARGET_DIR-} && $CARGO_TARGET_DIR != /* && $CARGO_TARGET_DIR != ?:* ]]; then
    export CARGO_TARGET_DIR=$PWD/$CARGO_TARGET_DIR
fi

say() { printf '%s\n' "$@" >&2; }

# Installs what it can; what is left for the user to do is said in one go, with exact words, and ends the script.
install_for() {
    local packages=() lacking=() as_root=() to_do=() updated=
    # Windows and macOS bring everything but Rust along.
    if [[ $(uname -s) == Linux ]]; then
        find_lacking "$@"
        if command -v apt-get >/dev/null; then
            rust_is_new_enough || has_rustup || find_rustup_package
            install_packages
        elif ((${#lacking[@]})); then
            say "This machine may lack: $(list "${lacking[@]}"). Only Debian's and Ubuntu's packages are known here; going on."
        fi
    fi
    rust_is_new_enough || install_rust
    ! wants_denoiser "$@" || bring_denoiser "$1"
    ((${#to_do[@]} == 0)) || { say "${to_do[@]}" "Then run this again."; exit 1; }
}

list() { local text; printf -v text '%s, ' "$@"; printf '%s' "${text%, }"; }

# ---- What is there? Only cheap looks, since this runs before every start.

find_lacking() {
    need ca-certificates "TLS certificates" has_certificates
    # Wayland's library is bound by a little C.
    # Open Image Denoise comes by pip; a window that has to ask for pip goes without.
    if wants_denoiser "$@" && { [[ $1 == tests || $1 == ci ]] || become_root; }; then
        need python3-pip "pip (for Open Image Denoise)" python3 -m pip --version
    fi
    need gcc "a linker and a C compiler (cc)" command -v cc
    need libc6-dev "the C library's development files" can_link
    [[ " $* " != *" c++ "* ]] || need g++ "a C++ compiler (c++)" command -v c++
    [[ $1 != headless ]] || return 0

    # The program opens these by name when it runs, so no link step notices that one is missing.
    # ldconfig is not on a user's PATH on Debian.
    local libraries pair
    libraries=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null || true)
    for pair in libvulkan.so.1=libvulkan1 \
        libX11.so.6=libx11-6 libX11-xcb.so.1=libx11-xcb1 libXcursor.so.1=libxcursor1 libXi.so.6=libxi6 \
        libxkbcommon.so.0=libxkbcommon0 libxkbcommon-x11.so.0=libxkbcommon-x11-0 \
        libwayland-client.so.0=libwayland-client0; do
        need "${pair#*=}" "${pair%=*}" has_library "${pair%=*}"
    done
    need mesa-vulkan-drivers "a Vulkan driver" has_vulkan_driver

    if [[ $1 == tests || $1 == ci ]]; then
        need xvfb Xvfb command -v Xvfb
        need xauth xauth command -v xauth
        need xdotool xdotool command -v xdotool
        need imagemagick "ImageMagick (import)" command -v import
        need spirv-tools spirv-val command -v spirv-val
    fi
    if [[ $1 == ci ]]; then
        need shellcheck shellcheck command -v shellcheck
        need codespell codespell command -v codespell
        need pyflakes3 pyflakes command -v pyflakes3
    fi
}

# need PACKAGE WHAT CHECK...: where the check fails, Debian's PACKAGE brings WHAT.
need() {
    local package=$1 what=$2
    shift 2
    "$@" >/dev/null 2>&1 || { packages+=("$package"); lacking+=("$what"); }
}

# Without certificates neither rustup nor cargo can fetch anything.
has_certificates() { [[ -n ${SSL_CERT_FILE-}${CARGO_HTTP_CAINFO-} ]] || compgen -G '/etc/ssl/certs/*'; }

# A compiler alone links nothing: crt1.o comes with the C library's development files.
can_link() {
    local crt
    crt=$(cc -print-file-name=crt1.o) && [[ -e $crt ]]
}

has_library() { [[ $libraries == *$'\t'"$1 "* ]]; }

has_vulkan_driver() {
    [[ -n ${VK_DRIVER_FILES-}${VK_ICD_FILENAMES-} ]] && return
    local folder
    for folder in /etc /usr/share /usr/local/share "${HOME-}/.local/share" /run/opengl-driver/share; do
        compgen -G "$folder/vulkan/icd.d/*.json" && return
    done
    return 1
}

# Asked from the repository, where a rust-toolchain.toml may choose.
rust_is_new_enough() {
    local version
    version=$(cd "$root" && command -v cargo >/dev/null && rustc --version 2>/dev/null) || return 1
    [[ $version =~ ^rustc\ ([0-9]+)\.([0-9]+) ]] || return 1
    ((BASH_REMATCH[1] > ${needed_rust%.*} ||
        (BASH_REMATCH[1] == ${needed_rust%.*} && BASH_REMATCH[2] >= ${needed_rust#*.})))
}

has_rustup() {
    # It may be missing from the PATH (CI, a shell older than rustup) or come after a distribution's old Rust.
    local folder=${CARGO_HOME:-${HOME-}/.cargo}/bin
    [[ ! -x $folder/rustup ]] || PATH=$folder:$PATH
    command -v rustup >/dev/null
}

# ---- Open Image Denoise: tests need it, the window and `render --denoise` take it where it can be had

# Where the program looks too, among other places.
denoisers=${XDG_CACHE_HOME:-${HOME-}/.cache}/towel-designer/open-image-denoise

wants_denoiser() {
    [[ $(uname -s) == Linux ]] && [[ $1 != headless || " $* " == *" denoiser "* ]] && ! has_denoiser
}

# A file that is named is the user's own affair.
has_denoiser() {
    [[ -n ${OIDN_LIBRARY+named} ]] || compgen -G "$denoisers/*/lib/libOpenImageDenoise.so.2" >/dev/null ||
        [[ $(PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null) == *libOpenImageDenoise.so.2\ * ]]
}

# Takes the library out of the wheel of PyPI's pyoidn, whose versions are the library's with a number behind them.
bring_denoiser() {
    local version=2.5.1 scratch why
    mkdir -p "$denoisers" && scratch=$(mktemp -d -p "$denoisers" .new.XXXXXX) || return 0
    say "Bringing Open Image Denoise $version (some 90 MB, once)"
    # -T: not into a folder of that name, should another run have been faster.
    if why=$(unpack_denoiser "$version" "$scratch" 2>&1) && mv -T "$scratch" "$denoisers/$version"; then
        return
    fi
    rm -rf "$scratch"
    why=${why##*$'\n'}
    if [[ $1 == tests || $1 == ci ]]; then
        to_do+=("Open Image Denoise could not be brought ($why). With the network up run this again, or set OIDN_LIBRARY to" \
            "the file libOpenImageDenoise.so.2 of a version 2 that you have.")
    else
        say "It could not be brought ($why); going on without."
    fi
}

# unpack_denoiser VERSION FOLDER: makes FOLDER/lib. Its parts look for each other in ../lib.
unpack_denoiser() {
    local file shorter
    cd "$2" || return
    python3 -m pip download -q --disable-pip-version-check --no-deps --only-binary :all: --retries 1 --timeout 15 \
        "pyoidn==$1.*" || return
    python3 -m zipfile -e pyoidn-*.whl wheel && mv wheel/pyoidn/oidn/lib lib && [[ -e lib/libOpenImageDenoise.so.2 ]] || return
    rm -rf lib/cmake wheel pyoidn-*.whl
    # A wheel has copies where there were links.
    for file in lib/*.so.*; do
        for shorter in "${file%%.so.*}".so "${file%.*}" "${file%.*.*}"; do
            [[ ! -f $shorter ]] || ! cmp -s "$file" "$shorter" || ln -f "$file" "$shorter"
        done
    done
}

# ---- Install

# Later Debians and Ubuntus have rustup as a package; a fresh machine only knows so after an update.
find_rustup_package() {
    ! become_root || update
    [[ -z $(apt-cache show rustup 2>/dev/null) ]] || need rustup "Rust $needed_rust" false
}

install_packages() {
    ((${#packages[@]})) || return 0
    local command="apt-get install -y --no-install-recommends ${packages[*]}"
    say "This machine lacks: $(list "${lacking[@]}")."
    if ! become_root; then
        to_do+=("Run:" "    sudo apt-get update && sudo $command")
        return
    fi
    say "Installing: ${packages[*]}"
    update
    # --no-remove: nothing of the user's is taken away unasked.
    apt install -qy --no-install-recommends --no-remove "${packages[@]}" ||
        to_do+=("The installation failed, for the reason above. As root, run:" "    $command")
}

become_root() {
    ((EUID)) || return 0
    as_root=(sudo -n)
    "${as_root[@]}" true 2>/dev/null
}

# One broken package source of the user's must not stop the others.
update() {
    [[ -z $updated ]] || return 0
    updated=yes
    apt update -q || say "apt-get update failed; going on with the package lists that are here."
}

apt() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 "$@" </dev/null >&2
}

install_rust() {
    if has_rustup; then
        rust_is_new_enough && return
        # A stable one beside an older default or pin serves this run, and changes neither.
        export RUSTUP_TOOLCHAIN=stable
        rust_is_new_enough && return
        # This replaces an older stable for all of the user's projects, so it is said.
        say "Rust $needed_rust or later is needed: installing or updating rustup's stable toolchain."
        rustup toolchain install stable --profile minimal --no-self-update </dev/null >&2 && rust_is_new_enough && return
        to_do+=("rustup could not bring Rust $needed_rust or later. With the network up, run:" "    rustup update stable")
    elif [[ " ${packages[*]-} " != *" rustup "* ]]; then
        local found
        found=$(rustc --version 2>/dev/null) || found="no Rust"
        to_do+=("Rust $needed_rust or later is needed (here: $found). Install it as https://rustup.rs says:")
        case $(uname -s) in
            Linux | Darwin) to_do+=("    curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y") ;;
            *) to_do+=("    download rustup-init.exe from https://rustup.rs and run it") ;;
        esac
    fi
}
