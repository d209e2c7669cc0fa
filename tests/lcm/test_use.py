"""serve: a result moves no controller by itself, and never one that did not pass."""
import os
import random
import shutil

from foreign import Arm, Client, HOME, ROWS, check, finish, fresh, mukca, serve, stop, take, told

DEFAULT = "start,add,trigger,socket,placement,finish,calibrate,diagnose,result"


def pose(client, arm):
    """The pose that is published at HOME; None: none is."""
    got = []
    arm.go(HOME)
    client.wait(lambda: False, 0.4)
    s = client.lc.subscribe("MUKCA_POSE", lambda c, d: got.append(mukca.pose.decode(d).position))
    client.wait(lambda: len(got) > 3, 1.5)
    client.lc.unsubscribe(s)
    return got[-1] if got else None


def moved(a, b):
    return 1e3 * sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5 if a and b else float("nan")


def turned(path, offset, forged=True):
    """The table at `path` with joint_2 turned by `offset`, and the digest of these lines if `forged`."""
    lines = open(path).read().split("\n")
    for i, line in enumerate(lines):
        cells = line.split("\t")
        if cells[:2] == ["joint_2", "roll"]:
            cells[4:6] = ["%.17g" % (float(x) + offset) for x in cells[4:6]]
            lines[i] = "\t".join(cells)
    value = 14695981039346656037  # FNV-1a
    for byte in "\n".join(lines[:1] + lines[2:]).encode():
        value = (value ^ byte) * 1099511628211 % 2**64
    if forged:
        lines[1] = "# digest: %016x" % value
    return "\n".join(lines)


def session(client, arm, name, rows):
    client.command("start", name)
    taken = len(take(client, arm, rows))
    check(name + ": samples", taken == len(rows), taken)
    answer = client.command("calibrate")
    return answer, client.command("use", name)


def main():
    random.seed(3)
    client, state = Client(), fresh("use")
    good_table = os.path.join(state, "results", "good.offsets.tsv")
    good = [ROWS[i * len(ROWS) // 40] for i in range(40)]
    evil = [("x%d" % random.randrange(2), random.choice("01"), q) for _, _, q in good[:24]]
    still = [("a", "01"[i % 2], [x + 1e-5 * i for x in HOME]) for i in range(12)]
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state, "--publish-pose", "--accept", DEFAULT + ",use", heard=client)
        check("use: nothing to use", client.command("use").code == 1)
        client.command("start", "good")
        check("good: samples", len(take(client, arm, good)) == len(good))
        told("good: accepted, and says what to do", client.command("calibrate"), 0, "`use` puts it into use")
        check("a result publishes no pose", pose(client, arm) is None and client.command("result").code == 1)
        check("use of another session is refused", client.command("use", "evil").code == 1)
        told("use", client.command("use", "good"), 0, "good.offsets.tsv")
        first = pose(client, arm)
        check("poses follow", first is not None)

        # a bad table in use does not keep the good one out
        stop(p)
        bad = turned(good_table, 0.03)
        with open(os.path.join(state, "in_use.tsv"), "w") as f:
            f.write(bad)
        p = serve(state, "--publish-pose", "--accept", DEFAULT + ",use", heard=client)
        distance = moved(first, pose(client, arm))
        check("bad table: its pose", distance > 3, (distance, p.said))
        told("bad table: the good one is taken", client.command("use"), 0, "good.offsets.tsv")
        check("bad table: poses follow", moved(first, pose(client, arm)) < 0.01)

        for name, rows in (("evil", evil), ("still", still)):
            result, used = session(client, arm, name, rows)
            told(name + ": calibrate does not pass", result, 1, "not accepted")
            told(name + ": use is refused with the reason", used, 3, "did not pass")
            check(name + ": the pose stays", moved(first, pose(client, arm)) < 0.01)
            check(name + ": the table in use stays", "good.offsets" in client.command("result").text)
        # a table that says of itself that it passed, and moves the tip: judged anew
        path = os.path.join(state, "results", "still.offsets.tsv")
        for offset, forged, text, code in ((0.03, False, "was edited or cut", 3),
                                           (2.0, True, "mm, more than any calibration", 3),
                                           (0.03, True, "against the table in use, at most 10.0 mm", 1),
                                           (0.004, True, "against the table in use on its own session", 1)):
            table = turned(good_table, offset, forged)
            with open(path, "w") as f:
                f.write(table)
            told("a change of %g rad is refused" % offset, client.command("use"), code, text)
        # the same in one's own session: the file in use is a copy
        shutil.copy(path, os.path.join(state, "results", "good.offsets.tsv"))
        stop(p, 9)
        p = serve(state, "--publish-pose", "--accept", DEFAULT + ",use", heard=client)
        check("after kill -9 the last accepted table is in use", moved(first, pose(client, arm)) < 0.01, p.said)
        stop(p)
        p = serve(state, "--publish-pose", heard=client)
        told("use must be named in --accept", client.command("use"), 1, "naming use")
        stop(p)
        lines = [line for line in open(os.path.join(state, "in_use.tsv")) if not line.startswith(("# accepted", "# digest"))]
        with open(os.path.join(state, "in_use.tsv"), "w") as f:
            f.writelines(lines)
        p = serve(state, "--publish-pose", "--accept", DEFAULT + ",use", heard=client)
        check("a table without a verdict is not used", pose(client, arm) is None and
              any("has no verdict" in line for line in p.said), p.said)
        stop(p)
    finish()


main()
