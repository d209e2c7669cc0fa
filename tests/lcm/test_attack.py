"""Raw hostile datagrams against serve, capture and send: they live, memory stays flat, good messages
still come."""
import hmac
import os
import select
import socket
import struct
import subprocess
import sys
import time
import types

import foreign
from foreign import (Arm, Client, HOME, MUKCA, ROWS, URDF, accepted, check, finish, fresh, mukca, said, serve, spawn,
                     stop, take, told, until)

GROUP = ("239.255.76.67", 7667)
LONG = bool(os.environ.get("MUKCA_LONG"))
MEMORY_KIB = 64 * 1024
COMMON = ("--urdf", URDF, "--channel", "IIWA_STATUS", "--map", "order", "--window", "0.05")


def open_socket():
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    return s


class Network:
    """What the tests use of liblcm's client, which the attacks would end."""

    def __init__(self):
        self.sender, self.sequence, self.handlers = open_socket(), 0, {}
        self.receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.receiver.bind(GROUP)
        self.receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                                 socket.inet_aton(GROUP[0]) + bytes(4))

    def publish(self, channel, data):
        self.sequence += 1
        self.sender.sendto(small(channel, data, sequence=self.sequence), GROUP)

    def subscribe(self, channel, handler):
        self.handlers[channel] = handler
        return self

    def set_queue_capacity(self, _):
        pass

    def handle_timeout(self, milliseconds):
        if not select.select([self.receiver], [], [], milliseconds / 1000)[0]:
            return 0
        channel, end, data = self.receiver.recv(65536)[8:].partition(b"\0")
        handler = self.handlers.get(channel.decode(errors="replace")) if end else None
        try:
            if handler:
                handler(channel.decode(), data)
        except (ValueError, struct.error):
            pass  # an attack on this channel
        return 1


foreign.lcm = types.SimpleNamespace(LCM=Network)


def small(channel, data=b"", end=b"\0", sequence=1):
    return b"LC02" + struct.pack(">I", sequence) + channel.encode() + end + data


def fragment(data, size, offset, number, count, channel="MUKCA_TRIGGER", end=b"\0", sequence=1):
    head = b"LC03" + struct.pack(">IIIHH", sequence, size, offset, number, count)
    return head + (channel.encode() + end if number == 0 else b"") + data


def trigger():
    m = mukca.trigger()
    m.id, m.placement, m.socket = 1, "a", "0"
    return m.encode()


def long_text():
    """A trigger whose text claims to be 2 GB long."""
    data = bytearray(trigger())
    data[24:28] = struct.pack(">I", 0x7ffffff0)
    return bytes(data)


# name: datagrams
ATTACKS = {
    "offset and size wrap 32 bits": [fragment(b"A" * 64, 100, 0xffffffe0, 0, 2)] * 20,
    "fragment's channel without end": [fragment(b"", 100, 1, 0, 2, end=b"", sequence=i)
                                       for i in range(50)],
    "channel without end": [small("MUKCA_TRIGGER", end=b"")] * 200,
    "text longer than its message": [d for i in range(500) for d in
                                     (small("MUKCA_TRIGGER", long_text(), sequence=i),
                                      small("MUKCA_TRIGGER", end=b""))],
    "more fragments than bytes": [fragment(b"A", 10, 0, 0, 65535, sequence=i) for i in range(50)],
    "beginnings of large messages": [fragment(b"A" * 64, 8 << 20, 0, 0, 200, sequence=i)
                                     for i in range(2000)],
    "overlapping fragments": [fragment(b"A" * 60, 100, 40 * k, k, 2, sequence=i)
                              for i in range(200) for k in (0, 1)],
    "short datagrams": [b"LC02\0\0\0\1ARM"[:n] for n in range(12)] * 20 + [b""] * 20,
    "no LCM at all": [os.urandom(n) for n in range(0, 1500, 7)],
}


# The address sanitizer keeps what was freed: its memory says nothing of ours.
with open(MUKCA, "rb") as program:
    SANITIZED = b"__asan_init" in program.read()


def memory(p):
    with open("/proc/%d/status" % p.pid) as f:
        return [int(line.split()[1]) for line in f if line.startswith("VmRSS")][0]


def attack(s, datagrams, p):
    for i, d in enumerate(datagrams):
        s.sendto(d, GROUP)
        if i % 100 == 99:
            time.sleep(0.005)
    return p.poll() is None


