#!/usr/bin/env bash
# Build MATIEC, a compiler of IEC 61131-3, in a folder, and print where BRISTLE_MATIEC then has to point. It is a tool of
# the tests only: under the GPL, never a dependency and never shipped. The source is a copy of BRISTLE_MATIEC_SOURCE where
# that names a folder, else a commit of its repository. Debian's packages are installed where root runs it.
#
#   BRISTLE_MATIEC=$(packaging/matiec.sh FOLDER)
set -euo pipefail
commit=6bb2c33
folder=${1:?the folder to build in}

tools=(flex bison autoconf automake make g++)
missing=()
for tool in "${tools[@]}"; do
  command -v "$tool" >/dev/null || missing+=("$tool")
done
if [ ${#missing[@]} -gt 0 ] && [ "$(id -u)" = 0 ]; then
  { apt-get update -qq && apt-get install -qq -y "${missing[@]}"; } >&2
fi
if [ -n "${BRISTLE_MATIEC_SOURCE:-}" ]; then
  cp -r "$BRISTLE_MATIEC_SOURCE" "$folder"
else
  git clone --quiet https://github.com/beremiz/matiec "$folder"
  git -C "$folder" checkout --quiet "$commit"
fi
cd "$folder"
if [ ! -x iec2c ]; then
  { autoreconf -i && ./configure && make -j2; } >&2
fi
pwd
