"""How long `chebid --help` takes, as a multiple of `python -c "import numpy"`: at most 2 is promised.

    python tests/bench/startup.py [--rounds N]

The two alternate, so that whatever else the machine does meets both; the medians are compared.
"""

import argparse
import statistics
import subprocess
import sys
import time

HELP = [sys.executable, "-c", "import sys; from chebid.cli import main; sys.argv = ['chebid', '--help']; main()"]
NUMPY = [sys.executable, "-c", "import numpy"]
NOTHING = [sys.executable, "-c", "pass"]


def seconds(command: list[str]) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    commands = {"chebid --help": HELP, "import numpy": NUMPY, "python alone": NOTHING}
    for command in commands.values():  # compiles what is not compiled yet
        seconds(command)
    times: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(rounds):
        for name, command in commands.items():
            times[name].append(seconds(command))
    for name, taken in times.items():
        print(f"{name:14} {statistics.median(taken):.3f} s (least {min(taken):.3f} s)")
    ratio = statistics.median(times["chebid --help"]) / statistics.median(times["import numpy"])
    print(f"ratio          {ratio:.2f} (at most 2)")


if __name__ == "__main__":
    main()