def recorders():
    """Each attack in mid-session."""
    for command in ("serve", "capture"):
        folder, client, s = fresh("attack_" + command), Client(), open_socket()
        more = ("--state", folder) if command == "serve" else \
            ("--trigger", "-o", os.path.join(folder, "s.tsv"), "--wait", "20")
        with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
            p = spawn(command, *COMMON, *more)
            check(command + ": begins", client.wait_stream(), p.said)
            if command == "serve":
                client.command("start", "x")
            check(command + ": a sample before", take(client, arm, [ROWS[0]]), p.said[-3:])
            before = memory(p)
            for i, (name, datagrams) in enumerate(ATTACKS.items()):
                alive = attack(s, datagrams, p)
                check("%s: %s" % (command, name), alive and take(client, arm, [ROWS[i + 1]]),
                      (p.poll(), p.said[-3:]))
                if not alive:
                    return
            check(command + ": a sample after", take(client, arm, [ROWS[20]]), p.said[-3:])
            check(command + ": memory is flat", SANITIZED or memory(p) - before < 8192, (before, memory(p)))
            check(command + ": drops are reported", until(lambda: said(p, "dropped")), p.said)
            code = stop(p)
            check(command + ": ends cleanly", code in (0, 130), (code, p.said[-3:]))


def listeners():
    """Sockets of this network that are bound to LCM's port."""
    with open("/proc/net/udp") as f:
        return sum(":%04X " % GROUP[1] in line for line in f)


def client_of_serve():
    for name, datagrams in ATTACKS.items():
        before = listeners()
        p = subprocess.Popen([MUKCA, "send", "status", "--timeout", "1"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True)
        until(lambda: listeners() > before)
        attack(open_socket(), [d.replace(b"MUKCA_TRIGGER", b"MUKCA_STATUS") for d in datagrams[:300]], p)
        text = p.communicate(timeout=60)[1]
        check("send: " + name, p.returncode == 4 and "no answer" in text, (p.returncode, text))


def flood(name, make, seconds):
    """Messages as fast as they can be sent; then the time until a command is answered."""
    state, client = fresh("flood_" + name), Client()
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state)
        check("flood of %s: begins" % name, client.wait_stream(), p.said)
        client.command("start", "s")
        check("flood of %s: a sample before" % name, take(client, arm, [ROWS[0]]), p.said[-3:])
        s, end, sent, most = open_socket(), time.monotonic() + seconds, 0, 0
        while time.monotonic() < end and p.poll() is None:
            for _ in range(200):
                s.sendto(make(sent), GROUP)
                sent += 1
            most = max(most, memory(p))
        time.sleep(0.1)  # a full buffer of the kernel drops the command before the program sees it
        begin = time.monotonic()
        answer = client.command("socket", "0", seconds=20)
        wait = time.monotonic() - begin
        print("# %s: %.0f messages/s, at most %.1f MB, answer after %.2f s, %d lines" %
              (name, sent / seconds, most / 1024, wait, len(p.said)))
        check("flood of %s: memory" % name, SANITIZED or 0 < most < MEMORY_KIB, most)
        check("flood of %s: a command is answered" % name, answer, p.said[-3:])
        check("flood of %s: a sample after" % name, take(client, arm, [ROWS[5]]), p.said[-3:])
        # each of the 50 requests a second that one sender may make leaves a line, the rest none
        check("flood of %s: few lines" % name, len(p.said) < 200 + 50 * seconds, len(p.said))
        check("flood of %s: ends cleanly" % name, stop(p) == 0)


def command(verb, *arguments):
    m = mukca.command()
    m.id, m.verb, m.n, m.argument = 5, verb, len(arguments), list(arguments)
    return m.encode()


def unicast():
    """A command that another machine sends to the port, not to the group."""
    if subprocess.run("ip link add v0 type veth peer name v1", shell=True, capture_output=True).returncode:
        print("skip unicast: no veth in this namespace")
        return
    state, client = fresh("unicast"), Client()
    other = subprocess.Popen(["unshare", "-n", "sleep", "60"])
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state, heard=client)
        there = "nsenter -t %d -n " % other.pid
        path = os.path.join(state, "datagram")
        with open(path, "wb") as f:
            f.write(small("MUKCA_COMMAND", command("start", "from_afar")))
        send = ("import socket; s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM); "
                "s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 1); "
                "[s.sendto(open('%s', 'rb').read(), (a, 7667)) for a in ('10.9.0.1', '239.255.76.67')]" % path)
        for line in ("ip link set v1 netns %d" % other.pid, "ip addr add 10.9.0.1/24 dev v0",
                     "ip link set v0 up", there + "ip addr add 10.9.0.2/24 dev v1",
                     there + "ip link set v1 up", there + "ip route add 224.0.0.0/4 dev v1"):
            subprocess.run(line, shell=True, check=True)
        until(lambda: "UP" in subprocess.run("ip -br link show v0", shell=True, capture_output=True, text=True).stdout.split())
        subprocess.run(there + sys.executable + " -c \"%s\"" % send, shell=True, check=True)
        check("unicast: a command after them is answered", client.command("result"), p.said)
        check("unicast and multicast of another machine are not obeyed",
              not os.path.exists(os.path.join(state, "sessions", "from_afar.tsv")), p.said)
        stop(p)
    other.kill()
    other.wait()


