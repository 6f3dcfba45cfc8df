# Texts in English or Japanese, as LC_ALL, LC_MESSAGES or LANG says. Sourced by ./run, which sets root.
# shellcheck shell=bash disable=SC2034,SC2154

declare -A japanese=()
usage=$root/tools/usage.txt
case ${LC_ALL:-${LC_MESSAGES:-${LANG:-}}} in
  ja*)
    usage=$root/tools/usage_ja.txt
    # as in messages.py, which describes the table
    while IFS= read -r english && IFS= read -r text; do
      [ -z "$english" ] || japanese[$english]=$text
      IFS= read -r english || break
    done < <(sed 1,2d "$root/src/img_recog/command_line/messages_ja.txt"; echo)
    ;;
esac

# message TEXT [VALUE ...]: prints a text of the table with these values at its {}.
message() {
  local text=${japanese[$1]:-$1} result='' value
  shift
  for value; do
    result+=${text%%'{}'*}$value
    text=${text#*'{}'}
  done
  printf '%s\n' "$result$text"
}

say() { printf '[run] %s\n' "$(message "$@")"; }
fail() { printf '[run] %s\n' "$(message "$@")" >&2; exit 1; }
