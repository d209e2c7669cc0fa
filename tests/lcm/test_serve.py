"""mukca serve: restarts, jobs, poses, bad commands, its client, its service manager, replay."""
import json
import os
import signal
import socket
import subprocess
import xml.etree.ElementTree

import foreign
from foreign import Arm, Client, MUKCA, check, ended, finish, fresh, mukca, robots, stop, table, take, told

NAME, KIND, _, CHANNEL, URDF, ROWS = robots()[-1]
ROWS = [ROWS[i * len(ROWS) // 24] for i in range(24)]


def serve(state, *more, **how):
    return foreign.serve(state, "--accept", "all", *more, urdf=URDF, channel=CHANNEL, **how)


def send(*arguments, **more):
    return subprocess.run([MUKCA, "send", *arguments], capture_output=True, text=True, timeout=60,
                          **more)


def say_code(answer):
    return answer and (answer.code, answer.text)


def the_whole_job(client, arm, state):
    p = serve(state, heard=client)
    check("a result before any calibration is refused", client.command("result").code == 1)
    for verb, arguments, code in (("start", ("../x",), 2), ("start", ("a b",), 2), ("dance", (), 2),
                                  ("delete", ("x",), 2), ("add", (), 1), ("delete", (), 1),
                                  ("socket", (), 1), ("calibrate", (), 1), ("finish", (), 1)):
        told("without a session, %s %s: code %d" % (verb, " ".join(arguments), code), client.command(verb, *arguments), code)
    status, refused = (os.path.join(state, "%s.json" % name) for name in ("status", "refused"))
    shown = send("status", "--json", status)
    with open(status) as f:
        seen = json.load(f)
    check("send status --json, before a session", shown.returncode == 0 and seen["expected_m"] is None
          and seen["channel"] == CHANNEL and seen["rows"] == 0, seen)
    code = send("add", "--json", refused).returncode
    with open(refused) as f:
        seen = json.load(f)
    check("send --json of a refused command", (seen["verb"], seen["code"], code) == ("add", 1, 1), seen)
    check("start", client.command("start", "first").code == 0)
    check("a label that would break the file is refused",
          not client.trigger("a\tb", "0").accepted and client.command("socket", "x,y").code == 1)
    answer = client.command("calibrate")
    check("an empty session calibrates to an error in words", answer.code == 3 and answer.text,
          say_code(answer))
    check("rows are taken", len(take(client, arm, ROWS[:20])) == 20, p.said[-3:])
    told("delete", client.command("delete"), 0, "sample 20 deleted")
    check("and again", len(take(client, arm, ROWS[19:20])) == 1)
    client.command("placement", "elsewhere")
    client.command("socket", "1")
    check("SIGTERM ends it with 0", stop(p) == 0, p.said)
    p = serve(state, heard=client)
    client.wait(lambda: client.status.rows == 20, 5)
    s = client.status
    check("it goes on after a restart", (s.rows, s.placement, s.socket) == (20, "elsewhere", "1"),
          (s.rows, s.placement, s.socket, p.said))
    check("rows go on", len(take(client, arm, ROWS[20:])) == len(ROWS) - 20)
    client.wait(lambda: client.status.rows == len(ROWS), 5)
    check("placement and socket are those of the last trigger", client.status.placement == ROWS[-1][0])
    first = client.command("calibrate")
    check("calibrate", first and first.code in (0, 1) and first.n >= 42, say_code(first))
    number = client.next
    for _ in range(2):  # the second comes while the first runs
        m = mukca.command()
        m.id, m.verb, m.n, m.argument = client.next, "diagnose", 0, []
        client.next += 1
        client.lc.publish("MUKCA_COMMAND", m.encode())
    second = client.answer(mukca.result, number + 1, 10)
    check("one job at a time", second and second.code == 1 and "running" in second.text, say_code(second))
    answer = client.answer(mukca.result, number, 60)
    verdict = answer and answer.json and json.loads(answer.json).get("verdict")
    check("diagnose", answer and answer.code in (0, 1) and verdict, say_code(answer))
    stop(p)
    return first


def its_fleet(client, state):
    """--traits reaches the jobs; a table of another model ends the server."""
    summary, traits = os.path.join(state, "summary.json"), os.path.join(state, "traits.tsv")
    session = os.path.join(os.path.dirname(URDF), "train.tsv")
    if not os.path.exists(session):
        print("skip fleet: only with the demo's arm, which the short run plays")
        return
    subprocess.run([MUKCA, "diagnose", "-q", "--urdf", URDF, session, "--arm",
                    "demo", "--summary", summary], check=True)
    with open(summary) as f:
        model = json.load(f)
    with open(traits, "w") as f:
        f.write("# geometry: %(geometry)s\n# masses: %(masses)s\n# arms: 7\n" % model)
        f.write("effect\tjoint\tterm\tmean\tspread\tarms\tlog_bayes_factor\tprobability\terror\n"
                "joint_compliance\tjoint_4\t\t5e-5\t1e-5\t7\t9\t0.99\t1e-6\n")
    factory = os.path.join(state, "factory.yaml")
    with open(factory, "w") as f:
        for joint in xml.etree.ElementTree.parse(URDF).getroot().iter("joint"):
            numbers = (joint.find("origin").get("xyz") + " " + joint.find("origin").get("rpy")).split()
            f.write("%s: {x: %s, y: %s, z: %s, roll: %s, pitch: %s, yaw: %s}\n" % (joint.get("name"), *numbers))
    p = serve(state, "--traits", traits, "--kinematics", factory, heard=client)
    answer = client.command("calibrate")
    with open(os.path.join(state, "results", "first.offsets.tsv")) as f:
        check("serve --kinematics: calibrate has it", "\n# kinematics_sha256: " in f.read(), say_code(answer))
    used = answer and answer.json and json.loads(answer.json)["traits"]
    check("serve --traits: calibrate has them", used and used["arms"] == 7, say_code(answer))
    stop(p)
    with open(traits, "a") as f:
        f.write("backlash\tjoint_4\t\t5e-5\t1e-5\t7\t9\t0.99\t1e-6\n")
    p = serve(state, "--traits", traits)
    check("traits that cannot be read: exit code 3", p.wait(10) == 3, p.said)


def poses(client, arm, state):
    """Poses equal `mukca fk` with the same table, message by message."""
    p = serve(state, "--publish-pose", heard=client)
    client.command("calibrate")
    check("use", client.command("use").code == 0, p.said)
    got = []
    joints = {}
    a = client.lc.subscribe("MUKCA_POSE", lambda c, d: got.append(mukca.pose.decode(d)))
    a.set_queue_capacity(0)

    def keep(_, data):
        m = type(arm.message()).decode(data)
        joints[m.utime] = getattr(m, "joint_position", getattr(m, "joint_position_measured", None))
    b = client.lc.subscribe(CHANNEL, keep)
    b.set_queue_capacity(0)
    arm.go(ROWS[3][2])
    client.wait(lambda: len(got) >= 300, 10)
    client.lc.unsubscribe(a)
    client.lc.unsubscribe(b)
    check("poses come for each joint state", len(got) >= 300, len(got))
    header = table(os.path.join(state, "sessions", "first.tsv"))[0]
    n = len(ROWS[0][2])
    source = os.path.join(state, "poses.tsv")
    pairs = [(g, joints[g.utime]) for g in got if g.utime in joints]
    with open(source, "w") as f:
        f.write("\t".join(header[3:3 + n]) + "\n")
        for _, q in pairs:
            f.write("\t".join("%.17g" % x for x in q) + "\n")
    # mukca fk applies the same table
    model = [line.split("\t")[1].strip() for line in open(os.path.join(state, "state.tsv"))
             if line.startswith("model\t")][0]
    answer = subprocess.run([MUKCA, "fk", "--urdf", URDF, "--offsets", os.path.join(state, "results", model), "--pose",
                             source], capture_output=True, text=True)
    lines = [line.split("\t") for line in answer.stdout.splitlines() if not line.startswith("#")]
    columns = [lines[0].index(c) for c in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
    worst = max((abs(a - float(line[c])) for (g, _), line in zip(pairs, lines[1:])
                 for a, c in zip(list(g.position) + list(g.quaternion), columns)), default=1)
    check("poses equal mukca fk with the same table", len(lines) == len(pairs) + 1 and worst < 1e-12,
          (worst, answer.stderr))
    check("SIGTERM", stop(p) == 0)
    check("the poses are counted", any("poses sent" in line for line in p.said), p.said)
    p = serve(state, "--publish-pose", "--stream", "corrected", heard=client)
    got.clear()
    a = client.lc.subscribe("MUKCA_POSE", lambda c, d: got.append(d))
    client.wait(lambda: bool(got), 0.5)
    client.lc.unsubscribe(a)
    stop(p)
    check("offsets of a raw stream are not applied to a corrected one",
          not got and any("count twice" in line for line in p.said), p.said)


def its_client(client, state):
    answer = send("status", "--timeout", "1")
    check("send: no server is exit 4 within the time-out", answer.returncode == 4 and
          "is mukca serve running" in answer.stderr, answer.stderr)
    p = serve(state, heard=client)
    answer = send("status")
    check("send status", answer.returncode == 0 and json.loads(answer.stdout)["channel"] == CHANNEL, answer.stdout)
    answer = send("result")
    rows = [line.split("\t") for line in answer.stdout.splitlines()]
    direct = client.command("result")
    same = [(r[0], r[1], float(r[4])) for r in rows[1:]] == list(
        zip(direct.joint, direct.parameter, direct.calibrated))
    check("send result prints the table", answer.returncode == 0 and same, answer.stderr)
    answer = send("delete", "x")
    check("send: the exit code is the command's", answer.returncode == 2 and "too many arguments" in
          answer.stderr, answer.stderr)
    answer = send("socket", "1")
    check("send with an argument", answer.returncode == 0 and "socket 1" in answer.stdout, answer.stdout)
    example = subprocess.run([MUKCA, "help", "send"], capture_output=True, text=True).stdout.split("Example:")[1].strip()
    check("help example: " + example, send(*example.split()[2:]).returncode == 0)
    stop(p)


def its_manager(client, state):
    path = os.path.join(state, "notify")
    s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    s.bind(path)
    s.settimeout(5)
    p = serve(state, NOTIFY_SOCKET=path)
    words = []
    try:
        words.append(s.recv(100))
        words.append(s.recv(100))
        p.send_signal(signal.SIGTERM)
        while words[-1] != b"STOPPING=1":
            words.append(s.recv(100))
    except socket.timeout:
        pass
    check("the service manager is told", words[0] == b"READY=1" and b"WATCHDOG=1" in words and
          words[-1] == b"STOPPING=1", words)
    stop(p)


def replays(client, arm):
    """A log with joint states, triggers and commands gives the same results again."""
    state, again = fresh("serve_live"), fresh("serve_again")
    log = os.path.join(state, "raw.lcmlog")
    logger = subprocess.Popen(["lcm-logger", "-q", "-f", log], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    client.wait(lambda: False, 1)
    p = serve(state, heard=client)
    client.command("start", "s")
    check("replay: rows", len(take(client, arm, ROWS)) == len(ROWS))
    client.command("calibrate")
    stop(p)
    client.wait(lambda: False, 0.3)
    logger.send_signal(signal.SIGINT)
    logger.wait(10)
    p = serve(again, "--lcm-url", "file://" + log)
    check("replay: ends with the log", ended(p, 60) == 0, p.said)
    for name in ("sessions/s.tsv", "results/s.offsets.tsv"):
        texts = [[line for line in open(os.path.join(folder, name)) if not line.startswith("# ")]
                 for folder in (state, again)]
        check("replay: the same " + name, texts[0] == texts[1] and len(texts[0]) > len(ROWS), name)


def main():
    client, state = Client(), fresh("serve")
    with Arm(KIND, ROWS[0][2], 200, CHANNEL) as arm:
        the_whole_job(client, arm, state)
        its_fleet(client, state)
        poses(client, arm, state)
        its_client(client, state)
        its_manager(client, state)
        replays(client, arm)
    finish()


main()
