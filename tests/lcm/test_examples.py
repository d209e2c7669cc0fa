"""The examples in the help of capture, serve and send, as they stand there; and the demo log."""
import os
import subprocess

from foreign import Arm, Client, MUKCA, ROOT, check, finish, fresh, spawn, stop, table

work = fresh("examples")
os.symlink(os.path.join(ROOT, "data"), os.path.join(work, "data"))
os.makedirs(os.path.join(work, "build"))


def example(command):
    text = subprocess.run([MUKCA, "help", command], capture_output=True, text=True).stdout
    text = text.split("Example:")[1].replace("\\\n", " ")
    return [" ".join(line.split()) for line in text.splitlines() if line.strip()]


def run(command):
    for line in example(command):
        p = subprocess.run(line.replace("mukca", "'%s'" % MUKCA, 1), shell=True, capture_output=True, text=True,
                           cwd=work, timeout=60, stdin=subprocess.DEVNULL)
        check("help %s: %s" % (command, line), p.returncode == 0, p.stderr[-400:])
        if command == "capture":
            check("capture answers on standard output", " samples in build/" in p.stdout and
                  "samples in" not in p.stderr, (p.stdout, p.stderr))


run("capture")
run("serve")
captured = os.path.join(work, "build", "guided.tsv")
served = os.path.join(work, "build", "served", "sessions", "guided.tsv")
check("both take the same rows from the demo's log", len(table(captured)[1]) > 20 and
      table(captured) == table(served))
p = spawn("serve", "--urdf", os.path.join(work, "data", "demo", "arm.urdf"), "--state", work,
          "--channel", "X", "--map", "order")
client = Client()
with Arm("iiwa", [0.1] * 7, 100, "X"):
    client.wait_stream()
    run("send")
stop(p)
finish()
