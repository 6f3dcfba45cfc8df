#!/usr/bin/env bash
# The program of the image of the Dockerfile. Without words it is ./run demo; others are those of ./run.
set -euo pipefail

[ $# -gt 0 ] || set -- demo
if [ "$1" = demo ]; then
  # all addresses of the container, since Docker forwards a port of the host to one of them
  set -- demo web:=true web_host:=0.0.0.0 "${@:2}"
  export IMG_RECOG_PAGE_HOST=localhost
fi
exec "$(dirname "${BASH_SOURCE[0]}")/../run" "$@"