def rights():
    """What serve refuses unless --accept names it; lines for people hold no control characters."""
    state, client = fresh("rights"), Client()
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state)
        check("rights: begins", client.wait_stream(), p.said)
        client.command("start", "a")
        check("rights: a sample", take(client, arm, [ROWS[0]]), p.said[-3:])
        sample = client.trigger("p\x7f\u202e\x1b[2J", "0", seconds=2)
        check("rights: a label with control characters is refused", sample and not sample.accepted and
              sample.text.startswith('"p?????[2J" or "0" cannot be a name'), sample and sample.text)
        told("rights: delete must be named", client.command("delete"), 1, "--accept")
        check("rights: the open session may be started again", client.command("start", "a").code == 0)
        client.command("finish")
        told("rights: reopen must be named", client.command("start", "a"), 1, "reopen")
        for verb in ("x\nserve: sample 99 recorded", "\x1b[2J", "\x7f", "a\u202eb\u009bc"):
            client.lc.publish("MUKCA_COMMAND", command(verb))
        client.wait(lambda: False, 0.5)
        text = "".join(p.said)
        check("rights: lines are escaped", not any(c in text for c in "\x1b\x7f\u202e\u009b") and
              not any(line.startswith("serve: sample 99") for line in p.said), p.said[-5:])
        time.sleep(0.1)  # a full buffer of the kernel drops the command before the program sees it
        begin = time.monotonic()
        codes = [client.command("start", "s%d" % i).code for i in range(30)]
        made, took = len(os.listdir(os.path.join(state, "sessions"))) - 1, time.monotonic() - begin
        check("rights: new sessions are limited", codes[0] == 0 and made < 12 + 0.1 * took, (codes, made, took))
        stop(p)
        p = serve(state, "--accept", "start,reopen,delete", heard=client)
        check("rights: reopen named", client.command("start", "a").code == 0)
        sample = client.trigger("p", "0", seconds=1)
        check("rights: triggers not named", sample and not sample.accepted and "--accept" in sample.text, sample)
        check("rights: delete named", client.command("delete").code == 0)
        stop(p)
    p = serve(state, "--accept", "dance")
    check("rights: unknown command", p.wait(10) == 2)
    for option in ("--interface", "--from"):
        p = serve(state, option, "lo")
        check("rights: %s takes an address" % option, p.wait(10) == 2)


def forged_states():
    """A second sender of joint states that differ by less than the noise of a gear."""
    state, client = fresh("forged"), Client()
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state, "--from", "127.0.0.1,0.0.0.0")
        p.wait(10)
        check("forged: 0.0.0.0 is no sender to name", p.returncode == 2)
        p = serve(state, heard=client)
        client.command("start", "s")
        check("forged: a sample before", take(client, arm, [ROWS[0]]), p.said[-3:])
        with Arm("iiwa", [x + 0.0007 for x in ROWS[0][2]], 200, "IIWA_STATUS"):
            check("forged: it is reported", until(lambda: said(p, "two arms")), p.said)
            samples = [client.trigger("a", "1", seconds=2) for _ in range(5)]
        check("forged: no sample while two send", not any(x and x.accepted for x in samples))
        check("forged: a sample after", take(client, arm, [ROWS[3]]), p.said[-3:])
        stop(p)


def signed(key, channel, data):
    """How any client signs a request: docs/security.md."""
    return data + hmac.digest(key, channel.encode() + b"\0" + data, "sha256")


