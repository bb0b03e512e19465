"""The blind study: random logs with hidden physics, chebid by its command line, and how often it was right.

    python tests/blind/study.py N SEED [--jobs J] [--out results.csv] [--category C] [--effect E] [--table]

Row i of a seed is always the same log. Rows are appended as they come; a run that was stopped goes on where it was.
"""

import argparse
import csv
import json
import multiprocessing
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from blind import cases  # noqa: E402
from blind.effects import describe  # noqa: E402
from blind.judge import FIELDS, judge  # noqa: E402
from blind.table import confusion, table  # noqa: E402

PATIENCE = 300  # s for one command


def chebid(*words: str) -> tuple[dict[str, Any] | None, str, float]:
    """The JSON document (None without one), what went wrong, and the processor time (s) of one command."""
    script = Path(sys.executable).with_name("chebid")
    start = [str(script)] if script.exists() else [sys.executable, "-m", "chebid"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run([*start, *words], capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return None, f"{words[0]}: no answer after {PATIENCE} s", float(PATIENCE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    trouble = ""
    if "Traceback" in done.stderr + done.stdout or "this is a bug in chebid" in done.stderr:
        trouble = f"TRACEBACK {words[0]}: " + " | ".join(done.stderr.strip().splitlines()[-2:])[:300]
    elif done.returncode:
        trouble = f"{words[0]} exit {done.returncode}: " + " | ".join(done.stderr.strip().splitlines()[-2:])[:300]
    try:
        return json.loads(done.stdout), trouble, spent
    except json.JSONDecodeError:
        return None, trouble or f"{words[0]}: no JSON on stdout", spent


def study_one(seed: int, index: int, category: str | None, effect: str | None) -> dict[str, Any]:
    """One row: draw, simulate, write, identify, diagnose, refine, judge."""
    began = time.perf_counter()
    case = cases.make(seed, index, category, effect)
    made = time.perf_counter() - began
    with tempfile.TemporaryDirectory(prefix="blind") as name:
        folder = Path(name)
        model, log, holdout = map(str, cases.write(case, folder))
        fitted = str(folder / "fitted.yaml")
        _, trouble, identify = chebid("identify", log, "--model", model, "-o", fitted, "--json", "--quiet")
        troubles, documents, spent = [trouble], [None, None], [0.0, 0.0]
        if Path(fitted).exists():
            for k, words in enumerate((("diagnose",), ("refine", "-o", str(folder / "refined.yaml")))):
                documents[k], trouble, spent[k] = chebid(
                    words[0], fitted, log, "--holdout", holdout, "--json", "--quiet", *words[1:]
                )
                troubles.append(trouble)
    row = {"seed": seed, "index": index, "commit": commit()} | _facts(case) | judge(case, *documents)
    row |= {
        "seconds_made": made,
        "seconds_identify": identify,
        "seconds_diagnose": spent[0],
        "seconds_refine": spent[1],
    }
    return row | {"trouble": " ; ".join(filter(None, troubles))}


def commit() -> str:
    """What was tested; a + where the checkout differs from it."""
    words = ("git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty=+", "--exclude=*")
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()


def _facts(case: cases.Case) -> dict[str, Any]:
    s, (first, second) = case.sensors, case.takings
    return {
        "category": case.category, "robot": case.arm.kind, "joints": case.arm.joints, "motion": first.kind,
        "holdout_motion": second.kind, "duration": first.duration, "rate": s.rate, "colour": s.colour,
        "dither": s.dither, "torque": s.torque, "noise_factor": case.noise_factor, "fault": case.fault,
        "asked": case.asked, "dnr": case.dnr, "slow": case.slow, "plain": case.plain,
        "truth": ";".join(f"{e.name}:{'' if e.joint is None else f'q{e.joint + 1}'}" for e in case.effects),
        "law": ";".join(e.law for e in case.effects), "singles": ";".join(f"{x:.3g}" for x in case.singles),
        "values": json.dumps([describe(e) for e in case.effects], default=float),
    }  # fmt: skip


def _work(job: tuple[int, int, str | None, str | None]) -> dict[str, Any]:
    try:
        return study_one(*job)
    except Exception as error:  # a fault of the simulator must not stop the others, nor count against chebid
        return {"seed": job[0], "index": job[1], "category": "not made", "trouble": f"{type(error).__name__}: {error}"}


def read(path: Path) -> list[dict[str, str]]:
    """The rows that are there."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def rows_made(jobs: list[tuple[int, int, str | None, str | None]], workers: int) -> Iterator[dict[str, Any]]:
    if workers == 1:
        yield from map(_work, jobs)
        return
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        yield from pool.imap_unordered(_work, jobs)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, metavar="N")
    parser.add_argument("seed", type=int, metavar="SEED")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("results/blind.csv"))
    parser.add_argument("--category", choices=list(cases.CATEGORIES))
    parser.add_argument("--effect", help="hide this one only")
    parser.add_argument("--table", action="store_true", help="print the table of the rows that are there, run nothing")
    given = parser.parse_args()
    category = given.category or ("one" if given.effect else None)
    there = {(int(row["seed"]), int(row["index"])) for row in read(given.out)}
    jobs = [(given.seed, i, category, given.effect) for i in range(given.count) if (given.seed, i) not in there]
    if not given.table and jobs:
        given.out.parent.mkdir(parents=True, exist_ok=True)
        fresh = not given.out.exists()
        if not fresh and given.out.open().readline().strip().split(",") != list(FIELDS):
            sys.exit(f"{given.out} was written by another version of the study: give another --out")
        with given.out.open("a", newline="") as file:
            writer = csv.DictWriter(file, FIELDS)
            if fresh:
                writer.writeheader()
            for number, row in enumerate(rows_made(jobs, given.jobs), start=1):
                writer.writerow(row)
                file.flush()
                print(f"{number}/{len(jobs)}", _line(row), file=sys.stderr, flush=True)
    rows = [row for row in read(given.out) if int(row["seed"]) == given.seed]
    print(f"seed {given.seed}: {len(rows)} logs in {given.out}\n\n{table(rows)}\n\n{confusion(rows)}")


def _line(row: dict[str, Any]) -> str:
    if row["category"] == "not made":
        return f"#{row['index']} {row['trouble']}"
    hidden = row["truth"] or row["fault"] or "nothing"
    said = row["status"] + (" (sure)" if row["sure"] == 1 else "")
    took = sum(row[f"seconds_{x}"] for x in ("made", "identify", "diagnose", "refine"))
    log = f"#{row['index']} {row['robot']} {row['motion']} {row['rate']:.0f} Hz, DNR {row['dnr']:.2f}: {hidden}"
    answer = f"{said} {row['named']} [{row['alternatives']}], added {row['added'] or 'nothing'}"
    return f"{log} -> {answer}; {took:.0f} s {row['trouble']}"


if __name__ == "__main__":
    main()
