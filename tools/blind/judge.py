"""What of an answer of `mukca diagnose` is right: one record per case, from which all figures are sums."""
import math

NOISE_LENGTH = 1.5958       # mean length of a normal vector in space, unit deviation per axis
SURE = 8.0                  # snr * sqrt(3 postures) from which an effect ought to be found
OLD_OUTSIDE = {"local_fault", "cable_pull", "thermal_link", "joint_slip"}   # sets without a class
SESSION = ("zero_jump", "ball_shift", "socket_distance")    # no matter of a held-out placement


def effect_ok(cause, truth):
    """Right effect; a tilting base and bending at joint 1 count as one thing."""
    said, true = cause.get("effect"), truth["effect"]
    if said == true:
        return True
    if true == "base_compliance":
        return said == "link_bending" and cause.get("joint") == "joint_1"
    return (true == "link_bending" and truth.get("joints") == ["joint_1"]
            and said == "base_compliance")


def right(cause, truth):
    """Right effect in the right joint (or placement, for what belongs to one)."""
    if not effect_ok(cause, truth):
        return False
    if truth["effect"] == "ball_shift":
        return cause.get("placement") in (None, f"p{truth['placement']}")
    if not truth.get("joints") or cause.get("effect") == "base_compliance":
        return True
    return cause.get("joint") in truth["joints"]


def alias(cause, truth):
    """Pairs that the design declares hard to tell apart, other than the truth itself."""
    number = lambda j: int(j.rsplit("_", 1)[1]) if j else 0  # noqa: E731
    said, at, true = cause.get("effect"), number(cause.get("joint")), truth["effect"]
    for j in [number(x) for x in truth.get("joints", [])] or [0]:
        for a, p, b, q in ((said, at, true, j), (true, j, said, at)):
            if a == "link_bending" and b == "joint_compliance" and p - q in (0, 1):
                return True
            if p == q and (a, b) in (("joint_scale", "encoder_eccentricity"),
                                     ("backlash", "joint_compliance")):
                return True
            base = a == "base_compliance" or (a, p) == ("link_bending", 1)      # one thing
            if base and b == "joint_compliance" and q == 2:
                return True
            if a == "base_compliance" and b == "link_bending" and q in (1, 2):
                return True
    return False


def near(cause, truth):
    """Nearest relative of a cause outside the catalogue; such a name is neither right nor wrong."""
    return any(cause.get("effect") == e and j in (None, cause.get("joint"))
               for e, j in truth.get("near", []))


def plain(cause):
    """Stated without reserve."""
    return not cause.get("ties") and not cause.get("or_unknown")


def rows_said(answer, kinds):
    return {f.get("row") for f in answer.get("data_faults", []) if f.get("kind") in kinds}


def motion_ok(cause, e):
    """The moved socket is named; a step within three rows of where it happened."""
    return (cause.get("effect") == "tool_motion" and cause.get("placement") == f"p{e['placement']}"
            and str(cause.get("socket")) == str(e["socket"])
            and bool(e.get("creep") or abs((cause.get("row") or -99) - e["first_row"]) <= 3))


def motion_found(answer, e):
    faults = [dict(f, effect=f.get("kind")) for f in answer.get("data_faults", [])]
    return any(motion_ok(c, e) for c in answer.get("causes", []) + faults)


def true_of(cause, truths):
    """1 right, 0 wrong, None near: of one named cause."""
    for e in truths:
        if motion_ok(cause, e) if e["effect"] == "tool_motion" else right(cause, e):
            return 1
    return None if any(near(cause, e) for e in truths) else 0


def claims(answer, truths):
    """Every stated probability: [probability, right, stated without reserve, name]."""
    out = []
    for c in answer.get("causes", []):
        for x in [c] + [dict(t, ties=[c]) for t in c.get("ties", [])]:
            if x.get("probability") is not None:
                at = x.get("joint") or x.get("placement") or ""
                out.append([x["probability"], true_of(x, truths), plain(x),
                            f"{x['effect']} {at}".strip()])
    return out


