"""The folder of serve: names that meet no other file, one server, finished sessions."""
import fcntl
import os

from foreign import Arm, Client, ROWS, check, ended, finish, fresh, serve, stop, table, take


def recorded(state, name):
    return [[float(x) for x in row[3:10]] for row in table(os.path.join(state, "sessions", name + ".tsv"))[1]]


def names(client, arm):
    """Sessions that are called like other files of the server."""
    state = fresh("state_names")
    wanted = {}
    p = serve(state, heard=client)
    for i, name in enumerate(("state", "a.offsets", "lock", "sessions", "results", "a.calibrate.json")):
        answer = client.command("start", name)
        check("names: start " + name, answer.code == 0, answer.text)
        wanted[name] = take(client, arm, ROWS[4 * i:4 * i + 3])
        client.wait(lambda: False, 0.6)  # the state is saved
    client.command("start", "a")
    wanted["a"] = take(client, arm, [ROWS[i * len(ROWS) // 14] for i in range(14)])
    answer = client.command("calibrate")
    check("names: calibrate", answer.code == 0, answer.text)
    stop(p)
    for name, rows in wanted.items():
        check("names: all samples of %s are kept" % name, len(rows) >= 3 and recorded(state, name) == rows,
              (len(rows), name))
    return state


def one_server(client, state):
    """A second server says who holds the folder; litter of killed writers goes."""
    litter = [os.path.join(state, folder, ".x.tsv.1.tmp") for folder in ("", "sessions", "results")]
    for path in litter:
        open(path, "w").close()
    p = serve(state, heard=client)
    check("folder: what killed writers left is removed", not any(os.path.exists(path) for path in litter))
    second = serve(state)
    code = ended(second)
    check("folder: a second serve is refused and names the first", code == 3 and len(second.said) == 1 and
          "process %d" % p.pid in second.said[0], (code, second.said))
    check("folder: the first goes on", p.poll() is None and client.command("start", "x").code == 0)
    stop(p)
    with open(os.path.join(state, "lock")) as lock:  # as the child of a killed server for a moment
        fcntl.flock(lock, fcntl.LOCK_EX)
        p = serve(state)
        client.wait(lambda: False, 0.5)
    check("folder: free again, after a moment", client.wait_stream(), p.said)
    stop(p)


def finished(client, arm):
    """A finished session after a restart: calculations work, and samples are added only if it is reopened."""
    state = fresh("state_finished")
    p = serve(state, "--accept", "all", heard=client)
    client.command("start", "a")
    rows = take(client, arm, [ROWS[i * len(ROWS) // 14] for i in range(14)])
    check("finished: finish", len(rows) == 14 and client.command("finish").code == 0)
    check("finished: calibrate", client.command("calibrate").code == 0)
    check("finished: use", client.command("use").code == 0)
    stop(p)
    p = serve(state, heard=client)
    client.wait(lambda: False, 1)
    sample = client.trigger("p", "0", seconds=2)
    check("finished: a restart does not open it again", client.status.session == "" and not sample.accepted,
          client.status.session)
    check("finished: results after a restart", [client.command(verb).code for verb in
                                                ("result", "calibrate", "diagnose")] == [0, 0, 0])
    check("finished: reopen must be named", client.command("start", "a").code == 1)
    check("finished: another begins", client.command("start", "b").code == 0)
    stop(p, 9)
    p = serve(state, "--accept", "start,trigger,reopen,finish", heard=client)
    check("finished: one that is not goes on after a kill", client.wait(lambda: "b.tsv" in client.status.session, 5))
    check("finished: reopened", client.command("start", "a").code == 0)
    check("finished: and continued", len(take(client, arm, ROWS[1:2])) == 1 and len(recorded(state, "a")) == 15)
    stop(p)


def main():
    client = Client()
    with Arm("iiwa", ROWS[0][2], 200, "IIWA_STATUS") as arm:
        state = names(client, arm)
        one_server(client, state)
        finished(client, arm)
    finish()


main()
