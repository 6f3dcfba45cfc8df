# Installs the system packages and .venv before the first build. Sourced by ./run, which
# sets root, venv, build, python, noetic and yes.
# shellcheck shell=bash disable=SC2154

# of apt and pip, to install from a folder without internet
apt_options=() pip_options=()

# measured, with Python 3.11: .venv, and what pip keeps in its temporary folder meanwhile
venv_mb=540 wheels_mb=70

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

# The last line of a log that says why a program failed: of an error, else any.
reason() {
  awk '/No space left on device/ {full = $0}
    /^CMake Error/ {is_next = 1; next}
    is_next && NF {found = $0; is_next = 0; next}
    /(^E|[Ee]rror|ERROR|^sudo|fatal): / {found = $0}
    NF {last = $0}
    END {
      why = full ? full : found ? found : last
      gsub(/^[[:space:]]+|[.[:space:]]+$/, "", why)
      print why
    }' "$1"
}

# logged NAME LOG COMMAND ...: runs a command with its output in build/LOG; ends with its reason.
logged() {
  local name=$1 log=$2
  shift 2
  "$@" >"$build/$log" 2>&1 || failed "$name" "$log"
}

# failed NAME LOG [ADVICE]: ends with the reason of a program whose output is in build/LOG.
failed() {
  local why
  tail -n 20 "$build/$2" >&2
  why=$(reason "$build/$2")
  # then the log cannot say it
  [ "$(df -m --output=avail "$build" | tail -n 1)" -gt 0 ] || why="No space left on device"
  [ -z "${3:-}" ] || fail '{} failed: {}; see build/{}; {}' "$1" "${why:-?}" "$2" "$3"
  fail '{} failed: {}; see build/{}' "$1" "${why:-?}" "$2"
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@" 9>&-; else sudo "$@" 9>&-; fi   # no service keeps the lock
}

# Sets `missing` to the system packages that are to be installed. Nothing is missing if nothing was
# last time, as build/installed says, and nothing has changed.
find_missing() {
  list=$root/packages-debian.txt
  [ ! -d "$noetic" ] || list=$root/packages-noetic.txt
  missing=
  if newer "$build/installed" "$list" /var/lib/dpkg/status /etc/hosts "$root/tools/packages.bash"
  then return 0; fi
  command -v apt-get >/dev/null ||
    fail 'no apt-get here: this needs Debian 12 or later, or Ubuntu 20.04 with ROS Noetic'
  missing=$(missing_packages "$list")
  # ROS resolves localhost and the host name, which fails in a bare debootstrap folder
  { getent hosts localhost && getent hosts "$(uname -n)"; } >/dev/null ||
    dpkg-query -W libnss-myhostname >/dev/null 2>&1 || missing="$missing libnss-myhostname"
  missing=$(xargs <<<"$missing")
  [ -n "$missing" ] || touch "$build/installed"
}

