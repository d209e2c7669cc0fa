# Odd but possible: streams closed, one file under two names, sizes that no arm has.
. "$here/fixture.sh"
a='--urdf arm.urdf'

# what is said to people must not land in a file that took the number of a closed stream
run simulate $a --seed 5 --rows 3 --placements 2 -o two.tsv
for closed in '2>&-' '>&-' '<&-' '<&- >&- 2>&-'; do
    eval "\"\$MUKCA\" evaluate $a two.tsv -o closed.tsv 2>closed.err $closed"
    expect "streams closed ($closed): the table begins with its header" \
        sh -c 'head -n 1 closed.tsv | grep -q "^set"'
    rm -f closed.tsv
done
"$MUKCA" fk $a good/hole_0.csv 2>err >&-
code=$?
expect "a closed standard output is told" test "$code $(wc -l <err)" = "6 1"

# a file beyond the shell's limit is a full disk, and leaves nothing
rows 1 200 >many.csv
(ulimit -f 1 && exec "$MUKCA" fk $a many.csv -o large.tsv) 2>err
code=$?
expect "a file beyond ulimit -f: exit 6, one line, no file" test \
    "$code $(wc -l <err) $(find . -name '*large*' | wc -l)" = "6 1 0"

# a named pipe: looking whether it can be written must not end its reader
mkfifo pipe
cat pipe >piped.tsv &
reader=$!
timeout 60 "$MUKCA" evaluate -q $a good -o pipe
expect "a named pipe is written" test $? -eq 0
wait $reader
expect "and read to its end" sh -c 'head -n 1 piped.tsv | grep -q "^set"'

# neither what is read nor another output is overwritten, whatever it is called
refuse 2 'session.tsv is an input of this command' calibrate $a session.tsv -o ./session.tsv --force
refuse 2 'session.tsv is an input of this command' calibrate $a good --test session.tsv --json session.tsv --force
refuse 2 'hole_0.csv is an input of this command' fk $a good/hole_0.csv -o good/../good/hole_0.csv --force
refuse 2 'arm.urdf is an input of this command' export $a -o arm.urdf --force
refuse 2 'hole_1.csv is an input of this command' calibrate $a good -o good/hole_1.csv --force
refuse 2 'arm.urdf is an input of this command' simulate $a -o new.tsv --truth ./arm.urdf --force
ln -s session.tsv link.tsv
refuse 2 'link.tsv is an input of this command' evaluate $a session.tsv -o link.tsv --force
refuse 2 'cannot both go to' evaluate $a good -o new.tsv --json ./new.tsv --force
refuse 2 'cannot both go to' calibrate $a good -o new.tsv --json good/../new.tsv
refuse 2 'cannot both go to' simulate $a -o new.tsv --truth ./new.tsv
expect "/dev/null takes all outputs" "$MUKCA" evaluate $a good -o /dev/null --json /dev/null -q

# as of an unset variable in a script
refuse 2 '--output needs FILE, and not an empty text' calibrate $a good -o ''
refuse 2 'an argument is empty' calibrate $a ''
expect "help help is help" "$MUKCA" help help

# recordings
demo=$root/data/demo
cp "$demo/guided.lcmlog" log
c="capture --urdf $demo/arm.urdf --trigger --force"
refuse 2 'cannot both go to' $c --lcm-url file://log -o new.tsv --json ./new.tsv
refuse 2 'log is the log' $c --lcm-url file://log -o new.tsv --json ./log
refuse 2 '-o FILE is needed' $c --lcm-url file://log -o -
refuse 2 "'a' comes twice" $c --lcm-url file://log -o new.tsv --sockets a,a
refuse 2 'a tool has two or more' $c --lcm-url file://log -o new.tsv --sockets a
refuse 2 'names reading 2 twice' $c --lcm-url file://log -o new.tsv --map 1,2,3,4,5,6,2
# --resume must not wipe a file that is no session, nor mend one that it refuses
printf 'my notes' >notes.tsv
refuse 3 'notes.tsv: no header' capture --urdf "$demo/arm.urdf" --trigger -q --lcm-url file://log -o notes.tsv --resume
printf '# mukca session\nplacement\tsocket\nhalf' >other.tsv
refuse 3 'other.tsv: other columns' capture --urdf "$demo/arm.urdf" --trigger -q --lcm-url file://log -o other.tsv --resume

# interrupted: at once, also where another program draws, and told as such
for each in fk:INT fk:TERM compensate:INT; do
    mkfifo targets
    "$MUKCA" "${each%:*}" $a - -o new.tsv <targets 2>err &
    process=$!
    exec 3>targets
    printf 'j1,j2,j3\n0,0,0\n' >&3
    until [ -n "$(find . -name '.new.tsv.*.tmp')" ] || ! kill -0 $process; do sleep 0.02; done
    kill -s "${each#*:}" $process
    wait $process
    code=$?
    exec 3>&-
    rm targets
    expect "${each%:*} interrupted by ${each#*:}: exit 130, one line, no file" test \
        "$code $(grep -v '^mukca: note' err) $(find . -name '*new*' | wc -l)" = \
        "130 mukca ${each%:*}: interrupted; nothing was written 0"
done

# every command says that standard output could not be written
for command in "help" "help fk" "help effects" "--version" "help options" "fk $a good/hole_0.csv" \
    "evaluate $a good" "calibrate $a good" "calibrate $a good -o -" "export $a" "simulate $a" \
    "compensate $a good/hole_0.csv" "plan $a --place p=0.5,0,0.4 --rows 2" "diagnose $a good" "diagnose $a good --json -"; do
    "$MUKCA" $command 2>err >/dev/full
    code=$?
    expect "a full standard output: $command" test "$code $(grep -c 'standard output: cannot write: No space left on device' err)" = "6 1"
done
