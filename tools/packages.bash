# Installs the system packages and .venv before the first build. Sourced by ./run, which
# sets root, venv, build, python, noetic and yes.
# shellcheck shell=bash disable=SC2154

listed() { sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "$1"; }

# newer STAMP FILE...: whether all exist and the stamp is newer than each file
newer() {
  local stamp=$1 file
  shift
  [ -f "$stamp" ] || return 1
  for file; do [ -e "$file" ] && [ "$stamp" -nt "$file" ] || return 1; done
}

missing_packages() {
  local installed
  installed=$(dpkg-query -W -f='${db:Status-Abbrev} ${Package}\n' 2>/dev/null | awk '/^ii/{print $2}')
  comm -13 <(sort -u <<<"$installed") <(listed "$1" | sort -u)
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@" 9>&-           # a service that a package starts must not keep the lock
  else
    command -v sudo >/dev/null || fail "need root for: $*; install sudo or run ./run setup as root"
    sudo "$@" 9>&-
  fi
}

# Does nothing if nothing was missing last time, as build/installed says, and nothing has changed.
install_packages() {
  local list missing plan sudo=''
  list=$root/packages-debian.txt
  [ ! -d "$noetic" ] || list=$root/packages-noetic.txt
  if newer "$build/installed" "$list" /var/lib/dpkg/status /etc/hosts "$root/tools/packages.bash"
  then return 0; fi
  [ "$(id -u)" -eq 0 ] || sudo='sudo '
  command -v apt-get >/dev/null ||
    fail "no apt-get here: this needs Debian 12 or later, or Ubuntu 20.04 with ROS Noetic"
  missing=$(missing_packages "$list")
  # ROS resolves localhost and the host name, which fails in a bare debootstrap folder
  { getent hosts localhost && getent hosts "$(uname -n)"; } >/dev/null ||
    dpkg-query -W libnss-myhostname >/dev/null 2>&1 || missing="$missing libnss-myhostname"
  missing=$(xargs <<<"$missing")
  [ -n "$missing" ] || { touch "$build/installed"; return 0; }
  plan=$(apt_plan "$missing")
  if [ -z "$plan" ]; then           # the package lists were never downloaded
    say "reading the package lists: ${sudo}apt-get update"
    as_root apt-get update -qq || fail "apt-get update failed"
    plan=$(apt_plan "$missing")
  fi
  announce "$list" "$missing" "$plan"
  may_install || fail "nothing installed; needed are: $missing"
  say "${sudo}apt-get update, ${sudo}apt-get install; the full output is in build/apt.log"
  as_root apt-get update -qq || say "apt-get update failed; using the old lists"
  # shellcheck disable=SC2086
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends -o Dpkg::Use-Pty=0 -o APT::Status-Fd=1 $missing |
    show_apt "$build/apt.log" ||
    fail "apt-get failed, see build/apt.log; are all Debian (or ROS) package sources enabled?"
}

# Prints apt's lines with the number of packages, the download and the size on disk.
apt_plan() {
  # shellcheck disable=SC2086
  LC_ALL=C apt-get install --assume-no --no-install-recommends $1 2>/dev/null |
    grep -E '^[0-9]+ upgraded|^Need to get|^After this' || true
}

# Says what will be installed. Estimate: a minute per 200 packages (on two cores) and per 300 MB.
announce() {
  local list=$1 missing=$2 plan=$3 packages download disk megabytes
  packages=$(sed -nE 's/.* ([0-9]+) newly installed.*/\1/p' <<<"$plan")
  download=$(sed -nE 's/^Need to get ([0-9.,]+ k?M?G?B).*/\1/p' <<<"$plan")
  disk=$(sed -nE 's/^After this operation, ([0-9.,]+ k?M?G?B) .*/\1/p' <<<"$plan")
  packages=${packages:-$(wc -w <<<"$missing")}
  megabytes=$(awk '/GB/{gsub(",","",$1); print int($1 * 1000)} /MB/{gsub(",","",$1); print int($1)}' \
    <<<"$download")
  say "$(wc -w <<<"$missing") system packages of $(basename "$list") are missing," \
    "$packages with dependencies:"
  say "download ${download:-of unknown size}, ${disk:-unknown size} on disk," \
    "about $((1 + packages / 200 + ${megabytes:-0} / 300)) min"
}

# Asks if there is a terminal.
may_install() {
  local answer
  if [ -n "$yes" ] || [ -n "${CI:-}" ] || ! { [ -t 0 ] && [ -t 1 ]; }; then return 0; fi
  read -rp "Install these? [Y/n] " answer || return 1
  case $answer in '' | [yY]*) return 0 ;; *) return 1 ;; esac
}

# Shows apt's progress, from lines like pmstatus:cmake:12.5:... that APT::Status-Fd adds.
show_apt() {
  local line part=-1 now word
  while IFS= read -r line; do
    printf '%s\n' "$line" >&3
    case $line in
      dlstatus:*) word=downloading ;;
      pmstatus:*) word=installing ;;
      *) continue ;;
    esac
    line=${line#*:*:}
    now=$word\ ${line%%[.:]*}
    if [ -t 1 ]; then
      printf '\r\033[K[run] %s %%: %.60s' "$now" "${line#*:}"
    elif [ "${now%?}" != "$part" ]; then    # a line per 10 %
      say "$now %"
      part=${now%?}
    fi
  done 3>"$1"
  if [ -t 1 ]; then printf '\n'; fi
}

make_venv() {
  ! cmp -s "$root/requirements.txt" "$venv/requirements.txt" || return 0
  say "installing into .venv: $(listed "$root/requirements.txt" | xargs)"
  # without pip in it, it uses the distribution's pip and setuptools, which catkin needs
  "$python" -m venv --clear --system-site-packages --without-pip "$venv"
  touch "$venv/CATKIN_IGNORE"
  # where PyBullet has no wheel (Python 3.13), pip compiles it, which takes minutes; it has a wrong
  # pointer type, which is an error since gcc 14
  CFLAGS="${CFLAGS:-} -Wno-incompatible-pointer-types" \
    "$venv/bin/python3" -m pip install --no-cache-dir --disable-pip-version-check \
    -r "$root/requirements.txt" >"$build/pip.log" 2>&1 &
  show_pip $! "$build/pip.log" ||
    { tail -n 5 "$build/pip.log" >&2; fail "pip failed, see build/pip.log; is the package index reachable?"; }
  cp "$root/requirements.txt" "$venv/requirements.txt"
}

# Shows the elapsed time until pip ends; returns its exit code.
show_pip() {
  local start=$SECONDS compiling='' minutes=0
  trap 'kill "$pip" 2>/dev/null' EXIT
  pip=$1
  while kill -0 "$1" 2>/dev/null; do
    if [ -z "$compiling" ] && grep -q '^ *Building wheel' "$2" 2>/dev/null; then
      compiling=yes
      say "there is no wheel for $("$python" -V): compiling, about 10 min"
    fi
    if [ -t 1 ]; then
      printf '\r[run] %d s ' $((SECONDS - start))
    elif [ $(((SECONDS - start) / 60)) -gt "$minutes" ]; then
      minutes=$(((SECONDS - start) / 60))
      say "$minutes min"
    fi
    sleep 0.5
  done
  trap - EXIT
  if [ -t 1 ]; then printf '\n'; fi
  wait "$1"
}

setup() {
  case $root in *[[:space:]]*) fail "catkin cannot build in a path with spaces: $root" ;; esac
  mkdir -p "$build" "$devel"
  touch "$build/CATKIN_IGNORE" "$devel/CATKIN_IGNORE"
  install_packages
  make_venv
}
