#!/bin/sh
# Unpack libLLVM 19 and what it needs into a folder, without root: fetch_llvm.sh DEST
#
# Mitsuba's LLVM variant loads libLLVM when it starts, and versions before 19 abort the process.
# Nothing is done where the system or DEST has a usable one. Failure is no error: publishing works
# without a renderer, so one line says what is missing and the exit status is 0.

set -u
dest=${1:?usage: fetch_llvm.sh DEST}
package=libllvm19

give_up() {
    echo "fetch_llvm: $1; render needs $package (apt-get install $package), publish works without" >&2
    exit 0
}

loads() { # every shared library that $1 asks for is found
    LD_LIBRARY_PATH="$dest" ldd "$1" 2>/dev/null | grep -q '=>' &&
        ! LD_LIBRARY_PATH="$dest" ldd "$1" 2>/dev/null | grep -q 'not found'
}

usable_in() { # a folder of "$@" holds a libLLVM of version 19 or newer that loads
    for folder in "$@"; do
        for library in "$folder"/libLLVM.so.[0-9]* "$folder"/libLLVM-[0-9]*.so*; do
            [ -e "$library" ] || continue
            major=$(basename "$library" | sed -E 's/^libLLVM(\.so\.|-)([0-9]+).*/\2/')
            [ "$major" -ge 19 ] 2>/dev/null && loads "$library" && return 0
        done
    done
    return 1
}

usable_in /usr/lib/*-linux-gnu /usr/lib64 /usr/lib /usr/local/lib /usr/lib/llvm-*/lib "$dest" &&
    exit 0

for tool in apt-get apt-cache dpkg ldd; do
    command -v "$tool" >/dev/null 2>&1 || give_up "$tool is not here"
done
if ! apt-cache show "$package" >/dev/null 2>&1; then
    [ "$(id -u)" = 0 ] || give_up "the package lists are missing or do not know $package"
    apt-get -qq update >/dev/null 2>&1 || give_up "apt-get update failed"
fi

work=$(mktemp -d) || give_up "no temporary folder"
trap 'rm -rf "$work"' EXIT INT TERM

unpack() { # download the package $1 and lay its shared libraries flat into $work/flat
    rm -rf "$work/deb" && mkdir -p "$work/deb" "$work/flat" || return 1
    # apt drops its rights for a download where it can, and needs a folder open to all for that.
    chmod 755 "$work" && chmod 777 "$work/deb"
    (cd "$work/deb" && apt-get -qq download "$1" >/dev/null 2>&1) || return 1
    for archive in "$work"/deb/*.deb; do
        dpkg -x "$archive" "$work/deb/root" || return 1
    done
    find "$work/deb/root" \( -type f -o -type l \) -name '*.so*' ! -path '*/llvm-*/*' \
        -exec cp -P {} "$work/flat/" \;
}

unpack "$package" || give_up "$package could not be downloaded"
library=$(find "$work/flat" -name 'libLLVM.so.19*' -type f | head -n 1)
[ -n "$library" ] || give_up "$package holds no libLLVM"

# Fetch what ldd misses, package by package, until nothing is missing or nothing new is found.
tried=" $package "
while missing=$(LD_LIBRARY_PATH="$work/flat" ldd "$library" | awk '/not found/ { print $1 }') &&
    [ -n "$missing" ]; do
    before=$tried
    wanted=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts \
        --no-breaks --no-replaces --no-enhances "$package" | grep '^lib' | sort -u)
    for soname in $missing; do
        stem=$(echo "$soname" | sed -E 's/\.so.*//; s/_/-/g' | tr '[:upper:]' '[:lower:]')
        # Debian puts the ICU libraries, libicuuc and its like, together in libicu<version>.
        case $stem in libicu*) stem=libicu ;; esac
        for name in $(echo "$wanted" | grep -E "^$stem([-0-9.a-z]*)$"); do
            case $tried in *" $name "*) continue ;; esac
            tried="$tried$name "
            unpack "$name" || true
        done
    done
    [ "$tried" != "$before" ] || give_up "no package was found for $(echo $missing)"
done

mkdir -p "$dest" && cp -P "$work"/flat/* "$dest"/ || give_up "$dest cannot be written"
echo "fetch_llvm: $package is in $dest"
