"""A guided session of an iiwa at 200 Hz and a Panda at 1 kHz, driven over LCM from a foreign client:
60 samples, and the calibration that comes back equals the one from files to the last digit."""
import json
import os
import subprocess

from foreign import Arm, Client, MUKCA, accepted, check, finish, fresh, robots, serve, stop, table

SAMPLES = 60


def play(name, kind, rate, channel, urdf, rows):
    state = fresh("guided_" + name.replace(" ", "_"))
    rows = [rows[i * len(rows) // SAMPLES] for i in range(SAMPLES)]
    client = Client()
    p = serve(state, urdf=urdf, channel=channel, window="0.1")
    with Arm(kind, rows[0][2], rate, channel) as arm:
        check(name + ": serve hears the stream", client.wait_stream(), p.said)
        answer = client.command("start", "guided")
        check(name + ": start", answer and answer.code == 0, p.said)
        kept, moving, values = 0, 0, []
        for i, (placement, socket, q) in enumerate(rows):
            arm.go(q, 5.0 if i % 20 == 5 else 0.05)
            if i % 20 == 5:  # in mid-motion; a busy machine may lack joint states at first
                for _ in range(25):
                    client.wait(lambda: False, 0.15)
                    sample = client.trigger(placement, socket)
                    if not sample or sample.accepted or "moves" in sample.text:
                        break
                arm.go(q)
                moving += bool(sample and not sample.accepted and "moves" in sample.text)
            sample = accepted(client, lambda: client.trigger(placement, socket))
            kept += bool(sample and sample.row == i + 1)
            values.append(list(sample.position) if sample else None)
        check(name + ": %d samples" % SAMPLES, kept == len(rows), (kept, p.said[-5:]))
        check(name + ": triggers while moving are refused and say so", moving == 3, moving)
        result = client.command("calibrate")
        sent = arm.sent
        client.wait(lambda: client.status.received >= sent, 10)
        received = client.status.received
    check(name + ": serve ends cleanly", stop(p) == 0, p.said)
    session = os.path.join(state, "sessions", "guided.tsv")
    header, written = table(session)
    n = len(rows[0][2])
    check(name + ": the file holds what was acknowledged",
          [[float(x) for x in row[3:3 + n]] for row in written] == values)
    check(name + ": rows are within the noise of what was played",
          all(abs(a - b) < 2e-6 for v, r in zip(values, rows) for a, b in zip(v, r[2])))
    efforts = [float(written[0][header.index(h)]) for h in header if h.endswith(".effort")]
    check(name + ": efforts hold the arm up", efforts == [1.5 * (i + 1) for i in range(n)], efforts)
    check(name + ": no message lost", received >= sent, (received, sent))
    # the same from files
    answer = subprocess.run([MUKCA, "calibrate", "--urdf", urdf, session, "--json", "-", "-q"],
                            capture_output=True, text=True)
    parameters = json.loads(answer.stdout)["parameters"]
    good = result and result.n == len(parameters) and result.code == answer.returncode
    for i, p in enumerate(parameters if good else []):
        sigma = float("inf") if p["sigma"] is None else p["sigma"]
        good = good and (result.joint[i], result.parameter[i], result.unit[i]) == (
            p["joint"], p["parameter"], p["unit"])
        good = good and (result.nominal[i], result.calibrated[i], result.offset[i], result.sigma[i],
                         bool(result.identifiable[i])) == (
            p["nominal"], p["calibrated"], p["offset"], sigma, p["identifiable"])
    check(name + ": the result over LCM equals the one from files to the last digit", good,
          result and (result.code, result.text, result.n))
    check(name + ": and so does the JSON in it", good and json.loads(result.json)["parameters"] == parameters)


for robot in robots():
    play(*robot)
finish()
