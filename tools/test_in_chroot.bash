#!/usr/bin/env bash
# Runs a command, by default all tests, in a chroot of a Debian release.
#
# usage: test_in_chroot.bash RELEASE FOLDER [COMMAND ...]
#
#   RELEASE   bookworm (Debian 12) or trixie (Debian 13)
#   FOLDER    place of the chroot, which debootstrap makes there once; all of it takes 6 GB
#   COMMAND   command to run in the clone of this repository; by default setup, build and ./run test
#
# The chroot gets a clone of the commit that is checked out. Needs root and debootstrap. What the
# command starts ends with it.
set -euo pipefail

if [ $# -lt 2 ]; then sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0" >&2; exit 2; fi
release=$1 folder=$2
shift 2
root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
[ $# -gt 0 ] || set -- sh -c './run -y setup && ./run build && ./run test'

if [ ! -e "$folder/made" ]; then
  debootstrap --variant=minbase "$release" "$folder"
  touch "$folder/made"
fi
folder=$(readlink -f "$folder")
# certificates that the administrator has added, for example of a proxy
mkdir -p "$folder/usr/local/share"
cp -rT /usr/local/share/ca-certificates "$folder/usr/local/share/ca-certificates" 2>/dev/null || true
cp /etc/resolv.conf "$folder/etc/"
git init -q "$folder/root/img_recog"
git -C "$folder/root/img_recog" fetch -q "$root" HEAD
git -C "$folder/root/img_recog" checkout -q -f --detach FETCH_HEAD

# the mounts and processes end with unshare, which ignores all other signals
# shellcheck disable=SC2016
unshare --mount --pid --fork --kill-child bash -c '
  set -e
  mount -t proc proc "$0/proc"
  mount -t tmpfs tmpfs "$0/tmp"
  mount --rbind /dev "$0/dev"
  mount -t tmpfs tmpfs "$0/dev/shm"
  exec env -i HOME=/root TERM="${TERM:-dumb}" LANG=C.UTF-8 http_proxy="${http_proxy:-}" \
    https_proxy="${https_proxy:-}" PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    chroot "$0" sh -c "cd /root/img_recog && exec \"\$@\"" sh "$@"' "$folder" "$@" <&0 &
trap 'kill -9 $! 2>/dev/null' EXIT
trap 'exit 130' INT TERM HUP
wait $!
