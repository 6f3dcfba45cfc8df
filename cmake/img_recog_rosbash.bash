# Debian has roscd, rosls and the like only among the completions of bash, which load them too late.
if ! declare -F roscd >/dev/null && [ -r /usr/share/bash-completion/completions/rosbash ]; then
  . /usr/share/bash-completion/completions/rosbash
fi
