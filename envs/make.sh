#!/bin/sh
# Makes the environment .venv: `envs/make.sh [python]`. Everything is pinned and checked by hash.
# Does nothing where .venv holds all that the files ask for; .venv/made keeps their checksums.
set -eu
cd "$(dirname "$0")/.."
python=${1:-python3}

stop() {
    echo "vibrom: $*" >&2
    exit 1
}

packages=$(cat envs/requirements.txt envs/uv.txt | cksum)
project=$(cksum < pyproject.toml)
# An environment that was moved, or whose Python went, is made anew.
packages="$packages $PWD"
.venv/bin/python -c '' 2> /dev/null || rm -f .venv/made
made=$(cat .venv/made 2> /dev/null || true)
[ "$made" != "$packages $project" ] || exit 0

install_vibrom() {
    .venv/bin/python -m pip install -q --no-deps --no-build-isolation -e .
    echo "$packages $project" > .venv/made
}

# Only vibrom's own description has changed.
case $made in "$packages "*)
    install_vibrom
    exit 0
    ;;
esac

command -v "$python" > /dev/null || stop "no $python; install Python 3.11 or newer, or name one: make env PYTHON=python3.12"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
    || stop "$python is $("$python" -V); Python 3.11 or newer is needed: make env PYTHON=python3.12"

# install PACKAGES... FOR WHAT: from Debian's or Ubuntu's packages where we may, else say how.
install() {
    why=$1
    shift
    if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
    command -v apt-get > /dev/null || stop "$python $why; install your system's packages like $*"
    [ -z "$sudo" ] || sudo -n true 2> /dev/null || stop "$python $why; install it: sudo apt-get install $*"
    echo "Installing $*, as $python $why"
    { $sudo apt-get update -q && $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@"; } > /dev/null \
        || stop "$python $why; install it: ${sudo:+$sudo }apt-get install $*"
}

version=$("$python" -c 'import sys; print(f"{sys.version_info.major}.{sys.version_info.minor}")')
# Debian's and Ubuntu's python3 comes without the part of venv that brings pip.
"$python" -c 'import ensurepip' 2> /dev/null || install "has no ensurepip" "python$version-venv"
# One package of Snakemake's has no wheel yet for Python 3.14 and is compiled.
if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 14))' && ! command -v cc > /dev/null; then
    install "needs a C compiler" gcc libc6-dev "python$version-dev"
fi

echo "Making .venv with $("$python" -V); the packages take 6 GB, most of it torch's"
"$python" -m venv --clear .venv
.venv/bin/python -m pip install -q --require-hashes -r envs/uv.txt
# uv fetches and unpacks side by side; pip does the same more slowly where uv cannot (an index or proxy that only pip knows).
.venv/bin/uv pip install --python .venv/bin/python --compile-bytecode --require-hashes -r envs/requirements.txt \
    || .venv/bin/python -m pip install --require-hashes -r envs/requirements.txt
install_vibrom
