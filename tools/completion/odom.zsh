#compdef odom odomd
# zsh completion for odom and odomd, which asks odom.
local line
local -a candidates
for line in ${(f)"$(odom complete $service "${(@Q)words[2,CURRENT]}" 2>/dev/null)"}; do
  case $line in
    :files) _files ;;
    :directories) _files -/ ;;
    *) candidates+=("${${line//:/\\:}/$'\t'/:}") ;;
  esac
done
_describe 'word' candidates
