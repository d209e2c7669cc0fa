"""serve ended by kill -9, by power cuts that forget what was not synced, and with failing syncs.

After littlefs's tests: every acknowledged sample, deletion and session is there after the restart, and nothing
else but what was asked for last; the exit code says where something could not be written."""
import os
import random
import shutil
import signal
import subprocess
import time

from foreign import Arm, BUILD, Client, MUKCA, ROOT, check, finish, fresh, mukca, serve, stop, table

ROUNDS = 100 if os.environ.get("MUKCA_LONG") else 8
SHIM = os.path.join(BUILD, "lcm", "fault.so")
random.seed(int(os.environ.get("POWER_SEED", "4")))


def build_shim():
    with open(MUKCA, "rb") as program:
        if b"__asan_init" in program.read():
            print("skip power cuts: a sanitizer has the memory functions")
            return False
    os.makedirs(os.path.dirname(SHIM), exist_ok=True)
    command = ["cc", "-O1", "-shared", "-fPIC", "-o", SHIM, os.path.join(ROOT, "tests", "fault", "fault.c"), "-ldl"]
    if subprocess.run(command, capture_output=True).returncode:
        print("skip power cuts: tests/fault/fault.c is for Linux on x86-64 with glibc")
        return False
    return True


def read(path):
    with open(path, "rb") as f:
        return f.read()


def prime(disk, folder):
    """What the shim knows of a folder that is on disk as it is."""
    with open(os.path.join(disk, "folder-%d" % os.stat(folder).st_ino), "w") as f:
        for e in os.scandir(folder):
            f.write("%d %s %s\n" % (e.inode(), "d" if e.is_dir() else "f", e.name))
    for e in os.scandir(folder):
        if e.is_dir():
            prime(disk, e.path)
        else:
            shutil.copy(e.path, os.path.join(disk, "file-%d" % e.inode()))
            os.link(e.path, os.path.join(disk, "held-%d" % e.inode()))


def restore(disk, inode, to, torn):
    """The folder as it was when it was last synced; `torn`: some bytes that were not synced are there, too."""
    os.makedirs(to)
    listing = os.path.join(disk, "folder-%d" % inode)
    for line in open(listing) if os.path.exists(listing) else ():
        number, kind, name = line.rstrip("\n").split(" ", 2)
        path = os.path.join(to, name)
        if kind == "d":
            restore(disk, int(number), path, torn)
            continue
        kept, now = (os.path.join(disk, what + number) for what in ("file-", "held-"))
        content = read(kept) if os.path.exists(kept) else b""
        after = read(now) if os.path.exists(now) else b""
        if torn and after.startswith(content):
            content = after[:random.randint(len(content), len(after))]
        with open(path, "wb") as f:
            f.write(content)


def cut_power(state, disk, torn):
    """Replace the folder by what a power cut leaves."""
    restore(disk, os.stat(state).st_ino, state + ".new", torn)
    shutil.rmtree(state)
    os.rename(state + ".new", state)
    shutil.rmtree(disk)
    os.makedirs(disk)
    prime(disk, state)


