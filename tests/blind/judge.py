"""Right or wrong: what chebid said about one log against what was hidden in it."""

import re
from typing import Any

from blind.cases import Case
from blind.effects import ALL, Effect

FIELDS = (
    "seed", "index", "category", "robot", "joints", "motion", "holdout_motion", "duration", "rate", "colour", "dither",
    "torque", "noise_factor", "fault", "truth", "law", "asked", "dnr", "slow", "plain", "singles", "status", "sure",
    "named", "alternatives", "top", "depends", "first_right", "among", "sure_right", "variable_right", "variable_first",
    "found", "exact", "added", "ratio_before", "ratio_after", "holdout_after", "floor_kind", "message", "seconds_made",
    "seconds_identify", "seconds_diagnose", "seconds_refine", "trouble", "commit", "values",
)  # fmt: skip


def pairs(found: list[dict[str, Any]]) -> list[tuple[str, str]]:
    return [(str(x.get("effect")), str(x.get("joint") or "")) for x in found or []]


def fits(effect: Effect, said: tuple[str, str]) -> bool:
    """Whether a named effect is the hidden one; where the joint is the whole arm's or cannot be told, any will do."""
    name, joint = said
    return name == effect.name and (effect.joint is None or effect.any_joint or joint == f"q{effect.joint + 1}")


def judge(case: Case, diagnosis: dict[str, Any] | None, refined: dict[str, Any] | None) -> dict[str, Any]:
    """The columns of the results that are about chebid's answers; empty where there was no answer."""
    verdict = (diagnosis or {}).get("verdict") or {}
    named, rivals = pairs(verdict.get("effects")), pairs(verdict.get("alternatives"))
    depends = (diagnosis or {}).get("depends_on") or []
    joints = (diagnosis or {}).get("joints") or []
    truth = case.effects
    out: dict[str, Any] = {
        "status": verdict.get("status", "no answer"), "sure": int(bool(verdict.get("sure"))), "named": words(named),
        "alternatives": words(rivals), "top": words(pairs((diagnosis or {}).get("candidates"))[:3]),
        "depends": ";".join(f"{x['joint']}/{x['variable']}" for x in depends[:3]),
        "ratio_before": worst(x.get("ratio") for x in joints),
        "floor_kind": ";".join(str(x.get("floor_kind", "")) for x in joints), "message": verdict.get("message", ""),
        "first_right": int(bool(named) and any(fits(e, named[0]) for e in truth)),
        "among": int(any(fits(e, x) for e in truth for x in named[:1] + rivals[:3])),
    }  # fmt: skip
    calls_effect = verdict.get("status") == "missing" and bool(named)
    out["sure_right"] = int(any(fits(e, named[0]) for e in truth)) if calls_effect and verdict.get("sure") else ""
    if case.category == "unknown":
        out["variable_first"] = int(_variable_right(truth[0], depends))
        out["variable_right"] = int(out["variable_first"] or verdict.get("status") == "unknown")
    return out | _after(case, refined)


def _after(case: Case, refined: dict[str, Any] | None) -> dict[str, Any]:
    steps = (refined or {}).get("steps") or [{}]
    last, added = steps[-1], pairs((refined or {}).get("added"))
    held = last.get("holdout_ratio") or {}
    found = [any(fits(e, x) for x in added) for e in case.effects]
    return {
        "added": words(added),
        "found": int(bool(found) and all(found)),
        "exact": int(all(found) and len(added) == len(found)),
        "ratio_after": worst((last.get("ratio") or {}).values()),
        "holdout_after": worst(held.values()) if all(e.on_another_day() for e in case.effects) else "",
    }


def words(found: list[tuple[str, str]]) -> str:
    return ";".join(f"{name}:{joint}" for name, joint in found)


def worst(values: Any) -> Any:
    numbers = [x for x in values if x is not None]
    return max(numbers) if numbers else ""


def _variable_right(effect: Effect, depends: list[dict[str, Any]]) -> bool:
    """Whether the strongest dependence is on the variable that matters."""
    for found in depends[:1]:
        joint = str(found.get("joint"))
        if _symbols(str(found.get("variable")), joint) & set(ALL[effect.name].variables[:1]):
            return True
    return False


def _symbols(variable: str, joint: str) -> set[str]:
    """The bare variables in a phrase such as `abs(tau)*sign(dq)`, `q[q1]*dq`, `distance since reversal`."""
    variable = re.sub(r"([a-z]+)\[q(\d+)\]", r"\1\2", variable)
    out = set()
    for word in re.findall(r"[A-Za-z_]+\d*", variable):
        bare = re.sub(r"\d+$", "", word)
        other = word != bare and not word.endswith(joint[1:])
        if bare in ("q", "dq", "ddq"):
            out.add(("other_" if other else "") + bare)
        elif bare in ("tau", "load", "torque"):
            out.add("tau")
        elif bare in ("t", "time"):
            out.add("t")
        elif bare == "reversal":
            out.add("reversal")
    if "other" in variable or " of " in variable:
        out |= {f"other_{x}" for x in out}
    return out
