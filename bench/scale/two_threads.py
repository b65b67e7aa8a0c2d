#!/usr/bin/env python3
"""How much of a command's work several threads share: two_threads.py COMMAND ARGUMENT ...

Adds up the CPU time that passes while one thread alone is running or ready to run, and while several are, and prints what
two free cores would make of it. That does not depend on what else the cores have to do, unlike seconds. It is an upper bound:
a thread that waits for work spins for a while before it sleeps. Linux; needs nothing but Python's standard library."""

import os
import subprocess
import sys
import time

POLL_S = 0.004


def threads_of(pid):
    """{thread: (CPU time in ns, its state)}"""
    threads = {}
    try:
        for thread in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{thread}/schedstat") as file:
                nanoseconds = int(file.read().split()[0])
            with open(f"/proc/{pid}/task/{thread}/stat") as file:
                state = file.read().rpartition(")")[2].split()[0]
            threads[thread] = (nanoseconds, state)
    except OSError:
        pass  # it has just ended
    return threads


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    process = subprocess.Popen(sys.argv[1:])
    before = threads_of(process.pid)
    alone_s = together_s = 0.0
    while process.poll() is None:
        time.sleep(POLL_S)
        now = threads_of(process.pid)
        passed_s = sum(now[thread][0] - before.get(thread, (0,))[0] for thread in now) / 1e9
        busy = [thread for thread in now if "D" in (now[thread][1], before.get(thread, (0, "S"))[1])
                or "R" in (now[thread][1], before.get(thread, (0, "S"))[1])]
        if len(busy) > 1:
            together_s += passed_s
        else:
            alone_s += passed_s
        before = now
    factor = (alone_s + together_s) / max(alone_s + together_s / 2, 1e-9)
    print(f"alone {alone_s:.1f} s, together {together_s:.1f} s: at most {factor:.2f} times as fast with two threads")
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