class Model:
    """What was acknowledged, and what was asked for last without an answer."""

    def __init__(self):
        self.rows, self.session, self.doubt, self.refused = {}, None, None, 0

    def ask(self, client, seconds, verb, *arguments):
        """A command; whether it was obeyed."""
        self.doubt = (verb, *arguments)
        answer = client.command(verb, *arguments, seconds=seconds)
        if answer:
            self.doubt = None
            self.refused += answer.code == 6
        return answer and answer.code == 0

    def step(self, client, seconds):
        """One request; its answer within that time."""
        chance = random.random()
        if self.session is None or chance < 0.04:
            name = random.choice(("state", "a", "a.offsets", "b"))
            if self.ask(client, seconds, "start", name):
                self.session = name
                self.rows.setdefault(name, [])
            return
        rows = self.rows[self.session]
        if chance < 0.14 and len(rows) > 2:
            if self.ask(client, seconds, "delete"):
                rows.pop()
            return
        self.doubt = ("add", client.next)
        sample = client.trigger(str(len(rows) // 50), str(len(rows) % 2), seconds=seconds)
        if sample:
            self.take(sample)

    def take(self, sample):
        self.doubt = None
        if sample.accepted:
            self.rows[self.session].append(list(sample.position))
        self.refused += not sample.accepted and "not recorded" in sample.text

    def compare(self, state):
        """What the files lack, or have beyond; then the files are what counts."""
        wrong = []
        for name, rows in self.rows.items():
            path = os.path.join(state, "sessions", name + ".tsv")
            try:
                header, lines = table(path)
            except (OSError, IndexError):
                if rows: # the first sample creates the file
                    wrong.append("%s: lost with %d rows" % (name, len(rows)))
                continue
            found = [[float(x) for x in line[3:10]] for line in lines if len(line) == len(header)]
            doubt = self.doubt[0] if self.doubt and name == self.session else ""
            if found != rows and not (doubt == "add" and found[:-1] == rows) and not (
                    doubt == "delete" and found == rows[:-1]):
                wrong.append("%s: %d rows instead of %d after %s, the first %d alike" % (
                    name, len(found), len(rows), doubt or "an answer",
                    [a == b for a, b in zip(found + [0], rows + [1])].index(False)))
            self.rows[name] = found
        if self.doubt and self.doubt[0] == "start":
            self.session = None
        return wrong


def mended(state):
    """The torn rest of rows goes when serve resumes; the others are as they were left."""
    for name in os.listdir(os.path.join(state, "sessions")) if os.path.isdir(os.path.join(state, "sessions")) else ():
        path = os.path.join(state, "sessions", name)
        content = read(path)
        if content and not content.endswith(b"\n"):
            with open(path, "wb") as f:
                f.write(content[:content.rfind(b"\n") + 1])


def good_state(state):
    """A table that the state names is whole."""
    path = os.path.join(state, "state.tsv")
    if not os.path.exists(path):
        return True
    fields = dict(line.rstrip("\n").split("\t") for line in open(path))
    model = fields.get("model")
    return not model or read(os.path.join(state, "results", model)).endswith(b"\n")


def rounds(kind, client):
    """Serve, request, end; ROUNDS times on one folder."""
    state, disk = fresh("power_" + kind), fresh("power_" + kind + ".disk")
    prime(disk, state)
    model, wrong, done = Model(), [], 0
    for k in range(5 * ROUNDS):
        if k >= ROUNDS and done > ROUNDS and any(model.rows.values()):
            break
        more = {"kill": {}, "cut": {"LD_PRELOAD": SHIM, "FAULT_DISK": disk},
                "sync": {"LD_PRELOAD": SHIM, "FAULT": "fsync:%d" % random.randint(1, 60)}}[kind]
        p = serve(state, "--accept", "all", window="0.02", **more)
        model.refused = 0
        if not client.wait_stream():
            early = p.poll()
            if kind == "sync" and early == 6:  # it could not keep its folder
                continue
            wrong.append("%d: no stream: %s" % (k, p.said[-3:]))
            break
        client.wait(lambda: False, 0.05)
        end = time.monotonic() + random.uniform(0, 0.6)
        client.answers.clear()
        model.doubt = None
        while time.monotonic() < end and not model.doubt:
            model.step(client, max(0.001, end - time.monotonic()) if kind != "sync" else 5)
            done += 1
        if kind == "sync":
            code = stop(p)
            if code not in ((6,) if model.refused else (0, 6)) or (code == 6 and not p.said):
                wrong.append("%d: exit code %d after %d refusals" % (k, code, model.refused))
        else:
            if random.random() < 0.3 and model.session:
                m = mukca.command()
                m.id, m.verb = 1 << 40, "calibrate"
                client.lc.publish("MUKCA_COMMAND", m.encode())
                time.sleep(random.uniform(0, 0.15))
            if kind == "cut":
                os.killpg(p.pid, signal.SIGKILL)  # a calculation, too
            p.send_signal(signal.SIGKILL)
            p.wait()
            while client.lc.handle_timeout(0) > 0:  # acknowledged in its last moment
                pass
            late = client.answers.get((mukca.sample, model.doubt[1])) if model.doubt and model.doubt[0] == "add" else None
            if late:
                model.take(late)
        if kind == "cut":
            cut_power(state, disk, torn=random.random() < 0.5)
        mended(state)
        wrong += ["%d: %s" % (k, what) for what in model.compare(state)]
        if not good_state(state):
            wrong.append("%d: the table in use is gone" % k)
    kept = sum(map(len, model.rows.values()))
    check("%s: %d times, %d requests, %d samples kept in %d sessions" % (kind, k + 1, done, kept, len(model.rows)),
          not wrong and kept and done > ROUNDS, wrong[:6])


def main():
    client = Client()
    with Arm("iiwa", [0.1] * 7, 1000, "IIWA_STATUS"):
        for kind in os.environ.get("POWER_KINDS", "").split() or (("kill", "cut", "sync") if build_shim() else ("kill",)):
            rounds(kind, client)
    finish()


main()
