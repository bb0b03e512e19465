"""The HTML page without a browser: what it holds, that nothing but its own script can run, its size, its bytes."""

import base64
import hashlib
import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import yaml
from arms import SCARA, TORQUE_NOISE, multisine, planar_torque, white
from command import chebid
from hypothesis import given
from hypothesis import strategies as st

from chebid.report.page.curves import BUDGET, curve, most_samples, stretches, thin
from chebid.report.page.render import render_content
from chebid.report.page.words import pretty

VOID = {"meta", "link", "br", "hr", "img", "input", "rect", "line", "circle", "path"}
EVIL = "<script>alert('x')&"
WRITTEN = "&lt;script&gt;alert(&#39;x&#39;)&amp;"


class Outline(HTMLParser):
    """Tags that are closed in order, ids, headings, and what might reach out of the page or run."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.headings: list[int] = []
        self.tags: Counter[str] = Counter()
        self.attributes: list[tuple[str, str, str]] = []
        self.feed(text)
        self.close()
        assert self.open == [], f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        self.ids += [value for name, value in attrs if name == "id"]
        if re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes nothing"


def write_columns(path: Path, columns: dict[str, np.ndarray]) -> None:
    names = ",".join(f'"{name}"' for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=names, comments="")


def record(path: Path, names: list[str], seed: int, hidden: float = 0.0) -> None:
    """A log of the SCARA; `hidden` N.m of a friction ripple on its second joint that no model knows."""
    rng = np.random.default_rng(seed)
    motion = multisine(seed, 10.0)
    tau = planar_torque(motion) + white(rng, motion.q.shape, TORQUE_NOISE)
    tau[:, 1] += hidden * np.sign(motion.dq[:, 1]) * np.cos(6 * motion.q[:, 1])
    columns = np.column_stack([motion.t, motion.q + white(rng, motion.q.shape, 5e-5), tau])
    write_columns(path, dict(zip(names, columns.T, strict=True)))


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A folder with two fitted models, one of them refined, two logs, and `page.html`; names that would be scripts."""
    folder = tmp_path_factory.mktemp("page")
    names = ["t", "a", "b", "tau_a", "tau_b"]
    columns = {"time": "t", "position": ["a", "b"], "torque": ["tau_a", "tau_b"]}
    model = SCARA | {"joints": [EVIL, "b"], "log": columns}
    (folder / "m.yaml").write_text(yaml.safe_dump(model))
    evil = folder / f"{EVIL.replace('/', '')}.csv"
    record(evil, names, 1, 0.15)
    record(folder / "other.csv", names, 2, 0.15)
    for command, out in (("identify", "fitted.yaml"), ("refine", "refined.yaml")):
        source = ["-m", folder / "m.yaml"] if command == "identify" else [folder / "m.yaml"]
        order = [evil, *source] if command == "identify" else [*source, evil]
        answer = chebid(command, *order, "-o", folder / out)
        assert answer.status == 0, answer.err
    answer = chebid(
        "report",
        folder / "fitted.yaml",
        folder / "refined.yaml",
        evil,
        folder / "other.csv",
        "-o",
        folder / "page.html",
    )
    assert answer.status == 0, answer.err
    return folder