# Sets what apt would do, by a simulation, which needs no root: `packages`, download_mb and disk_mb.
# They are empty before the first apt-get update.
plan_packages() {
  # shellcheck disable=SC2086
  packages=$(LC_ALL=C apt-get install -s "${apt_options[@]}" --no-install-recommends $missing 2>/dev/null |
    sed -nE 's/^Inst ([^ ]+) (\[[^]]*\] )?\(([^ ]+) .*/\1=\3/p' || true)
  download_mb='' disk_mb=''
  [ -n "$packages" ] || return 0
  # shellcheck disable=SC2086
  read -r download_mb disk_mb < <(apt-cache show "${apt_options[@]}" $packages | awk '
    /^Package:/ {is_new = !seen[$2]++}
    is_new && /^Size:/ {download += $2 / 1e6}
    is_new && /^Installed-Size:/ {disk += $2 * 1024 / 1e6}
    END {printf "%.0f %.0f\n", download + 0.5, disk + 0.5}')
}

size_mb() { if [ -d "$1" ]; then du -smL "$1" | cut -f 1; else echo 0; fi; }

# need_space [FOLDER MB ...]: ends if a file system has less space than all that is needed there.
need_space() {
  local place free
  local -A needed=()
  while [ $# -gt 0 ]; do
    place=$(df --output=target "$1" 2>/dev/null | tail -n 1) || place=/
    needed[$place]=$((${needed[$place]:-0} + $2))
    shift 2
  done
  for place in "${!needed[@]}"; do
    free=$(($(df -m --output=avail "$place" | tail -n 1)))
    [ "$free" -ge "${needed[$place]}" ] ||
      fail 'not enough space on {}: {} MB are needed, {} MB are free' \
        "$place" "${needed[$place]}" "$free"
  done
}

install_packages() {
  local sudo=''
  [ "$(id -u)" -eq 0 ] || sudo='sudo '
  say '{}apt-get update, {}apt-get install; the full output is in build/apt.log' "$sudo" "$sudo"
  as_root apt-get update -qq "${apt_options[@]}" >"$build/update.log" 2>&1 ||
    say 'apt-get update failed: {}; using the old lists' "$(reason "$build/update.log")"
  if [ -z "$packages" ]; then
    plan_packages
    need_space /var/cache/apt "${download_mb:-0}" /usr "${disk_mb:-0}"
  fi
  # apt closes the Status-Fd for dpkg, whose scripts need their output, so it is another one; sudo
  # would close it
  # shellcheck disable=SC2016,SC2086
  as_root env DEBIAN_FRONTEND=noninteractive sh -c 'exec apt-get "$@" 3>&1' apt-get \
    install -y -q --no-install-recommends -o Dpkg::Use-Pty=0 -o APT::Status-Fd=3 \
    -o DPkg::Lock::Timeout=600 "${apt_options[@]}" $missing 2>&1 | show_apt "$build/apt.log" ||
    failed apt-get apt.log "$by_administrator"
}

# Says what will be installed. Estimate: a minute per 200 packages (on two cores) and per 300 MB.
announce() {
  local number count
  number=$(wc -w <<<"$missing")
  count=$(wc -w <<<"$packages")
  if [ -z "$packages" ]; then
    say '{} system packages of {} are missing; what they need is known after the first apt-get update' \
      "$number" "$(basename "$list")"
  else
    say '{} system packages of {} are missing, {} with dependencies:' \
      "$number" "$(basename "$list")" "$count"
    say 'download {} MB, {} MB on disk, about {} min' "$download_mb" "$disk_mb" \
      $((1 + count / 200 + download_mb / 300))
  fi
}

# Asks if there is a terminal.
may_install() {
  local answer
  if [ -n "$yes" ] || [ -n "${CI:-}" ] || ! { [ -t 0 ] && [ -t 1 ]; }; then return 0; fi
  read -rp "$(message 'Install these? [Y/n]') " answer || return 1
  case $answer in '' | [yY]*) return 0 ;; *) return 1 ;; esac
}

# Shows apt's progress, from lines like pmstatus:cmake:12.5:... that APT::Status-Fd adds.
show_apt() {
  local line part=-1 now word
  while IFS= read -r line; do
    printf '%s\n' "$line" >&3
    case $line in
      dlstatus:*) word=$(message 'downloading') ;;
      pmstatus:*) word=$(message 'installing') ;;
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

has_venv() { cmp -s "$root/requirements.txt" "$venv/requirements.txt"; }

make_venv() {
  say 'installing into .venv what requirements.txt lists, {} MB' "$venv_mb"
  # without pip in it, it uses the distribution's pip and setuptools, which catkin needs
  logged "python3 -m venv" venv.log "$python" -m venv --clear --system-site-packages --without-pip \
    "$venv"
  touch "$venv/CATKIN_IGNORE"
  # where PyBullet has no wheel (Python 3.13), pip compiles it, which takes minutes; it has a wrong
  # pointer type, which is an error since gcc 14
  CFLAGS="${CFLAGS:-} -Wno-incompatible-pointer-types" \
    "$venv/bin/python3" -m pip install --no-cache-dir --disable-pip-version-check \
    "${pip_options[@]}" -r "$root/requirements.txt" >"$build/pip.log" 2>&1 &
  show_pip $! "$build/pip.log" || pip_failed pip.log
  cp "$root/requirements.txt" "$venv/requirements.txt"
}

pip_failed() {
  local question=''
  ! grep -q 'Retrying (' "$build/$1" || question=$(message 'is the package index reachable?')
  failed pip "$1" "$question"
}

# Shows the elapsed time until pip ends; returns its exit code.
show_pip() {
  local start=$SECONDS compiling='' minutes=0
  trap 'kill "$pip" 2>/dev/null' EXIT
  pip=$1
  while kill -0 "$1" 2>/dev/null; do
    if [ -z "$compiling" ] && grep -q '^ *Building wheel' "$2" 2>/dev/null; then
      compiling=yes
      say 'there is no wheel for {}: compiling, about 10 min' "$("$python" -V)"
    fi
    if [ -t 1 ]; then
      printf '\r[run] %d s ' $((SECONDS - start))
    elif [ $(((SECONDS - start) / 60)) -gt "$minutes" ]; then
      minutes=$(((SECONDS - start) / 60))
      say '{} min' "$minutes"
    fi
    sleep 0.5
  done
  trap - EXIT
  if [ -t 1 ]; then printf '\n'; fi
  wait "$1"
}

