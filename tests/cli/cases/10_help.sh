# Help and misspelt words.
refuse 2 "unknown command 'calibarte'; did you mean calibrate?" calibarte
refuse 2 "unknown command 'z?]z'" "$(printf 'z\033]z')"
refuse 2 "unknown command 'zzz'; .mukca help. lists them" zzz
refuse 2 "unknown command 'zzz'" help zzz
refuse 2 "unknown command 'version'; did you mean --version?" version
refuse 2 "unknown option '--verzion'; did you mean --version?" --verzion
refuse 2 "unknown command 'effect'; did you mean help effects?" help effect
refuse 2 "serve has no command 'statsu'; did you mean status?" send statsu
refuse 2 "no effect is called 'joint_complience'; did you mean joint_compliance?" diagnose --expect joint_complience x
refuse 2 "no effect is called 'lag'" diagnose --without backlash,lag x
refuse 2 "mukca fk: --urdf FILE is needed" fk
run
expect "mukca alone says where to start" sh -c "test $code -eq 2 && grep -q 'Start with' '$scratch/err' && test ! -s '$scratch/out'"
expect "mukca alone fits a screen of 24 lines" test "$(wc -l <"$scratch/err")" -lt 24
run --version
expect "--version prints one line" test "$(wc -l <"$scratch/out")" -eq 1
for command in $("$MUKCA" help options | cut -f 1 | tail -n +2 | sort -u); do
    run "$command" --help
    expect "$command --help is help $command" sh -c "'$MUKCA' help $command | cmp - '$scratch/out'"
    expect "help of $command ends in an example" \
        sh -c "sed -n '/^Example:/,\$p' '$scratch/out' | sed -n 2p | grep -q '^  .*mukca'"
    "$MUKCA" help options | awk -F '\t' -v c="$command" '$1 == c { print $2 }' >options
    expect "help of $command has each option" sh -c "while read -r o; do grep -qE -- \"^  (-., )?\$o( |\\$)\" '$scratch/out' || exit 1; done <options"
    expect "help of $command fits 80 columns" sh -c "! grep -E '.{81}' '$scratch/out'"
done
cat >try.bash <<'BASH'
. "$1/data/completion.bash"
COMP_WORDS=("$MUKCA" export --for) COMP_CWORD=2
_mukca
[ "${COMPREPLY[*]}" = "--format --force" ] || exit 1
COMP_WORDS=("$MUKCA" export --format y) COMP_CWORD=3
_mukca
[ "${COMPREPLY[*]}" = yaml ] || exit 1
for typed in "calibrate --gradient :fd analytic" "help ef:effects" "send st:status start" \
    "diagnose --expect backl:backlash" "diagnose ye:" "diagnose --urdf ye:"; do
    IFS=" " read -ra words <<<"${typed%%:*}"
    [[ ${typed%%:*} == *" " ]] && words+=("")
    COMP_WORDS=("$MUKCA" "${words[@]}") COMP_CWORD=${#words[@]}
    _mukca
    [ "${COMPREPLY[*]}" = "${typed#*:}" ] || { echo "$typed: ${COMPREPLY[*]}"; exit 1; }
done
COMP_WORDS=("$MUKCA" ex) COMP_CWORD=1
_mukca
[ "${COMPREPLY[*]}" = export ]
BASH
expect "bash completes commands, options and choices" bash try.bash "$root"
