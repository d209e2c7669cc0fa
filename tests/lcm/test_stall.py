"""A stopped process, a stopped terminal, lines that lag: a sample is of the moment of its request, or refused."""
import os
import signal
import subprocess
import threading
import time

from foreign import Arm, Client, HOME, Terminal, URDF, accepted, check, finish, fresh, mukca, spawn, stop, table

NETWORK = "udpm://239.255.76.67:7667?recv_buf_size=%d"
ROUNDS = 20 if os.environ.get("MUKCA_LONG") else 3
OPTIONS = ("--urdf", URDF, "--channel", "IIWA_STATUS", "--map", "order", "--trigger")


def posture(i):
    return [x + 0.05 * i for x in HOME[:3]] + HOME[3:]


def is_at(sample, q):
    return abs(sample.position[0] - q[0]) < 0.01


def stand(client, arm, q, place="front"):
    """Go there, and trigger until a sample is accepted; whether it is of that posture."""
    arm.go(q)
    client.wait(lambda: False, 0.2)
    sample = accepted(client, lambda: client.trigger(place, "0"))
    return sample is not None and is_at(sample, q)


def stopped(verb, rate, buffer):
    """SIGSTOP while the arm moves on; the trigger waits in a socket that holds old joint states, or overflows."""
    name, folder, client = "%s, %d bytes" % (verb, buffer), fresh("stall_" + verb), Client()
    path = os.path.join(folder, "s.tsv" if verb == "capture" else "sessions/s.tsv")
    with Arm("iiwa", HOME, rate, "IIWA_STATUS") as arm:
        more = ("-o", path, "--wait", "20") if verb == "capture" else ("--state", folder)
        p = spawn(verb, *(OPTIONS if verb == "capture" else OPTIONS[:-1]), *more, "--lcm-url", NETWORK % buffer)
        client.wait_stream()
        if verb == "serve":
            client.command("start", "s")
        check(name + ": a sample before", stand(client, arm, HOME), p.said[-3:])
        stale, after, lines = [], 0, len(p.said)
        for k in range(ROUNDS):
            arm.go(posture(2 * k + 1))
            client.wait(lambda: False, 0.5)
            p.send_signal(signal.SIGSTOP)
            client.wait(lambda: False, 0.4)
            arm.go(posture(2 * k + 2))
            client.wait(lambda: False, 1.8)
            m = mukca.trigger()
            m.utime, m.id, m.placement, m.socket = int(time.time() * 1e6), 1000 + k, "front", "0"
            client.lc.publish("MUKCA_TRIGGER", m.encode())
            p.send_signal(signal.SIGCONT)
            sample = client.answer(mukca.sample, m.id, 2)
            if sample and sample.accepted and not is_at(sample, posture(2 * k + 2)):
                stale.append(list(sample.position))
            after += stand(client, arm, posture(2 * k + 2))
        check(name + ": no sample of an earlier posture", not stale, stale)
        check(name + ": a sample after each stop", after == ROUNDS, p.said[-5:])
        check(name + ": no silence is reported", not any("no joint state" in line for line in p.said), p.said[lines:])
        check(name + ": few lines", len(p.said) - lines < 6 * ROUNDS + 3, p.said[lines:])
        stop(p)


def terminal():
    """Ctrl-S; and keys after SIGSTOP."""
    path, client = os.path.join(fresh("stall_terminal"), "s.tsv"), Client()
    with Arm("iiwa", HOME, 1000, "IIWA_STATUS") as arm:
        t = Terminal("capture", *OPTIONS, "-o", path)
        client.wait_stream()
        check("terminal: a sample before", stand(client, arm, HOME))
        t.press(b"\x13")
        t.held = True
        client.wait(lambda: False, 2.5)
        lost = client.status.received
        check("terminal: stopped, a trigger is answered", stand(client, arm, posture(1)))
        client.wait(lambda: client.status.received > lost + 2000, 10)
        n = len(table(path)[1])
        t.press(b"a")
        check("terminal: stopped, a key records", client.wait(lambda: len(table(path)[1]) > n, 5))
        t.press(b"\x11")
        t.held = False
        check("terminal: it shows what was recorded", client.wait(lambda: b"sample %d:" % (n + 1) in t.text, 5), t.text[-300:])
        shown = [line for line in t.text.split(b"\n") if b"no joint state" in line or b"is back" in line]
        check("terminal: no silence is reported", not shown, shown[:3])
        for k in range(ROUNDS):
            arm.go(posture(2 * k + 2))
            client.wait(lambda: False, 0.5)
            t.p.send_signal(signal.SIGSTOP)
            client.wait(lambda: False, 0.3)
            arm.go(posture(2 * k + 3))
            client.wait(lambda: False, 1.5)
            n = len(table(path)[1])
            if k % 2:
                t.press(b"a")
            t.p.send_signal(signal.SIGCONT)
            time.sleep(0.002 * k)
            t.press(b"a")
            client.wait(lambda: len(table(path)[1]) > n, 1)
            column = table(path)[0].index("joint_1")
            wrong = [row[column] for row in table(path)[1][n:] if abs(float(row[column]) - posture(2 * k + 3)[0]) > 0.01]
            check("terminal: a key after a stop records no earlier posture", not wrong, wrong)
        t.press(b"q")
        check("terminal: ends", t.ended() == 0, t.text[-300:])


def lines():
    """capture --stdin --trigger behind a program that holds its lines back."""
    lag, path, client = [1.0], os.path.join(fresh("stall_lines"), "s.tsv"), Client()
    p = spawn("capture", "--urdf", URDF, "--stdin", "--trigger", "-o", path, stdin=subprocess.PIPE)
    q, running, waiting = [HOME], [True], []

    def feed():
        n = 0
        p.stdin.write("time_s," + ",".join("joint_%d" % (i + 1) for i in range(7)) + "\n")
        while running[0]:
            n += 1
            waiting.append((time.time(), ",".join("%.9f" % (x + 1e-6 * (n * (i + 3) % 7)) for i, x in enumerate(q[0]))))
            while waiting and waiting[0][0] <= time.time() - lag[0]:
                p.stdin.write("%.6f,%s\n" % waiting.pop(0))
            p.stdin.flush()
            time.sleep(0.01)
    thread = threading.Thread(target=feed)
    thread.start()
    client.wait_stream()
    samples = []
    for k in range(3):
        q[0] = posture(2 * k)
        client.wait(lambda: False, 0.5)
        samples.append(client.trigger("front", "0"))
    check("lines: none that is older than the trigger is recorded",
          all(s and not s.accepted and "older than the request" in s.text for s in samples), [s and s.text for s in samples])
    lag[0] = 0
    sample = accepted(client, lambda: client.trigger("front", "0"))
    check("lines: recorded without the lag", sample and is_at(sample, q[0]), p.said[-3:])
    running[0] = False
    thread.join()
    p.stdin.close()
    p.wait(10)


stopped("capture", 1000, 65536)
stopped("serve", 200, 2 << 20)
terminal()
lines()
finish()
