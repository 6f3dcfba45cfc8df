# Linters and tests. Sourced by ./run, which sets root, venv, build, devel and python.
# shellcheck shell=bash disable=SC2154

pure=(camera conversions recognition rendering simulation teleoperation)

# Prints one line per linter, and its output if it reports anything. The settings are in setup.cfg.
lint() {
  local verdict=0
  cd "$root" || return
  check flake8 "$python" -m flake8 . || verdict=1
  check_types || verdict=1
  check catkin_lint catkin_lint -q -W2 --strict --ignore package_path_name "$root" || verdict=1
  # shellcheck disable=SC2046
  check shellcheck shellcheck $(shell_scripts) || verdict=1
  return $verdict
}

shell_scripts() {
  grep -lrE '^#!.*\b(ba)?sh$|^# shellcheck shell=' --exclude-dir={.git,.venv,build,devel,__pycache__} \
    --exclude='*.py' . | sort
}

# check NAME COMMAND...: runs a linter and prints its result.
check() {
  local name=$1 output
  shift
  if output=$("$@" 2>&1); then
    say '{}: clean' "$name"
  else
    say "$name:"
    printf '%s\n' "$output"
    return 1
  fi
}

# mypy before 0.990 (Ubuntu 20.04 has 0.761) reports errors in code that later versions accept
check_types() {
  local version
  version=$("$python" -m mypy --version | sed -nE 's/^mypy ([0-9.]+).*/\1/p' || true)
  if ! printf '0.990\n%s\n' "$version" | sort -VC; then
    say 'mypy: not run, {} is older than 0.990' "${version:-?}"
    return 0
  fi
  check mypy "$python" -m mypy
}

# Reports how many lines of the pure folders the unit tests run.
report_coverage() {
  local include='' folder data=$build/coverage.data
  [ -f "$data" ] || return 0
  for folder in "${pure[@]}"; do include+="${include:+,}$root/src/img_recog/$folder/*"; done
  COVERAGE_FILE=$data "$venv/bin/python3" -m coverage report -m --include="$include" \
    >"$build/coverage.txt" 2>&1 || { say 'no coverage: {}' "$(tail -n 1 "$build/coverage.txt")"; return 0; }
  say 'the unit tests run {} of the lines of {}; the others are listed in build/coverage.txt' \
    "$(awk 'END{print $4}' "$build/coverage.txt")" "${pure[*]}"
}

# Most tests wait for a robot in real time, so that several fit on two cores at the same time. Two more
# than cores: with one more, a tenth of the time of two cores was left.
run_all_tests() {
  local jobs
  jobs=$(($(nproc) + 2))
  [ $jobs -le 4 ] || jobs=4
  say 'running the tests, {} at a time, about 13 min; the full output is in build/test.log' "$jobs"
  show_targets run_tests -j "$jobs"
}

# Makes targets; shows a line for each test, without the log of the nodes.
show_targets() {
  cmake --build "$cmake" --target "$1" -- "${@:2}" 2>&1 | tee -a "$build/test.log" |
    grep --line-buffered -E '^\[img_recog\.|^\[Testcase|^[.FEsx]+ +\[|^FAILED|^E  |passed|failed|RESULT'
}

# What fails beside other programs, and not alone, is no reason to reject a change: runs the files of
# tests with processes that have failed again, once. The first results stay in build/test.log.
repeat_failed() {
  local target targets results=$build/test_results kept=$build/kept_results
  mapfile -t targets < <("$python" "$root/test/summary.py" "$results" --targets)
  [ ${#targets[@]} -le 5 ] || return 0
  for target in "${targets[@]}"; do
    say 'failed beside other tests, now runs again alone: {}' "$target"
    rm -rf "$kept"
    mv "$results" "$kept"       # the target removes the results of the others
    show_targets "_run_tests_img_recog_$target" || true
    cp -rT "$results" "$kept"
    rm -rf "$results"
    mv "$kept" "$results"
  done
}

# Each roslaunch asks rosversion twice, which takes Python a tenth of a second: the answers are kept.
keep_versions() {
  local programs=$build/programs
  mkdir -p "$programs"
  # shellcheck disable=SC2016
  printf '#!/bin/sh\ncase $* in\n  roslaunch) echo %s ;;\n  -d) echo %s ;;\n  *) exec %s "$@" ;;\nesac\n' \
    "$(rosversion roslaunch)" "$(rosversion -d)" "$(command -v rosversion)" >"$programs/new"
  chmod +x "$programs/new"
  mv "$programs/new" "$programs/rosversion"
  export PATH=$programs:$PATH
}

no_test() {
  [ -n "$2" ] || fail 'no test of {}' "$1"
  [ -n "$1" ] || fail 'no test matches {}' "$2"
  fail 'no test of {} matches {}' "$1" "$2"
}

# run_tests KINDS EXPRESSION: an empty value selects everything.
run_tests() {
  local kinds=$1 expression=$2 verdict=0 folder log=build/test_results
  rm -rf "$build/test_results" "$build/coverage.data"
  # the tests start hundreds of processes, which otherwise compile every module again
  unset PYTHONDONTWRITEBYTECODE
  export LC_ALL=C.UTF-8     # the language of the texts that they expect
  hurry_roslaunch
  if [ -z "$kinds$expression" ]; then
    log="build/test.log and $log"
    rm -f "$build/test.log"
    keep_versions
    run_all_tests || verdict=$?
    repeat_failed
  else
    build_target tests
    for folder in ${kinds:-unit rostest system}; do
      run_kind "$folder" "$expression" || verdict=$?
    done
    [ -n "$(find "$build/test_results" -name '*.xml' 2>/dev/null)" ] ||
      no_test "$kinds" "$expression"
  fi
  report_coverage
  # the target run_tests succeeds even if tests fail; the result files decide
  catkin_test_results "$build/test_results" || verdict=$?
  "$python" "$root/test/summary.py" "$build/test_results" || verdict=$?
  [ "$verdict" -eq 0 ] || say 'failed; see {}' "$log" >&2
  return "$verdict"
}

# Runs the tests of one kind whose names match; the results are where catkin's run_tests puts them.
run_kind() {
  local kind=$1 expression=$2 results=$build/test_results/img_recog code=0 file
  mkdir -p "$results"
  if [ "$kind" = rostest ]; then
    for file in "$root"/test/rostest/*"$expression"*.test; do
      [ ! -f "$file" ] || rostest --pkgdir="$root" --package=img_recog \
        --results-filename="test_rostest_$(basename "$file" .test).xml" \
        --results-base-dir="$build/test_results" "$file" || code=$?
    done
    return $code
  fi
  local command=(-m pytest) paths=("$root/test/$kind")        # as in CMakeLists.txt
  if [ "$kind" = unit ]; then
    # not when all tests run: it costs a third of the time of the unit tests
    command=(-m coverage run --source="$root/src/img_recog" -m pytest)
    # the examples in the docstrings; to import all other modules, too, takes seconds
    paths+=(--doctest-modules)
    while read -r file; do paths+=("$file"); done < <(grep -rl --include='*.py' '>>> ' "$root/src")
  fi
  COVERAGE_FILE=$build/coverage.data "$venv/bin/python3" "${command[@]}" -p no:cacheprovider \
    --timeout 1200 --junit-xml="$results/pytest-$kind.xml" ${expression:+-k "$expression"} \
    "${paths[@]}" || code=$?
  if [ $code -eq 5 ]; then         # pytest: no tests were collected
    rm -f "$results/pytest-$kind.xml"
    code=0
  fi
  return $code
}
