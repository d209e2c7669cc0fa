# bash completion for mukca, from its own table of options; zsh runs it, too (see the Makefile).
_mukca() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}
    local words= files=yes mukca=${COMP_WORDS[0]} table commands
    table=$("$mukca" help options 2>/dev/null)
    commands=$(cut -f 1 <<<"$table" | sed 1d | uniq)
    if [ "$COMP_CWORD" -eq 1 ]; then
        files= words="help --version $commands"
    elif [ "$command" = help ]; then
        files= words="effects options $commands"
    elif [ "$COMP_CWORD:$command" = 2:send ] && [[ $word != -* ]]; then
        files= words="status $("$mukca" help serve | sed -n '/^Commands:/,/^$/s/^  \([a-z]\)/\1/p' | cut -d ' ' -f 1)"
    else
        words=$(awk -F '\t' -v c="$command" -v o="$before" '$1 == c && ($2 == o || "-" $3 == o) { print $5 }' <<<"$table")
        [[ $words ]] && files=
        [[ $words ]] || words="--help $(awk -F '\t' -v c="$command" '$1 == c { print $2 }' <<<"$table")"
    fi
    # options only after a dash; where no list fits, files: -o default
    [[ $files && $word != -* ]] && words=
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _mukca mukca