class Record(dict):
    """Facts of one case; flags are hits of figures in which the case takes part."""

    def flag(self, name, hit):
        self["flags"][name] = bool(hit)

    def judge(self, label, r):
        truths, kind, group = label["effects"], label["kind"], self["class"]
        self["claims"] = claims(r, truths)
        self["verdict"] = r.get("verdict")
        self["note"] = getattr(self, group)(label, r, truths, r.get("causes", []))
        wrong = [c for c in self["claims"] if c[1] == 0 and c[2]]
        if self["verdict"] in ("named", "tied"):
            self.flag("stated above 0.9 without reserve and wrong", any(c[0] > 0.9 for c in wrong))
            self.flag("stated above 0.95 without reserve and wrong", any(c[0] > 0.95 for c in wrong))
        if any(c[0] > 0.95 for c in wrong):
            self["note"] += " SURE AND WRONG"
        t, floor = r.get("test") or {}, NOISE_LENGTH * label["ball_noise_m"]
        if (label["detectable"] and group in ("effect", "mixture") and kind not in SESSION
                and t.get("geometry_m") and t.get("explained_m") and t["geometry_m"] > 1.3 * floor):
            self["removed"] = (t["geometry_m"] - t["explained_m"]) / (t["geometry_m"] - floor)

    def none(self, label, r, truths, causes):
        faults = {f.get("kind") for f in r.get("data_faults", [])}
        bad = r.get("verdict") != "none" or bool(
            faults if label["kind"] == "none" else faults - {"outlier"})
        self.flag("false alarms on null", bad)
        self.flag("false alarms, " + ("heavy" if label["kind"] == "none_heavy" else
                                      "correlated" if label["ar"] else "Gaussian"), bad)
        how = self["readings"]
        self.flag("false alarms, read " + how, bad)
        if how != "once":
            self.flag(f"null, {how}: named", r.get("verdict") == "named")
            self.flag(f"null, {how}: any name listed", causes)
        return "FALSE ALARM" if bad else "ok"

    def unknown(self, label, r, truths, causes):
        e, verdict = truths[0], r.get("verdict")
        hit = verdict == "unknown" or bool(r.get("unexplained"))
        mild = any(near(c, e) for c in causes)
        if not label["detectable"]:
            self.flag("faint effect misnamed", verdict == "named" and not mild)
            return "faint"
        self.flag("outside the catalogue: unknown", hit)
        self.flag("outside the catalogue: unknown or nearest relative", hit or mild)
        self.flag("outside the catalogue: none", verdict == "none")
        self.flag("outside the catalogue: confident name",
                  verdict in ("named", "tied") and not hit and not mild)
        if label["kind"] in ("local_fault", "cable_pull"):
            where = sorted(r.get("where", {}).get("joints", []), key=lambda x: -x.get("share", 0))
            self.flag("outside the catalogue: joint located",
                      where and where[0].get("joint") in e["joints"])
        return ("ok" if hit else "near name" if mild else "missed" if verdict == "none"
                else "MISNAMED")

    def convention(self, label, r, truths, causes):
        named = any(right(c, truths[0]) for c in causes)
        self.flag("columns of another convention: refused, unknown or named",
                  named or r.get("verdict") in ("refused", "untestable", "unknown")
                  or r.get("unexplained"))
        self.flag("columns of another convention: named", named)
        return "named" if named else str(r.get("verdict"))

    def fault(self, label, r, truths, causes):
        kind, verdict = label["kind"], r.get("verdict")
        if kind in ("tool_motion", "tool_creep", "effect_and_motion"):
            hit = motion_found(r, truths[-1])
            if kind != "effect_and_motion":
                self.flag(kind.replace("_", " ") + " found", hit)
                self.flag("tool motion: something else blamed",
                          [c for c in causes if c.get("effect") != "tool_motion"])
                return "ok" if hit else "missed"
            self.flag("effect beside a moved tool: motion", hit)
            ok = any(effect_ok(c, truths[0]) for c in causes)
            if truths[0]["snr"] * math.sqrt(3 * self["samples"]) >= SURE:
                self.flag("effect beside a moved tool: effect", ok)
            return ("ok" if hit else "missed") + ", effect " + ("ok" if ok else "missed")
        true = {x + 1 for x in truths[0]["rows"]}
        said = rows_said(r, {"duplicate": ("duplicate",)}.get(kind, ("wrong_socket", "outlier")))
        hit = (all({x - 1, x} & said for x in true) if kind == "duplicate" else
               true <= said and (kind == "outlier" or len(said) <= len(true) + 3))
        self.flag(kind.replace("_", " ") + " found", hit)
        self.flag(kind.replace("_", " ") + ": nothing else blamed", verdict == "none")
        return "ok" if hit else "missed"

    def mixture(self, label, r, truths, causes):
        if not all(e["snr"] * math.sqrt(3 * self["samples"]) >= SURE for e in truths):
            named = causes[:1] + (causes[0].get("ties", []) if causes else [])
            self.flag("faint effect misnamed", r.get("verdict") == "named" and not any(
                effect_ok(c, e) for c in named for e in truths))
            return "faint mixture"
        hits = [any(effect_ok(c, e) for c in causes) for e in truths]
        self.flag("mixtures: first cause right",
                  causes and any(effect_ok(causes[0], e) for e in truths))
        self.flag("mixtures: both found", all(hits))
        self.flag("mixtures: something spurious",
                  any(not any(effect_ok(c, e) for e in truths) for c in causes))
        if label.get("same_joint"):
            self.flag("mixtures in one joint: both found", all(hits))
        return f"{sum(hits)}/2"

    def beside(self, label, r, truths, causes):
        """An effect of the catalogue, and a cause outside it."""
        if not label["detectable"]:
            return "faint"
        named = [any(right(c, truths[0]) for c in causes),
                 r.get("verdict") == "unknown" or bool(r.get("unexplained"))]
        self.flag("effect beside an unknown cause: effect named", named[0])
        self.flag("effect beside an unknown cause: unknown", named[1])
        return f"effect {named[0]}, unknown {named[1]}"

    def effect(self, label, r, truths, causes):
        e, top = truths[0], causes[0] if causes else {}
        named = causes[:1] + top.get("ties", [])
        cls, whole = bool(top) and effect_ok(top, e), bool(top) and right(top, e)
        inside = any(right(c, e) for c in named)
        self["answer"] = [cls, whole, inside]
        if not label["detectable"]:
            bad = r.get("verdict") == "named" and not any(effect_ok(c, e) for c in named)
            self.flag("faint effect misnamed", bad)
            return "faint " + ("WRONG" if bad else "ok")
        self.flag("effect class right (first)", cls)
        self.flag("effect and joint right (first)", whole)
        self.flag("truth in the reported tie set", inside)
        if whole and e["effect"] == "gear_harmonic" and top.get("order"):
            self.flag("ripple: order within 2 %", abs(top["order"] / e["order"] - 1) <= 0.02)
        self["ties"] = max(1, len(named))
        if top.get("probability") is not None:
            self["brier"] = (top["probability"] - float(whole)) ** 2
        total = e["snr"] * math.sqrt(3 * self["samples"])
        band = next(t for x, t in ((12, "8-12"), (20, "12-20"), (40, "20-40"), (1e9, "> 40"))
                    if total < x)
        self["bands"] = {"snr*sqrt(3 postures)": band, "placements": str(label["placements"]),
                         "postures per socket": str(label["per_socket"]), "robot": label["robot"],
                         "readings": self["readings"], "arm": self["arm"]}
        return ("ok" if whole else "class only" if cls else "tied" if inside
                else f"WRONG {r.get('verdict')} {top.get('effect')}/{top.get('joint')}")

    def withheld(self, label, r):
        """The true class was taken out of the catalogue: what is said in its place."""
        e, verdict, causes = label["effects"][0], r.get("verdict"), r.get("causes", [])
        top = causes[0] if causes else {}
        said = [[c["probability"], int(alias(c, e) or effect_ok(c, e)), plain(c), c["effect"]]
                for c in causes if c.get("probability") is not None]
        good = [any(alias(c, e) or effect_ok(c, e) for c in [c] + c.get("ties", [])) for c in causes]
        sure = [c for c, ok in zip(causes, good)
                if not ok and plain(c) and (c.get("probability") or 0) > 0.9]
        if verdict == "unknown" or r.get("unexplained"):
            what = "unknown"
        elif not causes:
            what = "none"
        elif any(alias(c, e) or effect_ok(c, e) for c in [top] + top.get("ties", [])):
            what = "declared alias"
        else:
            what = "tied wrong names" if verdict == "tied" else "CONFIDENT WRONG NAME"
        for w in ("unknown", "declared alias", "none", "tied wrong names", "CONFIDENT WRONG NAME"):
            self.flag("withheld: " + w, w == what)
        self.flag("withheld: stated above 0.9 and wrong", sure)
        self["claims"], self["verdict"], self["note"] = said, verdict, what


def record(name, label, answer, seconds, withheld=False):
    """The record of a case; answer None: the program refused, or failed where it must not."""
    place = label.get("situation", {})
    old = (label["kind"] if label["kind"] in ("mixture", "beside") else
           "none" if label["kind"].startswith("none") else
           "unknown" if label["kind"] in OLD_OUTSIDE else
           "fault" if label["kind"] in ("tool_motion", "tool_creep", "wrong_socket", "outlier",
                                        "duplicate", "effect_and_motion") else "effect")
    r = Record(case=name, kind=label["kind"], detectable=label["detectable"], flags={},
               samples=label.get("postures", 2 * label["placements"] * label["per_socket"]),
               readings=place.get("readings", "once"), arm=place.get("arm", "serial"),
               seconds=seconds, claims=[])
    r["class"] = label.get("class", old)
    if answer is None and r["class"] == "convention":
        answer = {"verdict": "refused"}
    if answer is None:
        r.flag("failures", True)
        r["note"], r["verdict"] = "FAILED", None
    elif withheld:
        r.withheld(label, answer)
    else:
        r.flag("failures", False)
        r.judge(label, answer)
    return r
