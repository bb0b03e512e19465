# What all rules share: the checked settings, where things go, and how scripts are called.
import fcntl
import hashlib
import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(workflow.basedir, "scripts")))
from settings import complaints

# --config KEY=true gives a word
config.update({key: value == "true" for key, value in config.items() if value in ("true", "false")})
if wrong := complaints(config, Path(workflow.basedir, "config.schema.yaml")):
    raise WorkflowError("the configuration is not usable; config/README.md explains every key", *wrong)

# small problems are slower on two threads than on one; and sums in another order have other last digits
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
os.environ.update(dict.fromkeys(THREADS, "1"))

OUT = config["output"]
PYTHON = sys.executable  # scripts run in the environment of snakemake itself
SCRIPTS = os.path.relpath(Path(workflow.basedir, "scripts"))

ARTEFACTS = []  # files that the main job makes
CHECKED = []  # names of figures/NAME.csv and its pictures: compared with the committed ones, and kept beside them


def section(*names):
    """These sections of the configuration as JSON: part of a job's identity, so that a change runs it again."""
    return json.dumps({name: config[name] for name in names}, sort_keys=True)


def sources(*patterns):
    """Files of the package that a result depends on."""
    package = Path(workflow.basedir).parent / "chebid"
    return sorted(os.path.relpath(path) for pattern in patterns for path in package.glob(pattern))


def published(names):
    """The committed files of these figures, if this configuration is the one that makes them."""
    if not config["publish"]:
        return []
    return [f"{config['reference']}/{name}.{suffix}" for name in names for suffix in ("csv", "svg", "png")]


def fingerprint(path):
    """Size and content of a file that may not exist, so that a change of it runs a job again."""
    file = Path(path)
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16] if file.exists() else "none"


def alone(folder):
    """Keep other runs out of a folder. Unlike snakemake's own lock, this one goes when the process is killed."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    LOCKS.append(open(Path(folder, ".lock"), "w"))
    try:
        fcntl.flock(LOCKS[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise WorkflowError(f"another run is working in {folder}: wait for it, or take another output folder") from None
    except OSError:
        pass  # a file system without locks


LOCKS = []


onstart:
    alone(OUT)
