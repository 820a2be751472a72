#!/bin/sh
# Makes this machine ready to build Etendue: finds or fetches Embree 4, and checks for
# cargo, compilers for C and C++ and the libclang with which bindgen reads Embree's headers.
#
#   scripts/setup.sh                            find Embree, or fetch it
#   EMBREE_DIR=/opt/embree scripts/setup.sh     take the one under /opt/embree, or fail
#
# In this order:
#   1. An Embree >= 4.0 is installed, or a private copy was made before: use it.
#   2. The distribution offers one (Debian 13, Ubuntu 24.04): install its package.
#   3. It does not, but this is a Debian (12): make a private copy under .embree/.
#   4. Otherwise: say what to install and how to build without Embree; exit 1.
#
# It installs nothing but packages of the distribution, as root or through sudo, and does
# nothing the second time. `make demo` and `make test` run it first.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
private=$root/.embree

# The two halves of a private copy. The library comes out of a Python wheel, the only place
# that builds a current Embree for an old glibc; the headers, which the wheel leaves out,
# come out of a newer Debian's package. No structure changed between their two versions.
wheel=embreex==4.4.0.post1
wheel_sha256=2cd0f7d5c6342e6247e31f700761689cae7829454d8c6de0c41e62124a023e1f
headers_suite=trixie
keyring=/usr/share/keyrings/debian-archive-keyring.gpg

no_embree="Without Embree, on a slower ray tracer, Etendue builds with a C compiler alone: \
cargo build --release --no-default-features"

say() { echo "setup: $*"; }
die() {
    echo "setup: $*" >&2
    exit 1
}

# --- Finding Embree: the places that embree4-sys/build.rs looks in, in its order. ---------

# Prints the version of the Embree under prefix $1; fails unless it is complete and >= 4.
embree_under() {
    version=$(sed -n 's/^#define RTC_VERSION_STRING "\(.*\)"/\1/p' \
        "$1/include/embree4/rtcore_config.h" 2>/dev/null) || return 1
    case $version in '' | [0-3].*) return 1 ;; esac
    for library in "$1"/lib/libembree4.* "$1"/lib64/libembree4.* "$1"/lib/*/libembree4.*; do
        case $library in *.so | *.dylib) [ -e "$library" ] && echo "$version" && return ;; esac
    done
    return 1
}

# Prints "version found: prefix" of the first Embree found; fails if there is none.
find_embree() {
    if [ -n "${EMBREE_DIR:-}" ]; then
        version=$(embree_under "$EMBREE_DIR") && echo "$version found: $EMBREE_DIR"
        return
    fi
    for prefix in $(pkg-config --variable=prefix embree4 2>/dev/null || true) \
        /usr /usr/local /opt/homebrew /opt/local; do
        version=$(embree_under "$prefix") && echo "$version found: $prefix" && return
    done
    # A private copy that lost or changed a byte since it was made does not count.
    version=$(embree_under "$private") &&
        (cd "$private" && sha256sum --check --status SHA256SUMS) &&
        echo "$version found: $private"
}

# --- What else a build needs. -------------------------------------------------------------

have_cc() { echo 'int main(void) { return 0; }' | cc -x c -o /dev/null - 2>/dev/null; }

# For FLIP, which is C++ (feature `flip` of Cargo.toml).
have_cxx() { printf '#include <vector>\nint main() {}\n' | c++ -x c++ -o /dev/null - 2>/dev/null; }

# bindgen loads libclang, which then needs the headers that clang brings along. Machines
# with an LLVM but no libclang are common (libclang-cpp is another library): look for files.
have_libclang() {
    [ -z "${LIBCLANG_PATH:-}" ] || return 0
    command -v apt-get >/dev/null || return 0 # Other systems keep it elsewhere; bindgen will say.
    for llvm in /usr/lib/llvm-*; do
        exists "$llvm"/lib/libclang.so* "$llvm"/lib/libclang-[0-9]*.so* &&
            exists "$llvm"/lib/clang/*/include/stddef.h && return
    done
    return 1
}

# Whether any of these files exists.
exists() {
    for file; do [ -e "$file" ] && return; done
    return 1
}

have_pip() { python3 -m pip --version >/dev/null 2>&1; }

# "debian", "ubuntu", ...; and the name of its release.
# shellcheck disable=SC1091
distribution=$(. /etc/os-release 2>/dev/null && echo "$ID") || true
# shellcheck disable=SC1091
release=$(. /etc/os-release 2>/dev/null && echo "${VERSION_CODENAME:-}") || true

# The major version of the libembree-dev that apt offers; empty if it knows of none.
offered() {
    apt-cache policy libembree-dev 2>/dev/null | sed -n 's/^  Candidate: \([0-9]*\)\..*/\1/p'
}

