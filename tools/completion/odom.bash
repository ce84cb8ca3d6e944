# bash completion for odom and odomd, which asks odom. Installed under both names.
_odom() {
  local cur=${COMP_WORDS[COMP_CWORD]} word
  local IFS=$'\n'
  COMPREPLY=()
  while IFS=$'\t' read -r word _; do
    case $word in
      :files) compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -f -- "$cur")) ;;
      :directories) compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -d -- "$cur")) ;;
      "$cur"*) COMPREPLY+=("$word") ;;
    esac
  done < <(odom complete "${1##*/}" "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
} && complete -F _odom odom odomd
