# fish completion for odom and odomd, which asks odom. Installed under both names.
function __odom_complete
    set -l words (commandline -opc) "$(commandline -ct)"
    odom complete (basename $words[1]) $words[2..-1] 2>/dev/null | while read -l line
        switch $line
            case :files
                __fish_complete_path (commandline -ct)
            case :directories
                __fish_complete_directories (commandline -ct)
            case '*'
                echo $line
        end
    end
end

complete -c odom -f -a '(__odom_complete)'
complete -c odomd -f -a '(__odom_complete)'
