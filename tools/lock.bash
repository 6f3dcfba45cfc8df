#!/usr/bin/env bash
# Writes requirements/3.*.txt: the newest versions of all Python packages that requirements.txt and
# requirements/system.txt allow, and the hashes of their files. uv, which does this, comes into build/.
#
# usage: lock.bash [PACKAGE ...]
#
#   PACKAGE   the only package that gets a newer version, by default all
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."

[ -x build/uv/bin/uv ] || /usr/bin/python3 -m pip install -q --target build/uv uv==0.13.9
newer=(--upgrade)
[ $# -eq 0 ] || newer=("${@/#/--upgrade-package=}")
for version in 3.8 3.11 3.13; do
  mapfile -t names < <(sed -n "s/^\(.*\)==.* == \"$version\"$/--no-emit-package=\1/p" requirements/system.txt)
  build/uv/bin/uv pip compile --quiet --no-config --no-python-downloads --python-version "$version" \
    --generate-hashes --no-annotate --custom-compile-command tools/lock.bash "${newer[@]}" \
    --constraint requirements/system.txt "${names[@]}" --output-file "requirements/$version.txt" \
    requirements.txt
done
