"""Hostile traffic in mid-session: no crash, no hang, no sample lost, one clear line each."""
import os

import lcm

from foreign import Arm, Client, HOME, URDF, check, drake, finish, fresh, mukca, said, spawn, stop, table, take, until

CHANNEL = "IIWA_STATUS"


class Session:
    """A capture session under attack."""

    def __init__(self, name, arm):
        self.folder = fresh("hostile_" + name)
        self.path = os.path.join(self.folder, "s.tsv")
        self.client, self.arm, self.rows, self.turn = Client(), arm, [], 0
        self.p = spawn("capture", "--urdf", URDF, "-o", self.path, "--channel", CHANNEL, "--map",
                       "order", "--trigger", "--window", "0.05", "--wait", "20")
        check(name + ": begins", self.client.wait_stream(), self.p.said)

    def take(self):
        """One row at a new posture; True when it was accepted."""
        self.turn += 1
        q = [x + 0.1 * ((self.turn * (j + 2)) % 5 - 2) for j, x in enumerate(HOME)]
        kept = take(self.client, self.arm, [("p", str(self.turn % 2), q)])
        self.rows += kept
        return bool(kept)

    def said(self, words):
        """Number of lines with those words, once there is one."""
        until(lambda: said(self.p, words))
        return said(self.p, words)

    def end(self, name):
        check(name + ": still alive, ends cleanly", self.p.poll() is None and stop(self.p, 2) == 130,
              self.p.said[-5:])
        written = [[float(x) for x in row[3:10]] for row in table(self.path)[1]]
        check(name + ": no acknowledged row lost", written == self.rows, (len(written), len(self.rows)))
        check(name + ": few lines", len(self.p.said) < 60 + 2 * self.turn, len(self.p.said))


def wrong_numbers():
    """NaN, infinity, degrees; time that stands, leaps and goes back; the stream stops and returns."""
    with Arm("iiwa", HOME, 200, CHANNEL) as arm:
        s = Session("numbers", arm)
        check("numbers: a row before", s.take())
        lc = lcm.LCM()
        for value in (float("nan"), float("inf"), 57.3):
            m = arm.message()
            m.joint_position_measured = [value] + list(m.joint_position_measured)[1:]
            for _ in range(50):
                lc.publish(CHANNEL, m.encode())
        check("numbers: NaN is told once", s.said("no finite number") == 1, s.p.said)
        check("numbers: degrees are told once", s.said("no angle in rad") == 1, s.p.said)
        lc.publish(CHANNEL, arm.message().encode()[:-1])
        lc.publish("MUKCA_TRIGGER", mukca.trigger().encode()[:-1])
        check("numbers: malformed messages are told", s.said("malformed") > 0, s.p.said)
        check("numbers: a row after", s.take())
        with arm.lock:
            arm.utime -= 3600 * 1000000
        check("numbers: a clock that goes back is told", s.said("went back") == 1, s.p.said)
        check("numbers: a row after", s.take())
        with arm.lock:
            arm.utime = 2 ** 62
        check("numbers: a row after a leap", s.take(), s.p.said)
        arm.paused = True
        check("numbers: silence is told", s.said("heard instead") == 1, s.p.said)
        sample = s.client.trigger()
        check("numbers: no row from a dead stream", sample and not sample.accepted and "old" in sample.text,
              sample and sample.text)
        arm.paused = False
        check("numbers: its return is told", s.said("is back") == 1, s.p.said)
        check("numbers: a row after", s.take(), s.p.said)
        s.end("numbers")


def two_arms():
    """A second arm on the channel: of the same type, of another size, of another type."""
    with Arm("iiwa", HOME, 200, CHANNEL) as arm:
        s = Session("arms", arm)
        check("arms: a row before", s.take())
        with Arm("iiwa", HOME[:6], 100, CHANNEL):
            check("arms: another size is told", s.said("6 joints instead of 7") == 1, s.p.said)
        with Arm("panda", HOME, 100, CHANNEL):
            check("arms: another type is told", s.said("now sends drake.lcmt_panda_status") == 1, s.p.said)
        check("arms: a row after", s.take())
        s.end("arms")


for test in (wrong_numbers, two_arms):
    test()
finish()
