# Installs the system packages and .venv before the first build. Sourced by ./run, which
# sets root, venv, build, python, noetic and yes.
# shellcheck shell=bash disable=SC2154

# of apt, to install from a folder without internet
apt_options=()
# of pip: what it builds uses the setuptools of the distribution, because no hash is known of what
# it would download for that
pip_options=(--disable-pip-version-check --require-hashes --no-build-isolation)

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
    /DO NOT MATCH THE HASHES/ {is_changed = 1; next}
    is_changed && NF {sub(/ \(from .*/, ""); changed = $0; is_changed = 0}
    /(^E|[Ee]rror|ERROR|^sudo|fatal): / {found = $0}
    NF {last = $0}
    END {
      why = full ? full : changed ? changed : found ? found : last
      gsub(/^[[:space:]]+|[.[:space:]]+$/, "", why)
      print why
    }' "$1"
}

# logged NAME LOG COMMAND ...: runs a command with its output in build/LOG, on a terminal there too;
# ends with its reason.
logged() {
  local name=$1 log=$build/$2
  shift 2
  if [ -t 1 ]; then "$@" 2>&1 | tee "$log"; else "$@" >"$log" 2>&1; fi || failed "$name" "$log"
}

# failed NAME LOG: ends with the reason of a program whose output is in LOG; advice: what to do.
failed() {
  local why
  [ -t 1 ] || tail -n 20 "$2" >&2
  why=$(reason "$2")
  # then the log cannot say it
  [ "$(df -m --output=avail "$build" | tail -n 1)" -gt 0 ] || why="No space left on device"
  ! grep -q 'Retrying (' "$2" || advice=$(message 'is the package index reachable?')
  ! grep -q 'DO NOT MATCH THE HASHES' "$2" || advice=$(
    message 'it was changed on the way, since requirements/ has another hash: get it from another source')
  [ -z "${advice:-}" ] || why="${why:-?}; $advice"
  fail '{} failed: {}; see build/{}' "$1" "${why:-?}" "${2##*/}"
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

install_packages() {
  local advice=''
  if [ "$(id -u)" -ne 0 ]; then
    advice=$(message 'have the administrator run: {}' \
      "apt-get install --no-install-recommends $missing")
    command -v sudo >/dev/null ||
      fail 'system packages are missing, and there is no sudo: {}' "$advice"
  fi
  say '{} system packages of {} are missing: {}' "$(wc -w <<<"$missing")" "$(basename "$list")" \
    "$missing"
  may_install || fail 'nothing installed'
  say 'apt-get update and install, which takes some minutes; the output is in build/apt.log'
  as_root apt-get update -qq "${apt_options[@]}" >"$build/update.log" 2>&1 ||
    say 'apt-get update failed: {}; using the old lists' "$(reason "$build/update.log")"
  # shellcheck disable=SC2086
  logged apt-get apt.log as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q \
    --no-install-recommends -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=600 "${apt_options[@]}" $missing
}

# Asks if there is a terminal.
may_install() {
  local answer
  if [ -n "$yes" ] || [ -n "${CI:-}" ] || ! { [ -t 0 ] && [ -t 1 ]; }; then return 0; fi
  read -rp "$(message 'Install these? [Y/n]') " answer || return 1
  case $answer in '' | [yY]*) return 0 ;; *) return 1 ;; esac
}

# The lock file of the Python that ROS is installed for: all packages with the hashes of their files.
lock_file() {
  local version
  version=$(readlink -f "$python")
  printf '%s/requirements/%s.txt\n' "$root" "${version##*/python}"
}

has_venv() { cmp -s "$(lock_file)" "$venv/lock.txt"; }

make_venv() {
  local file
  file=$(lock_file)
  [ -f "$file" ] || fail '{} is missing: this Python is not one of {}' "${file#"$root"/}" \
    "$(cd "$root/requirements" && echo 3.*.txt)"
  say 'installing into .venv what {} lists, 540 MB, which takes some minutes; the output is in build/pip.log' "${file#"$root"/}"
  case $(uname -m)-${file##*/} in
    x86_64-3.8.txt | x86_64-3.11.txt) ;;
    *) say 'PyBullet is compiled, because it has no wheel for this system: 7 minutes of one core' ;;
  esac
  # a link leads to the environment of another clone
  [ ! -L "$venv" ] || rm "$venv"
  # without pip in it, it uses the distribution's pip and setuptools, which catkin needs
  logged "python3 -m venv" venv.log "$python" -m venv --clear --system-site-packages --without-pip \
    "$venv"
  touch "$venv/CATKIN_IGNORE"
  # where PyBullet is compiled: it has a wrong pointer type, which is an error since gcc 14
  CFLAGS="${CFLAGS:-} -Wno-incompatible-pointer-types" \
    logged pip pip.log "$venv/bin/python3" -m pip install --no-cache-dir "${pip_options[@]}" -r "$file"
  cp "$file" "$venv/lock.txt"
}

setup() {
  local list missing
  case $root in *[[:space:]]*) fail 'catkin cannot build in a path with spaces: {}' "$root" ;; esac
  mkdir -p "$build" "$devel"
  touch "$build/CATKIN_IGNORE" "$devel/CATKIN_IGNORE"
  find_missing
  [ -z "$missing" ] || install_packages
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
  say 'downloading into {}, which takes some minutes' "$folder"
  # An empty list of installed packages, so that apt takes all that the other computer may lack. Its
  # own lists, because those of the system may be old, or deleted as in a container. The locks of
  # apt are beside both, so this needs no rights of root.
  : >"$build/nothing_installed"
  mkdir -p "$build/download_lists/partial"
  apt_options+=(-o Dir::State::lists="$build/download_lists" -o Dir::Cache::pkgcache=
    -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root)
  logged 'apt-get update' update.log apt-get update -q "${apt_options[@]}"
  # shellcheck disable=SC2046
  logged apt-get download.log apt-get install -y -q --download-only --no-install-recommends \
    -o Dir::State::status="$build/nothing_installed" -o Dir::Cache::archives="$folder/packages" \
    "${apt_options[@]}" $(listed "$list")
  list_packages "$folder/packages" >"$build/Packages"
  mv "$build/Packages" "$folder/packages/Packages"
  logged pip wheels.log "$venv/bin/python3" -m pip download --no-deps "${pip_options[@]}" \
    -r "$(lock_file)" -d "$folder/wheels"
  platform >"$folder/platform"
  say 'complete; on the other computer: ./run setup --from FOLDER'
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
  pip_options+=(--no-index --find-links "$folder/wheels")
}
