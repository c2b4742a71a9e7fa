#!/bin/sh
# Installs what `make test` needs beyond Python packages: compilers for the PC and both boards, and the
# emulators simavr and QEMU.
# With apt (Debian, Ubuntu) it installs what is missing, as root or through sudo; elsewhere it says what to
# install and why, and fails. When nothing is missing it does nothing.
set -eu

# package                               purpose
packages='
g++                                     C++ compiler: the emulated robot and the firmware cores on the PC
make                                    builds
python3-venv                            virtual environments for Debian'"'"'s Python
gcc-avr                                 compiler for the Arduino Micro (sequencer)
avr-libc                                C library for the Arduino Micro
arduino-core-avr                        Arduino core for the Arduino Micro
simavr                                  simulator that runs the Arduino Micro image
libsimavr-dev                           headers of that simulator
libelf-dev                              reads images for that simulator
avrdude                                 writes the Arduino Micro'"'"'s flash, as tfsat-host flash does
gcc-arm-none-eabi                       compiler for the Teensy 4.1 (logger)
libnewlib-arm-none-eabi                 C library for the Teensy 4.1
libstdc++-arm-none-eabi-newlib          C++ library for the Teensy 4.1
qemu-system-arm                         emulator that runs the logger'"'"'s core on a Cortex-M7
clang                                   compiler with libFuzzer, for the fuzz tests
chromium                                browser that opens the report page
llvm                                    names functions and lines in what a sanitizer reports
'

names() { printf '%s' "$packages" | awk 'NF { print $1 }'; }

say_what_to_install() {
    {
        echo "Error: $1"
        echo "  The tests build both firmwares and run them; without these tools nothing is proved."
        echo "  Install what does the following (names as in Debian 12), then run the same command again:"
        printf '%s' "$packages" | sed '/^$/d; s/^/    /'
    } >&2
    exit 1
}

if ! command -v dpkg-query >/dev/null 2>&1 || ! command -v apt-get >/dev/null 2>&1; then
    # No apt: believe what can be seen, by its commands.
    for tool in g++ make avr-gcc simavr avrdude arm-none-eabi-g++ qemu-system-arm clang++ chromium; do
        command -v "$tool" >/dev/null 2>&1 || say_what_to_install "$tool is missing, and this system has no apt."
    done
    echo "toolchain: no apt here; the commands are present, libraries are taken on trust" >&2
    exit 0
fi

missing=
for name in $(names); do
    state=$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null || true)
    [ "$state" = installed ] || missing="$missing $name"
done

# libFuzzer and the sanitizers come with clang or, as in Debian 12, in a package named after its version.
has_fuzzer() {
    resources=$(clang++ -print-resource-dir) && [ -n "$(find "$resources/" -name 'libclang_rt.fuzzer*')" ]
}
runtime() { echo "libclang-rt-$(clang++ -dumpversion | cut -d . -f 1)-dev"; }

if [ -z "$missing" ]; then
    ! has_fuzzer || exit 0
    missing=" $(runtime)"
fi

as_root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || say_what_to_install "packages are missing ($missing ) and there is no sudo."
    as_root=sudo
fi

echo "toolchain: installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get \
        -o Acquire::Retries=3 -o DPkg::Lock::Timeout=120 -qq "$@" </dev/null >>"$log" 2>&1
}
install() {
    apt install --yes --no-install-recommends "$@" || { cat "$log" >&2; say_what_to_install "apt could not install: $*"; }
}
apt update || { cat "$log" >&2; say_what_to_install "apt could not fetch its lists of packages."; }
# shellcheck disable=SC2086  # the list of names is meant to be split
install $missing
has_fuzzer || install "$(runtime)"
has_fuzzer || say_what_to_install "clang++ is here, but not its libFuzzer."
echo "toolchain: done"
