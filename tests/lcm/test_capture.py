"""mukca capture with a foreign sender: finding the stream, mapping, triggers, keys."""
import os
import pty
import select
import signal
import subprocess
import termios
import time

from foreign import Arm, Client, HOME, JOINTS, MUKCA, ROOT, URDF, accepted, check, ended, finish, fresh, said, spawn, stop, table, until

work = fresh("capture")
count = 0


def out():
    global count
    count += 1
    return os.path.join(work, "s%d.tsv" % count)


def capture(path, *arguments, **more):
    return spawn("capture", "--urdf", URDF, "-o", path, "--window", "0.1", *arguments, **more)


def posture(i):
    return [x + 0.3 * ((i * (j + 3)) % 7 - 3) / 3 for j, x in enumerate(HOME)]


def trigger_some(client, arm, n, first=0):
    """n accepted samples at changing postures; their positions."""
    rows = []
    for i in range(first, first + n):
        arm.go(posture(i))
        sample = accepted(client, lambda: client.trigger(seconds=2))
        rows += [list(sample.position)] if sample else []
    return rows


def usage():
    p = subprocess.run([MUKCA, "capture", "--urdf", URDF, "-o", out()], capture_output=True,
                       text=True, stdin=subprocess.DEVNULL)
    check("without a terminal and a trigger it says so", p.returncode == 2 and "--trigger" in p.stderr,
          p.stderr)


def silence():
    with Arm("panda", HOME, 100, "PANDA_STATUS"):
        p = capture(out(), "--trigger", "--channel", "IIWA_STATUS", "--map", "order", "--wait", "4")
        check("a silent channel is told", until(lambda: said(p, "heard instead")), p.said)
        line = next((x for x in p.said if "heard instead" in x), "")
        p.wait(20)
        check("and what was heard instead", "PANDA_STATUS (drake.lcmt_panda_status, 7 joints)" in line,
              line)
        check("then it gives up with exit 4", p.returncode == 4, p.returncode)


def unmapped():
    with Arm("iiwa", HOME, 100, "IIWA_STATUS"):
        p = capture(out(), "--trigger", "--channel", "IIWA_STATUS")
        ended(p)
        check("a mapping by order must be confirmed", p.returncode == 2 and
              any("--map order" in x for x in p.said), p.said)
    with Arm("iiwa", HOME + HOME, 100, "IIWA_STATUS"):
        p = capture(out(), "--trigger", "--channel", "IIWA_STATUS", "--map", "order")
        ended(p)
        check("two arms in one message need numbers", p.returncode == 3 and
              any("--map 8-14" in x for x in p.said), p.said)


def finds_by_listening():
    shuffled = list(reversed(JOINTS))
    client, path = Client(), out()
    with Arm("state", list(reversed(HOME)), 200, "ROBOT.STATE+1", names=shuffled) as arm, \
            Arm("iiwa", HOME[:3], 100, "OTHER"):
        p = capture(path, "--trigger", "--rows", "3")
        check("the channel is found by listening, joints by name", client.wait_stream(), p.said)
        for i in range(3):
            arm.go(list(reversed(posture(i))))
            accepted(client, lambda: client.trigger(seconds=2))
        p.wait(20)
        check("--rows ends the session", p.returncode == 0, p.said)
    header, rows = table(path)
    check("columns are the URDF's joints", header[3:10] == JOINTS, header)
    check("readings went to the joints of their names",
          all(abs(float(r[3 + j]) - posture(i)[j]) < 2e-6 for i, r in enumerate(rows) for j in range(7)),
          rows)


def two_candidates():
    with Arm("iiwa", HOME, 100, "A"), Arm("panda", HOME, 100, "B"):
        p = capture(out(), "--trigger")
        ended(p)
        check("two streams that fit are not guessed between", p.returncode == 3 and
              any("choose with --channel" in x for x in p.said), p.said)


def unknown_type():
    path, client = out(), Client()
    description = os.path.join(ROOT, "tests", "lcm", "types", "arm_t.lcm")
    with Arm("acme", HOME, 200, "MY_ARM", names=JOINTS) as arm:
        p = capture(out(), "--trigger", "--channel", "MY_ARM")
        ended(p)
        check("an unknown type is told with the way to describe it", p.returncode == 3 and
              any("--type FILE.lcm --position FIELD" in x for x in p.said), p.said)
        p = capture(out(), "--trigger", "--wait", "3")
        for _ in range(20):  # until it has heard the channel
            client.wait(lambda: False, 0.1)
            sample = client.trigger()
            if sample and "heard" in sample.text:
                break
        ended(p)
        check("without a channel, too", p.returncode == 4 and any(
            "MY_ARM (unknown type); describe an unknown type with --type" in x for x in p.said), p.said)
        check("and a trigger says why nothing is recorded", sample and not sample.accepted and
              sample.text.startswith("no session is being recorded: no joint state; heard instead: MY_ARM") and
              "--type FILE.lcm" in sample.text, sample and sample.text)
        p = capture(path, "--trigger", "--type", description, "--position", "joints.q", "--names",
                    "joints.name", "--rows", "2")
        check("a described type is understood", client.wait_stream(), p.said)
        trigger_some(client, arm, 2)
        p.wait(20)
    rows = table(path)[1]
    check("and recorded", len(rows) == 2 and
          all(abs(float(x) - y) < 2e-6 for x, y in zip(rows[1][3:10], posture(1))), rows)


