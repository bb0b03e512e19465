"""What every test shares: one thread per process, reproducible hypothesis, the measured logs."""

import importlib.util
import os
import sys
from collections.abc import Callable

# Before numpy is imported anywhere: times and last digits must not depend on the number of cores.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from pathlib import Path  # noqa: E402
from types import ModuleType  # noqa: E402

import pytest  # noqa: E402
from hypothesis import HealthCheck, settings  # noqa: E402

PROJECT = Path(__file__).resolve().parents[1]

# No deadline: the first call of a compiled kernel takes seconds and says nothing about the others.
settings.register_profile(
    "ci", derandomize=True, database=None, deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("dev", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "dev"))


@pytest.fixture(scope="session")
def project() -> Path:
    """The top folder of the checkout."""
    return PROJECT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of the measured logs: ``$CHEBID_SHARED/data``, else ``../shared/data`` beside the checkout."""
    shared = Path(os.environ.get("CHEBID_SHARED") or PROJECT.parent / "shared")
    folder = shared / "data"
    if not folder.is_dir():
        pytest.skip(f"the measured logs are not here: no folder {folder}; set CHEBID_SHARED to the folder above data/")
    return folder


@pytest.fixture(scope="session")
def script() -> Callable[[str], ModuleType]:
    """A script of the workflow as a module: they import each other by name."""
    folder = PROJECT / "workflow" / "scripts"

    def load(name: str) -> ModuleType:
        sys.path.insert(0, str(folder))
        try:
            spec = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
            assert spec and spec.loader
            module = importlib.util.module_from_spec(spec)
            sys.modules[name] = module
            spec.loader.exec_module(module)
        finally:
            sys.path.remove(str(folder))
        return module

    return load