@pytest.fixture(scope="module")
def text(made) -> str:
    return (made / "page.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def outline(text) -> Outline:
    return Outline(text)


def test_it_is_a_well_formed_page(text, outline):
    assert text.lstrip().startswith("<!DOCTYPE html>")
    assert ("html", "lang", "en") in outline.attributes
    assert outline.tags["title"] == outline.tags["main"] == outline.tags["h1"] == 1
    assert [name for name, count in Counter(outline.ids).items() if count > 1] == []
    assert outline.headings[0] == 1
    assert all(b <= a + 1 for a, b in zip(outline.headings, outline.headings[1:], strict=False)), "headings in order"


def test_what_is_referred_to_by_id_is_there(outline):
    wanted = [v.lstrip("#") for _, name, v in outline.attributes if name in ("aria-labelledby", "aria-describedby")]
    wanted += [v[1:] for _, name, v in outline.attributes if name == "href" and v.startswith("#")]
    assert len(wanted) > 10 and set(wanted) <= set(outline.ids)


def test_every_picture_says_what_it_shows(text, outline):
    pictures = re.findall(r"<svg[^>]*>", text)
    assert len(pictures) > 10
    assert all('aria-hidden="true"' in svg or "aria-label=" in svg for svg in pictures)
    assert all("aria-label=" in plot for plot in re.findall(r'<div class="(?:plot|inner)"[^>]*>', text))


def test_it_holds_every_part(text):
    for head in ("How well they predict", "The logs and their quality", "The model", "Measured against predicted"):
        assert head in text
    for head in ("Where it fails", "What the error depends on", "Candidates", "The ladder of errors", "Parameters"):
        assert f"<h3>{head}</h3>" in text
    assert text.count("<h3>The ladder of errors</h3>") == 1, "only one of the models was refined"
    assert "friction_ripple:b" in text


def test_names_from_files_are_text(text, outline):
    assert WRITTEN in text and EVIL not in text
    assert outline.tags["script"] == 1 + 8 + 4, "the page's own, one for each curve, one for each map"
    assert not any(name.startswith("on") or name == "style" for _, name, _ in outline.attributes)


def test_data_in_scripts_cannot_close_them():
    packed = render_content(BARE | {"models": ["</title><script>"], "comparison": BARE["comparison"]})
    assert "</title><script>" not in packed and packed.count("<script>") == 1


BARE = {
    "models": ["m"],
    "logs": [],
    "comparison": {"rows": [], "overall": [], "floors": [], "most": 1.0},
    "sheets": [],
}


def test_only_its_own_script_and_style_are_allowed(text):
    rule = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert rule.startswith("default-src 'none';") and "unsafe" not in rule
    for tag, kind in (("script", "script-src"), ("style", "style-src")):
        content = re.search(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)[1]
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"{kind} 'sha256-{digest}'" in rule


def test_nothing_reaches_out_of_the_page(text, outline):
    links = [v for _, name, v in outline.attributes if name in ("src", "href", "action", "srcset", "data")]
    assert all(v.startswith("#") or v == "data:," for v in links)
    addresses = set(re.findall(r"https?://[^\s\"'<]+", text))
    assert addresses == {"http://www.w3.org/2000/svg"}, "the name of the namespace, which is never fetched"
    assert not re.search(r"@import|url\((?!#)", text.split("</style>")[0])


def test_the_same_input_gives_the_same_bytes(made, tmp_path, text):
    logs = sorted(made.glob("*.csv"))
    again = chebid("report", made / "fitted.yaml", made / "refined.yaml", *logs, "-o", tmp_path / "again.html")
    assert again.status == 0, again.err
    assert (tmp_path / "again.html").read_text(encoding="utf-8") == text
    assert str(made) not in text, "a page says the same wherever its files lie"


def unpack(data: dict, name: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(data[name]), kind)


def test_the_curves_are_the_samples_of_the_log(made, text):
    packed = re.findall(r'class="data">(\{"t".*?)</script>', text)
    log = np.loadtxt(made / f"{EVIL}.csv", delimiter=",", skiprows=1)
    for joint in (0, 1):
        data = json.loads(packed[joint])
        np.testing.assert_array_equal(unpack(data, "t", "<f8"), log[:, 0])
        np.testing.assert_array_equal(unpack(data, "measured", "<f4"), log[:, 3 + joint].astype("f4"))


def test_refuses_a_model_without_a_fit(made, tmp_path):
    answer = chebid("report", made / "m.yaml", made / "other.csv", "-o", tmp_path / "p.html")
    assert answer.status == 3 and "holds no identified parameters" in answer.error
    assert "chebid identify" in answer.hint and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "status", "word"),
    [
        (["fitted.yaml", "-o", "p.html"], 2, "no log"),
        (["other.csv", "-o", "p.html"], 2, "no model"),
        (["fitted.yaml", "other.csv"], 2, "no page"),
        (["fitted.yaml", "other.csv", "-o", "p.pdf"], 2, "cannot write a page"),
        (["fitted.yaml", "other.csv", "-o", "page.html"], 2, "exists already"),
        (["fitted.yaml", "fitted.yaml", "other.csv", "-o", "p.html"], 2, "given twice"),
        (["fitted.yaml", "other.csv", "other.csv", "-o", "p.html"], 2, "is the same log"),
    ],
)
def test_wrong_usage_is_told_at_once(made, monkeypatch, arguments, status, word):
    monkeypatch.chdir(made)
    answer = chebid("report", *arguments)
    assert answer.status == status and word in answer.error and answer.hint
    assert not (made / "p.html").exists()


