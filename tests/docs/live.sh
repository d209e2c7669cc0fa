# Help's examples that need a robot, in a network of their own: a log is played as the robot.
# Silent where all is well.
ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 1
lcm-logplayer --speed=4 session.lcmlog >player.out 2>&1 &
player=$!
# `mukca capture` wants a terminal and keys: yes to the order of joints, a row, the end.
rm -f session.tsv
capture=$(mukca completion examples | grep 'mukca capture.*IIWA_STATUS' | head -n 1)
(sleep 1; printf y; printf '\n'; for i in 1 2 3 4 5 6; do sleep 0.3; printf a; done; printf q; sleep 0.5) |
    timeout 20 script -qec "$capture" /dev/null >capture.out 2>&1 || { echo "$capture: $?"; tail -n 5 capture.out; }
kill $player 2>/dev/null
wait $player 2>/dev/null
serve=$(mukca completion examples | grep '^mukca serve')
$serve >serve.out 2>&1 &
daemon=$!
sleep 0.5
lcm-logplayer --speed=3 session.lcmlog >player.out 2>&1 &
player=$!
sleep 0.3
mukca send start demo >send.out 2>&1 || { echo "send start: $?"; cat send.out; }
wait $player
for i in 1 2 3; do
    bash -c "$(mukca completion examples | grep '^mukca send')" >send.out 2>&1 && break
    sleep 1
done || { cat send.out; tail -n 5 serve.out; }
[ -s offsets.tsv ] || { echo "no offsets"; cat send.out; tail -n 20 serve.out; }
kill $daemon
wait $daemon
exit 0
