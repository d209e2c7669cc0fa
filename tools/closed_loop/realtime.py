"""The same over UDP by the clock: robot at 1 kHz and controller, no lock-step.

realtime.py [SECONDS] moves the peg to and fro and measures each cycle: how late it began, and how long the
controller's answer took. Both run with real-time priority where that is allowed.
"""
import gc
import os
import subprocess
import sys

import numpy as np

import arm
import failures
import robot
import run

DEADLINE = 2e-3  # s
SILENCE = 50     # ms until either side gives up: shared machines stop for longer than the usual 10 and 20


def priority(pid):
    try:
        os.sched_setscheduler(pid, os.SCHED_FIFO, os.sched_param(50))
        return True
    except OSError:
        return False


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60
    load = os.getloadavg()[0]
    r = robot.Robot(run.URDF, arm.ARMS["sprung"])
    raised = priority(0)  # LCM's thread and the controller inherit it
    r.connect()
    p = failures.start(r, "--stale", "%g" % (1e-3 * SILENCE), lock_step=False)
    failures.hold(r)

    def each(cycle):
        if cycle % 2000 == 1000:
            failures.hold(r, offset=(0, 0.05 * (-1) ** (cycle // 2000), 0.01))
    gc.disable()
    late, answer = r.real_time(seconds, each, SILENCE)
    p.terminate()
    said = p.communicate()[1].strip()
    us = lambda x: "%.0f us" % (1e6 * x)
    print("%d cycles at 1 kHz, load average %.1f, real-time priority: %s" % (
        len(late), load, "yes" if raised else "no"))
    print("cycle begins late: median %s, 99.9 %% %s, longest %s" % tuple(
        us(x) for x in (np.median(late), np.quantile(late, 0.999), late.max())))
    print("controller answers: median %s, 99.9 %% %s, longest %s; unanswered %d" % (
        *(us(x) for x in (np.nanmedian(answer), np.nanquantile(answer, 0.999), np.nanmax(answer))),
        np.isnan(answer).sum()))
    missed = int((~(late + answer <= DEADLINE)).sum())
    print("deadlines of %g ms missed: %d" % (1e3 * DEADLINE, missed))
    print("controller: " + said.replace("\n", "; "))
    if r.limp:
        print("not ok in control to the end: " + r.limp)
        return 1
    print("ok in control to the end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
