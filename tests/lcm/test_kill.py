"""Killed with -9 at random moments of a session: every acknowledged sample is in the file."""
import os
import random
import signal
import time

from foreign import accepted, Arm, Client, ROOT, check, finish, fresh, mukca, spawn, stop, table

URDF = os.path.join(ROOT, "data", "demo", "arm.urdf")
KILLS = 100 if os.environ.get("MUKCA_LONG") else 12
random.seed(9)


def main():
    path = os.path.join(fresh("kill"), "s.tsv")
    acknowledged, starts, lost, torn = [], 0, [], 0
    client = Client()
    with Arm("iiwa", [0.1] * 7, 1000, "IIWA_STATUS") as arm:
        while starts < KILLS or len(acknowledged) <= KILLS and starts < 5 * KILLS:
            p = spawn("capture", "--urdf", URDF, "-o", path, "--channel", "IIWA_STATUS", "--map",
                      "order", "--trigger", "--resume", "--window", "0.02", "--wait", "20")
            starts += 1
            if not client.wait_stream():
                break
            moment = time.monotonic() + random.uniform(0, 0.4)
            client.answers.clear()
            while time.monotonic() < moment:  # triggers and undos as fast as they are answered
                sample = client.trigger(str(len(acknowledged) // 100), str(len(acknowledged) % 2),
                                        seconds=max(0.001, moment - time.monotonic()))
                if sample and sample.accepted:
                    acknowledged.append(list(sample.position))
            p.send_signal(signal.SIGKILL)
            p.wait()
            while client.lc.handle_timeout(0) > 0:  # acknowledged in its last moment
                pass
            late = [m for m in client.answers.values() if isinstance(m, mukca.sample) and m.accepted]
            header, rows = table(path)
            torn += sum(len(row) != len(header) for row in rows)
            rows = [[float(x) for x in row[3:10]] for row in rows if len(row) == len(header)]
            lost += [q for q in acknowledged + [list(m.position) for m in late] if q not in rows]
            acknowledged = rows
        p = spawn("capture", "--urdf", URDF, "-o", path, "--channel", "IIWA_STATUS", "--map", "order",
                  "--trigger", "--resume", "--window", "0.02")
        good = client.wait_stream() and client.status.rows == len(acknowledged)
        good = good and accepted(client, client.trigger)
        stop(p, signal.SIGINT)
    check("%d kills: all of %d acknowledged rows are in the file" % (starts, len(acknowledged)),
          not lost and not torn and starts >= KILLS and len(acknowledged) > KILLS, (len(lost), torn, starts, p.said))
    check("and --resume goes on", good, p.said)
    finish()


main()