def test_a_log_that_the_model_never_saw_is_judged_for_change(made, tmp_path):
    answer = chebid("report", made / "refined.yaml", made / "other.csv", "-o", tmp_path / "p.html", "--json")
    assert answer.status == 0, answer.err
    assert "on which it was not fitted" in (tmp_path / "p.html").read_text()
    document = json.loads(answer.out)
    assert set(document) == {"page", "comparison", "models"}
    assert set(document["models"][0]["diagnosis"]) >= {"joints", "where", "candidates", "verdict"}


# --- curves of any length -----------------------------------------------------------------------------------------


@given(st.integers(1, 5000), st.integers(20, 800), st.integers(0, 2**32 - 1))
def test_what_is_kept_is_bounded_and_holds_every_peak(count, most, seed):
    rng = np.random.default_rng(seed)
    columns = [rng.standard_normal(count), rng.standard_normal(count)]
    kept = thin(columns, most)
    assert len(kept) <= most
    assert np.all(np.diff(kept) > 0) and {0, count - 1} <= set(kept.tolist())
    for values in columns:
        assert {values.argmin(), values.argmax()} <= set(kept.tolist())


class Fake:
    """A track of one joint, as `curve` sees it."""

    def __init__(self, t: np.ndarray, tau: np.ndarray) -> None:
        self.motion, self.torque = type("M", (), {"t": t}), tau[:, None]


def test_a_page_stays_below_three_megabytes(text):
    """Curves have a budget, whatever the logs; the rest does not grow with them."""
    rest = re.sub(r'class="data">\{"t".*?</script>', "", text)
    assert len(rest.encode()) < 0.2e6, "two models, two joints, two logs"
    assert BUDGET + 4 * len(rest.encode()) < 3e6


def test_a_million_samples_take_no_more_than_the_budget():
    t = np.arange(1_000_000) / 1000
    rng = np.random.default_rng(0)
    track = Fake(t, rng.standard_normal(len(t)))
    data = curve([track], [np.zeros((len(t), 1))], [np.ones((len(t), 1), dtype=bool)], 0, most_samples(6))
    assert data["thinned"] and 6 * len(json.dumps(data)) < 1.01 * BUDGET


def test_records_whose_clocks_overlap_are_laid_side_by_side():
    t = np.arange(100) / 10
    tracks = [Fake(t, np.full(100, 1.0)), Fake(t, np.full(100, 2.0))]
    data = curve(tracks, [np.zeros((100, 1))] * 2, [np.ones((100, 1), dtype=bool)] * 2, 0, 1000)
    drawn, measured = unpack(data, "t", "<f8"), unpack(data, "measured", "<f4")
    assert np.all(np.diff(drawn) >= 0) and np.isnan(measured[100]), "a gap between the two"
    (first, _), (second, offset) = data["records"]
    assert (first, second) == (0, 101)
    np.testing.assert_allclose(drawn[101:] - offset, t, atol=1e-12)


def test_stretches_join_what_is_near_and_leave_out_what_is_short():
    t = np.arange(10_001) / 10_000
    marked = np.zeros(len(t), dtype=bool)
    marked[1000:2000] = marked[2005:3000] = marked[5000:5003] = True
    assert stretches(t, marked) == [[pytest.approx(0.1), pytest.approx(0.3)]]


@pytest.mark.parametrize(
    ("unit", "shown"),
    [("N.m.s/rad", "N·m·s/rad"), ("kg.m^2", "kg·m²"), ("N.s^0.1/m^0.1", "N·s^0.1/m^0.1"), ("N/m^3", "N/m³"), ("1", "")],
)
def test_units_are_pretty_and_numbers_in_them_are_left(unit, shown):
    assert pretty(unit) == shown
