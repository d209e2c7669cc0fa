"""7-axis status at 1 kHz: no message lost, memory flat, little of a core (60 s with MUKCA_LONG)."""
import os
import time

from foreign import Arm, Client, URDF, check, finish, fresh, said, spawn, stop

LONG = bool(os.environ.get("MUKCA_LONG"))
SECONDS = 60 if LONG else 5


def usage(pid):
    """CPU seconds and resident kB of a process."""
    with open("/proc/%d/stat" % pid) as f:
        fields = f.read().rsplit(")", 1)[1].split()
    with open("/proc/%d/status" % pid) as f:
        resident = next(int(line.split()[1]) for line in f if line.startswith("VmRSS"))
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"), resident


def soak(name, *arguments):
    client = Client()
    with Arm("iiwa", [0.1] * 7, 1000, "IIWA_STATUS") as arm:
        arm.paused = True
        p = spawn(*arguments, "--urdf", URDF, "--channel", "IIWA_STATUS", "--map", "order")
        client.wait(lambda: bool(p.said), 20)  # listens, and says that it hears nothing
        arm.paused = False
        client.wait(lambda: client.status and client.status.received > 5000, 60)  # its buffers are full
        arm.paused = True
        client.wait(lambda: client.status.received == arm.sent, 2)
        before = arm.sent - client.status.received  # the first multicasts of a busy machine do not leave it
        arm.paused = False
        cpu, resident = usage(p.pid)
        started = time.monotonic()
        client.wait(lambda: False, SECONDS)
        cpu2, resident2 = usage(p.pid)
        share = 100 * (cpu2 - cpu) / (time.monotonic() - started)
        arm.paused = True
        client.wait(lambda: client.status.received == arm.sent, 10)
        client.wait(lambda: False, 0.6)
        sent, received = arm.sent, client.status.received
        stop(p)
    print("%s: %d sent, %d received in %d s, %.1f %% of a core, %+d kB" %
          (name, sent, received, SECONDS, share, resident2 - resident))
    # a starved process loses some, which it reports
    check(name + ": no message lost", sent - received == before or sent - received > before and said(p, "dropped"),
          (received, sent, before, p.said))
    check(name + ": memory is flat", resident2 - resident < 200, resident2 - resident)
    if LONG:
        check(name + ": under 5 % of a core", share < 5, share)


folder = fresh("soak")
soak("serve", "serve", "--state", folder)
soak("serve with poses", "serve", "--state", folder, "--publish-pose")
soak("capture", "capture", "-o", os.path.join(folder, "s.tsv"), "--trigger", "--wait", "20")
finish()