setup() {
  local list missing packages download_mb disk_mb by_administrator='' space=()
  case $root in *[[:space:]]*) fail 'catkin cannot build in a path with spaces: {}' "$root" ;; esac
  mkdir -p "$build" "$devel"
  touch "$build/CATKIN_IGNORE" "$devel/CATKIN_IGNORE"
  find_missing
  if [ -n "$missing" ]; then
    if [ "$(id -u)" -ne 0 ]; then
      by_administrator=$(message 'have the administrator run: {}' \
        "apt-get install --no-install-recommends $missing")
      command -v sudo >/dev/null ||
        fail 'system packages are missing, and there is no sudo: {}' "$by_administrator"
    fi
    plan_packages
    announce
    has_venv || say 'then Python packages into .venv: {} MB on disk' "$venv_mb"
    space=(/var/cache/apt "${download_mb:-0}" /usr "${disk_mb:-0}")
  fi
  has_venv || space+=("$root" "$((venv_mb - $(size_mb "$venv")))" "${TMPDIR:-/tmp}" "$wheels_mb")
  need_space "${space[@]}"
  if [ -n "$missing" ]; then
    may_install || fail 'nothing installed; needed are: {}' "$missing"
    install_packages
  fi
  has_venv || make_venv
}

# What a folder of `download` is for: its packages and wheels fit no other distribution.
platform() {
  # shellcheck disable=SC1091
  ( . /etc/os-release; printf '%s %s %s\n' "$ID" "$VERSION_ID" "$(dpkg --print-architecture)" )
}

# Fills a folder with all that setup installs, for computers of this kind without internet.
download() {
  local folder list=$root/packages-debian.txt
  [ ! -d "$noetic" ] || list=$root/packages-noetic.txt
  setup
  mkdir -p "$1/packages/partial" "$1/wheels" || fail 'cannot write in {}' "$1"
  folder=$(readlink -f "$1")
  say 'downloading into {}' "$folder"
  : >"$build/nothing_installed"         # so that apt takes all that the other computer may lack
  # shellcheck disable=SC2046
  logged apt-get download.log as_root apt-get install -y -q --download-only --no-install-recommends \
    -o Dir::State::status="$build/nothing_installed" -o Dir::Cache::archives="$folder/packages" \
    -o APT::Sandbox::User=root $(listed "$list")
  list_packages "$folder/packages" >"$build/Packages"
  mv "$build/Packages" "$folder/packages/Packages"
  "$venv/bin/python3" -m pip wheel --disable-pip-version-check -r "$root/requirements.txt" \
    -w "$folder/wheels" >"$build/wheels.log" 2>&1 || pip_failed wheels.log
  platform >"$folder/platform"
  say 'complete, {} MB; on the other computer: ./run setup --from FOLDER' "$(size_mb "$folder")"
}

# Prints the index that apt reads in a folder of packages.
list_packages() {
  local file
  for file in "$1"/*.deb; do
    dpkg-deb -f "$file"
    printf 'Filename: ./%s\nSize: %s\nSHA256: %s\n\n' "${file##*/}" "$(stat -c %s "$file")" \
      "$(sha256sum "$file" | cut -d ' ' -f 1)"
  done
}

# Has setup install from a folder of `download`, and from nowhere else.
install_from() {
  local folder
  folder=$(readlink -f "$1")
  [ -f "$folder/platform" ] || fail '{} is no folder that ./run setup --download has filled' "$1"
  [ "$(cat "$folder/platform")" = "$(platform)" ] ||
    fail '{} is for {}, and this computer is {}' "$1" "$(cat "$folder/platform")" "$(platform)"
  # apt and pip split a path at its spaces
  ln -sfn "$folder" "$build/offline"
  folder=$build/offline
  mkdir -p "$build/lists/partial"
  printf 'deb [trusted=yes] file:%s ./\n' "$folder/packages" >"$build/offline.list"
  apt_options=(-o Dir::Etc::sourcelist="$build/offline.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$build/lists" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
    -o APT::Sandbox::User=root)
  pip_options=(--no-index --find-links "$folder/wheels")
}