def by_itself():
    """--still: the arm visits 4 postures twice; each is recorded once."""
    path, client = out(), Client()
    with Arm("panda", posture(0), 200, "PANDA_STATUS") as arm:
        p = capture(path, "--still", "--dwell", "0.3", "--map", "order", "--distance", "2")
        client.wait_stream()
        for k in range(8):
            arm.go(posture(k % 4))
            client.wait(lambda: k < 4 and said(p, "row %d:" % (k + 1)), 20 if k < 4 else 0.6)
        check("standing still ends with SIGINT", stop(p, signal.SIGINT) == 130, p.said)
        check("and says where the rows are", any("--resume" in x for x in p.said), p.said)
    check("standing still records each posture once", len(table(path)[1]) == 4, table(path))


def keys():
    """A session at a terminal: confirm, add, delete, other socket, next placement, finish."""
    path = out()
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    screen = b""

    def shown(words, seconds=15, other=None):
        nonlocal screen
        end = time.monotonic() + seconds
        while words.encode() not in screen and not (other and other in screen) and time.monotonic() < end:
            if select.select([master], [], [], 0.05)[0]:
                screen += os.read(master, 65536)
        found = words.encode() in screen
        if found:
            screen = screen[screen.index(words.encode()) + len(words):]
        return found

    def press(key):
        nonlocal screen
        screen = b""
        os.write(master, key.encode())

    def add(words):  # again while the arm still moves
        return until(lambda: press("a") or shown(words, other=b"not recorded"))
    with Arm("iiwa", posture(0), 200, "IIWA_STATUS") as arm:
        environment = dict(os.environ, TERM="xterm")
        p = subprocess.Popen([MUKCA, "capture", "--urdf", URDF, "-o", path, "--window", "0.1",
                              "--channel", "IIWA_STATUS", "--placement", "front,left"],
                             stdin=slave, stdout=slave, stderr=slave, env=environment)
        check("keys: the mapping is printed and asked about", shown("Is that right?"), screen)
        press("y\n")
        check("keys: the view comes", shown("finish"), screen)
        check("keys: a adds", add("sample 1: placement front, socket 0"), screen)
        check("keys: the bell rings for it", shown("\a"), screen)
        arm.go(posture(1))
        press("s")
        check("keys: s goes to the other socket", shown("now placement front, socket 1"), screen)
        check("keys: and a adds there", add("sample 2: placement front, socket 1"), screen)
        press("d")
        check("keys: d deletes", shown("sample 2 deleted"), screen)
        press("n")
        check("keys: n begins the next placement", shown("now placement left, socket 0"), screen)
        check("keys: a adds to it", add("sample 2: placement left, socket 0"), screen)
        check("keys: the view counts", shown("1 of 20 \u00b7 placement 2 of 4") and shown("samples      2:"), screen)
        arm.go(posture(2), 3)
        time.sleep(0.3)
        press("a")
        check("keys: a moving arm is refused", shown("not recorded: the arm moves"), screen)
        check("keys: and the bell rings twice", shown("\a") and shown("\a"), screen)
        press("?")
        check("keys: ? lists the keys", shown("d delete the last"), screen)
        press("q")
        check("keys: q finishes", shown("no placement has two sockets"), screen)
        p.wait(10)
        check("keys: exit 0", p.returncode == 0, p.returncode)
        check("keys: the terminal is as it was", termios.tcgetattr(slave) == before)
        p = subprocess.Popen([MUKCA, "capture", "--urdf", URDF, "-o", path, "--window", "0.1",
                              "--channel", "IIWA_STATUS", "--map", "order", "--resume"],
                             stdin=slave, stdout=slave, stderr=slave, env=environment)
        check("keys: resumed where it was", shown("1 of 20"),
              screen)
        p.send_signal(signal.SIGINT)
        shown("--resume continues")
        p.wait(10)
        check("keys: interrupted with 130", p.returncode == 130, p.returncode)
        check("keys: the terminal is as it was after ^C", termios.tcgetattr(slave) == before)
    os.close(master)
    os.close(slave)
    with open(path) as f:
        text = f.read()
    check("keys: the undone row left its record", "# undone: row 2, placement front, socket 1" in text
          and text.count("\n#ront\t") == 1, text[-400:])
    check("keys: and the others stand", [r[:2] for r in table(path)[1]] == [["front", "0"], ["left", "0"]])


for test in (usage, silence, unmapped, finds_by_listening, two_candidates, unknown_type, by_itself, keys):
    test()
finish()
