#!/bin/sh
# Makes a workspace with img_recog and this package, builds it, and runs the tests of this package.
# On Debian 12 or later, also as root in an empty container. Usage: ci.sh [get | build | test]; by
# default all three. IMG_RECOG_VERSION: a branch, a tag or a commit.
set -eu
repository=${IMG_RECOG_REPOSITORY:-REPOSITORY}     # the address of img_recog
version=${IMG_RECOG_VERSION:-HEAD}
name=my_robot_vision
export PATH="/usr/bin:/bin:$PATH"     # the Python of the distribution, not of pyenv or conda
package=$(cd "$(dirname "$0")" && pwd)
ws=${CI_WORKSPACE:-$package/ws}
img_recog=$ws/src/img_recog

get() {
  if [ "$repository" = REPOSITORY ]; then
    echo "ci.sh: write the address of img_recog into this file, in the place of REPOSITORY" >&2
    exit 1
  fi
  if ! command -v git >/dev/null; then
    apt-get update -q
    apt-get install -y -q --no-install-recommends ca-certificates git
  fi
  # git clone refuses a folder in which a cache has put .venv
  git init -q "$img_recog"
  git -C "$img_recog" fetch -q --depth 1 "$repository" "$version"
  git -C "$img_recog" checkout -q -f FETCH_HEAD
}

build() {
  "$img_recog/run" -y setup
  # not one link: roslaunch would find ws/ in it, and so each file many times
  rm -rf "${ws:?}/src/$name"
  mkdir "$ws/src/$name"
  for path in "$package"/*; do
    [ "$path" = "$ws" ] || ln -s "$path" "$ws/src/$name/"
  done
  cd "$ws"
  catkin_make -DPYTHON_EXECUTABLE=/usr/bin/python3
}

run_tests() {
  cd "$ws"
  export ROS_HOSTNAME=localhost     # only this computer can connect
  catkin_make "run_tests_$name"
  # run_tests ends with 0 also if tests fail
  catkin_test_results "build/test_results/$name"
}

case ${1:-all} in
  get) get ;;
  build) build ;;
  test) run_tests ;;
  all) get; build; run_tests ;;
  *) echo "ci.sh: got $1; give get, build, test, or nothing" >&2; exit 2 ;;
esac