def signatures():
    """serve --key: unsigned, altered, old and repeated requests are refused; those of clients with the key not."""
    state, client = fresh("signatures"), Client()
    path, key = os.path.join(state, "key"), os.urandom(20).hex().encode()
    with open(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600), "wb") as f:
        f.write(key + b"\n")

    def request(m, alter=lambda data: data, age=0.0, channel="MUKCA_COMMAND"):
        m.utime, m.id = int((time.time() - age) * 1e6), client.next
        client.next += 1
        data = alter(signed(key, channel, m.encode()))
        client.lc.publish(channel, data)
        answer = client.answer(mukca.sample if channel == "MUKCA_TRIGGER" else mukca.result, m.id, 3)
        return data, answer

    def ask(verb, *arguments, **more):
        m = mukca.command()
        m.verb, m.n, m.argument = verb, len(arguments), list(arguments)
        return request(m, **more)

    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        before = signed(key, "MUKCA_COMMAND", command("start", "early"))
        p = serve(state, "--key", path)
        check("signed: begins", client.wait_stream(), p.said)
        client.lc.publish("MUKCA_COMMAND", before)
        told("signed: without a signature", client.command("start", "x"), 1, "--key")
        sample = client.trigger("a", "0")
        check("signed: a trigger without one", sample and not sample.accepted and "--key" in sample.text)
        data, answer = ask("start", "good")
        told("signed: start", answer, 0)
        answer = None
        client.lc.publish("MUKCA_COMMAND", data)
        check("signed: sent twice", (answer := client.answer(mukca.result, client.next - 1, 3)) and
              answer.code == 1 and "sent twice" in answer.text)
        for name, alter in (("altered", lambda d: d.replace(b"start", b"ztart")),
                            ("wrong signature", lambda d: d[:-1] + bytes([d[-1] ^ 1]))):
            answer = ask("start", "bad", alter=alter)[1]
            check("signed: " + name, not answer or answer.code == 1, answer and answer.text)
        for name, age in (("old", 60), ("in the future", -60)):
            told("signed: " + name, ask("start", "bad", age=age)[1], 1, "clocks")
        data = ask("socket", "1")[0]
        client.lc.publish("MUKCA_TRIGGER", data)  # its channel is signed, too
        arm.go(ROWS[0][2])
        client.wait(lambda: False, 0.5)
        t = mukca.trigger()
        t.placement, t.socket = "a", "0"
        check("signed: a trigger", accepted(client, lambda: request(t, channel="MUKCA_TRIGGER")[1]), p.said[-3:])
        send = subprocess.run([MUKCA, "send", "finish", "--key", path], capture_output=True, text=True, timeout=60)
        check("signed: mukca send --key", send.returncode == 0 and "1 samples" in send.stdout, send.stderr)
        send = subprocess.run([MUKCA, "send", "start", "bad"], capture_output=True, text=True, timeout=60)
        check("signed: mukca send without", send.returncode == 1 and "--key" in send.stdout, send.stdout + send.stderr)
        made = sorted(name for name in os.listdir(os.path.join(state, "sessions")) if name.endswith(".tsv"))
        check("signed: one session only", made == ["good.tsv"], made)
        check("signed: ends cleanly", stop(p) == 0)
    again = fresh("signatures_again")
    os.chmod(path, 0o604)
    p = serve(again, "--key", path)
    check("signed: a key that all can read", p.wait(10) == 3)


def controllers():
    """The session belongs to the address that began it, until it is finished."""
    state, client, other = fresh("controllers"), Client(), Client()
    other.lc.sender.bind(("127.0.0.2", 0))
    other.next = 1000
    with Arm("iiwa", HOME, 200, "IIWA_STATUS") as arm:
        p = serve(state)
        check("controllers: begins", client.wait_stream(), p.said)
        check("controllers: one begins a session", client.command("start", "a").code == 0)
        for verb, arguments in (("start", ["b"]), ("socket", ["1"]), ("finish", []), ("calibrate", [])):
            told("controllers: another may not " + verb, other.command(verb, *arguments), 1, "controlled from")
        sample = other.trigger("a", "0")
        check("controllers: nor record", sample and not sample.accepted and "controlled from" in sample.text)
        check("controllers: but ask", "controlled" not in other.command("result").text)
        check("controllers: the first may record", take(client, arm, [ROWS[0]]), p.said[-3:])
        check("controllers: and finish", client.command("finish").code == 0)
        check("controllers: then another may begin", other.command("start", "b").code == 0)
        check("controllers: and the first may not", client.command("finish").code == 1)
        stop(p)


recorders()
client_of_serve()
flood("triggers", lambda i: small("MUKCA_TRIGGER", trigger()), 30 if LONG else 4)
flood("junk", lambda i: small("MUKCA_COMMAND", bytes(1400)), 30 if LONG else 3)
flood("large junk", lambda i: small("MUKCA_COMMAND", bytes(60000)), 30 if LONG else 3)
unicast()
rights()
signatures()
controllers()
forged_states()
finish()
