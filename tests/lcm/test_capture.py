"""mukca capture with a foreign sender: finding the stream, mapping, triggers, keys."""
import os
import signal
import subprocess
import termios
import time

from foreign import Arm, Client, HOME, JOINTS, MUKCA, ROOT, Terminal, URDF, check, ended, finish, fresh, said, spawn, stop, table, take, until

work = fresh("capture")
count = 0


def out():
    global count
    count += 1
    return os.path.join(work, "s%d.tsv" % count)


def capture(path, *arguments, **more):
    return spawn("capture", "--urdf", URDF, "-o", path, "--window", "0.1", *arguments, **more)


def ends(name, code, words, *arguments):
    """capture with these arguments ends with that code and these words."""
    p = capture(out(), "--trigger", *arguments)
    ended(p)
    check(name, p.returncode == code and said(p, words), p.said)


def posture(i):
    return [x + 0.3 * ((i * (j + 3)) % 7 - 3) / 3 for j, x in enumerate(HOME)]


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
        ends("a mapping by order must be confirmed", 2, "--map order", "--channel", "IIWA_STATUS")
    with Arm("iiwa", HOME + HOME, 100, "IIWA_STATUS"):
        ends("two arms in one message need numbers", 3, "--map 8-14", "--channel", "IIWA_STATUS", "--map", "order")


def finds_by_listening():
    shuffled = list(reversed(JOINTS))
    client, path = Client(), out()
    with Arm("state", list(reversed(HOME)), 200, "ROBOT.STATE+1", names=shuffled) as arm, \
            Arm("iiwa", HOME[:3], 100, "OTHER"):
        p = capture(path, "--trigger", "--rows", "3")
        check("the channel is found by listening, joints by name", client.wait_stream(), p.said)
        take(client, arm, [("", "", list(reversed(posture(i)))) for i in range(3)])
        p.wait(20)
        check("--rows ends the session", p.returncode == 0, p.said)
    header, rows = table(path)
    check("columns are the URDF's joints", header[3:10] == JOINTS, header)
    check("readings went to the joints of their names",
          all(abs(float(r[3 + j]) - posture(i)[j]) < 2e-6 for i, r in enumerate(rows) for j in range(7)),
          rows)


def two_candidates():
    with Arm("iiwa", HOME, 100, "A"), Arm("panda", HOME, 100, "B"):
        ends("two streams that fit are not guessed between", 3, "choose with --channel")


def unknown_type():
    path, client = out(), Client()
    description = os.path.join(ROOT, "tests", "lcm", "types", "arm_t.lcm")
    with Arm("acme", HOME, 200, "MY_ARM", names=JOINTS) as arm:
        ends("an unknown type is told with the way to describe it", 3, "--type FILE.lcm --position FIELD",
             "--channel", "MY_ARM")
        p = capture(out(), "--trigger", "--wait", "3")
        for _ in range(20):  # until it has heard the channel
            client.wait(lambda: False, 0.1)
            sample = client.trigger()
            if sample and "heard" in sample.text:
                break
        ended(p)
        check("without a channel, too", p.returncode == 4 and
              said(p, "MY_ARM (unknown type); describe an unknown type with --type"), p.said)
        check("and a trigger says why nothing is recorded", sample and not sample.accepted and
              sample.text.startswith("no session is being recorded: no joint state; heard instead: MY_ARM") and
              "--type FILE.lcm" in sample.text, sample and sample.text)
        p = capture(path, "--trigger", "--type", description, "--position", "joints.q", "--names",
                    "joints.name", "--rows", "2")
        check("a described type is understood", client.wait_stream(), p.said)
        take(client, arm, [("", "", posture(i)) for i in range(2)])
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
    options = ("capture", "--urdf", URDF, "-o", path, "--window", "0.1", "--channel", "IIWA_STATUS")
    t, seen = None, 0

    def shown(words, other=None):
        """Whether the words come next on the screen; what is before them counts no more."""
        nonlocal seen
        until(lambda: words.encode() in t.text[seen:] or other and other in t.text[seen:], 15)
        at = t.text.find(words.encode(), seen)
        seen = seen if at < 0 else at + len(words.encode())
        return at >= 0

    def press(key):
        nonlocal seen
        seen = len(t.text)
        t.press(key.encode())

    def does(what, words, key=None):
        """One line of the outcome: after the key, if there is one, the words come."""
        if key:
            press(key)
        check("keys: " + what, shown(words), t.text[-2000:])

    def adds(what, words):  # again while the arm still moves
        check("keys: " + what, until(lambda: press("a") or shown(words, other=b"not recorded")), t.text[-2000:])
    with Arm("iiwa", posture(0), 200, "IIWA_STATUS") as arm:
        t = Terminal(*options, "--placement", "front,left")
        does("the mapping is printed and asked about", "Is that right?")
        does("the view comes", "finish", "y\n")
        adds("a adds", "sample 1: placement front, socket 0")
        does("the bell rings for it", "\a")
        arm.go(posture(1))
        does("s goes to the other socket", "now placement front, socket 1", "s")
        adds("and a adds there", "sample 2: placement front, socket 1")
        does("d deletes", "sample 2 deleted", "d")
        does("n begins the next placement", "now placement left, socket 0", "n")
        adds("a adds to it", "sample 2: placement left, socket 0")
        does("the view counts", "1 of 20 \u00b7 placement 2 of 4")
        does("and shows the samples", "samples      2:")
        arm.go(posture(2), 3)
        time.sleep(0.3)
        does("a moving arm is refused", "not recorded: the arm moves", "a")
        check("keys: and the bell rings twice", shown("\a") and shown("\a"), t.text[-2000:])
        does("? lists the keys", "d delete the last", "?")
        does("q finishes", "no placement has two sockets", "q")
        check("keys: exit 0", t.ended() == 0, t.p.returncode)
        check("keys: the terminal is as it was", termios.tcgetattr(t.slave) == t.before)
        seen = 0
        t.start(*options, "--map", "order", "--resume")
        does("resumed where it was", "1 of 20")
        t.p.send_signal(signal.SIGINT)
        shown("--resume continues")
        check("keys: interrupted with 130", t.ended() == 130, t.p.returncode)
        check("keys: the terminal is as it was after ^C", termios.tcgetattr(t.slave) == t.before)
    with open(path) as f:
        text = f.read()
    check("keys: the undone row left its record", "# undone: row 2, placement front, socket 1" in text
          and text.count("\n#ront\t") == 1, text[-400:])
    check("keys: and the others stand", [r[:2] for r in table(path)[1]] == [["front", "0"], ["left", "0"]])


for test in (usage, silence, unmapped, finds_by_listening, two_candidates, unknown_type, by_itself, keys):
    test()
finish()