may_install() {
    [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null || { [ -t 0 ] && command -v sudo >/dev/null; }
}

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

update_package_lists() { as_root apt-get -qq update; }

# Installs these packages, or says in one sentence that they are missing.
install_packages() {
    command -v apt-get >/dev/null || die "please install compilers for C and C++, then run this again."
    may_install || die "please have an administrator run 'apt-get install $*', then run this" \
        "again. $no_embree"
    say "installing with apt: $*"
    update_package_lists
    as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq install --yes --no-install-recommends "$@" >/dev/null
}

# --- The private copy. --------------------------------------------------------------------

# The Debian mirror that this machine's apt takes its own suite from, even if it has no package
# lists yet.
debian_mirror() {
    # shellcheck disable=SC2016 # apt's own variables.
    apt-get indextargets --no-release-info --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' \
        'Created-By: Packages' |
        awk -v own="$release" \
            '($1 == own || $1 ~ /^(old)*stable$/) && $2 == "main" { print $3; exit }'
}

# apt with lists, cache and sources of its own in folder $work, so that it checks the newer
# suite's signatures as ever but the machine's own package lists never hear of that suite.
private_apt() {
    apt-get -qq -o Dir::State="$work/apt" -o Dir::Cache="$work/apt" \
        -o Dir::Etc::SourceList="$work/sources.list" -o Dir::Etc::SourceParts=/dev/null \
        -o Acquire::Languages=none -o APT::Sandbox::User=root "$@"
}

make_private_copy() {
    mirror=$(debian_mirror)
    [ -n "$mirror" ] || die "apt's sources name no Debian mirror for $release. $no_embree"

    # Everything happens in a temporary folder; the copy appears whole or not at all.
    work=$(mktemp -d "$root/.embree.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    trap 'exit 130' INT TERM
    mkdir -p "$work/apt/lists/partial" "$work/apt/archives/partial" "$work/copy/lib" \
        "$work/copy/include"

    say "fetching Embree's library (the Python wheel $wheel)"
    python3 -m pip --quiet --disable-pip-version-check download --dest "$work" --no-deps \
        --only-binary=:all: --python-version 3.11 --implementation cp \
        --platform manylinux_2_28_x86_64 "$wheel" || die "pip could not fetch $wheel. $no_embree"
    echo "$wheel_sha256 $(ls "$work"/embreex-*.whl)" | sha256sum --check --status ||
        die "the wheel $wheel is not the one this script knows: wrong SHA-256."
    python3 -m zipfile -e "$work"/embreex-*.whl "$work/wheel"
    mv "$work"/wheel/embreex.libs/* "$work/copy/lib"
    ln -s "$(basename "$work"/copy/lib/libembree4-*)" "$work/copy/lib/libembree4.so"

    say "fetching Embree's headers (Debian $headers_suite's libembree-dev, unpacked only)"
    echo "deb [signed-by=$keyring] $mirror $headers_suite main" >"$work/sources.list"
    { private_apt update && (cd "$work" && private_apt download libembree-dev); } ||
        die "apt could not fetch libembree-dev from $mirror. $no_embree"
    dpkg-deb --extract "$work"/libembree-dev_*.deb "$work/headers"
    mv "$work/headers/usr/include/embree4" "$work/copy/include"

    (cd "$work/copy" && find . -type f -exec sha256sum {} +) >"$work/SHA256SUMS"
    mv "$work/SHA256SUMS" "$work/copy"
    rm -rf "$private"
    mv "$work/copy" "$private"
}

# --- In order. ----------------------------------------------------------------------------

msrv=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$root/Cargo.toml")
command -v cargo >/dev/null || die "please install Rust $msrv or newer (with rustup), then run" \
    "this again."

missing= # What the system lacks, as Debian names the packages.
private_copy=no
have_cc || missing="gcc libc6-dev"
have_cxx || missing="$missing g++"
have_libclang || missing="$missing libclang-dev"

found=$(find_embree) || found=
if [ -z "$found" ]; then
    [ -z "${EMBREE_DIR:-}" ] ||
        die "there is no Embree >= 4 (include/embree4/, lib/libembree4.so) in EMBREE_DIR=$EMBREE_DIR."
    [ -n "$(offered)" ] || ! may_install || update_package_lists
    if [ "$(offered)" -ge 4 ] 2>/dev/null; then
        missing="$missing libembree-dev"
    elif [ "$distribution" = debian ] && [ "$(uname -m)" = x86_64 ]; then
        have_pip || missing="$missing python3-pip"
        private_copy=yes
    else
        die "please install Embree 4, or unpack Intel's release and set EMBREE_DIR to its folder," \
            "then run this again. $no_embree"
    fi
fi

# shellcheck disable=SC2086 # A list of words.
[ -z "$missing" ] || install_packages $missing
[ "$private_copy" = no ] || make_private_copy

[ -n "$found" ] || found=$(find_embree) || die "Embree was fetched but is not found: a bug here."
say "Embree $found"
