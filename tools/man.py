#!/usr/bin/env python3
"""The COMMANDS section of mukca(1), from the help of each command: MUKCA=build/mukca tools/man.py"""
import os
import re
import subprocess

MUKCA = os.environ.get("MUKCA", "build/mukca")


def mukca(*words):
    return subprocess.run([MUKCA, "help", *words], capture_output=True, text=True, check=True).stdout


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.M)


def section(help_text, title):
    found = re.search(rf"\n{title}:\n(.*?)(\n\n|\Z)", help_text, re.S)
    return found.group(1).rstrip("\n") if found else ""


def options(text):
    """(name with argument, help) of each option of a section."""
    for entry in re.split(r"\n(?=  -)", text):
        if entry:
            name, words = re.match(r"  (-.*?)(?:  +|\n +)(.*)", entry, re.S).groups()
            words = re.sub(r"\n +one of: (.*)", r" (\1)", words)
            yield name, re.sub(r"\n +", " ", words)


def main():
    commands = list(dict.fromkeys(line.split("\t")[0] for line in mukca("options").splitlines()[1:]))
    common, pages = {}, []
    for command in commands:
        text = mukca(command)
        summary = re.match(rf"mukca {command}: (.*?)\n\n", text, re.S).group(1).replace("\n", " ")
        usage, description = re.search(r"\nUsage: (.*?)\n\n(.*?)\n\n(?:Common o|O)ptions:", text, re.S).groups()
        page = [f'.SS "mukca {command}"', f".B {roff(usage)}", ".PP", roff(summary) + ".", ".PP",
                roff(description).replace("\n\n", "\n.PP\n")]
        for name, words in options(section(text, "Options")):
            page += [".TP", f"\\fB{roff(name)}\\fR", roff(words)]
        shared = dict(options(section(text, "Common options")))
        common.update(shared)
        names = [re.search("--[a-z-]+", name).group(0) for name in shared]
        page += [".PP", "Common options: " + roff(", ".join(names)) + ".", ".PP", "Example:", ".PP", ".nf",
                 roff(section(text, "Example")), ".fi"]
        pages.append("\n".join(page))
    print('.SH COMMANDS\n.SS "Common options"\nThese mean the same in every command that has them.')
    for name, words in common.items():
        print(f".TP\n\\fB{roff(name)}\\fR\n{roff(words)}")
    print("\n".join(pages))


main()
