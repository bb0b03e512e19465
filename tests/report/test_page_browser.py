"""The page in a headless Chromium: clicked through, tabbed through, narrow, dark, and printed."""

import json

import numpy as np
import pytest
import yaml
from arms import SCARA, TORQUE_NOISE, multisine, planar_torque, white, write_log
from browser import Browser, find_chromium, open_browser
from command import chebid

PLOT = ".chart .plot"
RANGE = f"(({{from, to}}) => [Number(from), Number(to)])(document.querySelector('{PLOT}').dataset)"
READOUT = "document.querySelector('.chart .readout').textContent"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a fitted model, a log with a torque ripple that it does not know, and `page.html`."""
    folder = tmp_path_factory.mktemp("browser")
    rng = np.random.default_rng(4)
    motion = multisine(4, 10.0)
    tau = planar_torque(motion) + white(rng, motion.q.shape, TORQUE_NOISE)
    tau[:, 1] += 0.2 * np.cos(5 * motion.q[:, 1])
    write_log(folder / "log.csv", motion.t, motion.q + white(rng, motion.q.shape, 5e-5), tau)
    (folder / "model.yaml").write_text(yaml.safe_dump(SCARA))
    for arguments in (
        ["identify", folder / "log.csv", "-m", folder / "model.yaml", "-o", folder / "fitted.yaml"],
        ["refine", folder / "model.yaml", folder / "log.csv", "-o", folder / "refined.yaml"],
        ["report", folder / "fitted.yaml", folder / "refined.yaml", folder / "log.csv", "-o", folder / "page.html"],
    ):
        answer = chebid(*arguments)
        assert answer.status == 0, answer.err
    return folder


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on this machine: install it (Debian: chromium) or set CHROMIUM to its path")
    with open_browser(program, tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def page(browser, made) -> Browser:
    browser.open(made / "page.html")
    return browser


@pytest.fixture(scope="module")
def log(made) -> np.ndarray:
    """t, q1, q2, tau1, tau2."""
    return np.loadtxt(made / "log.csv", delimiter=",", skiprows=1)


def numbers(text: str) -> dict[str, float]:
    """What a read-out says: t, measured, predicted, residual."""
    words = text.replace("\u2212", "-").replace("t = ", "t ").replace(" s:", ",").split(", ")
    return {name: float(value) for name, value, *_ in (part.split() for part in words)}


def assert_is_of_the_log(text: str, log: np.ndarray) -> None:
    """A read-out shows five digits of single precision."""
    told = numbers(text)
    row = log[np.abs(log[:, 0] - told["t"]).argmin()]
    assert told["t"] == pytest.approx(row[0], abs=1e-6)
    assert told["measured"] == pytest.approx(row[3], rel=6e-5)
    # residual of unrounded values: 4 digits of it, and half a unit of the fifth digit of each of the others
    loose = 6e-5 * (abs(told["measured"]) + abs(told["predicted"])) + 6e-4 * abs(told["residual"])
    assert told["residual"] == pytest.approx(told["measured"] - told["predicted"], abs=loose)


def test_no_error_and_no_request(page):
    """Also after every button was clicked."""
    page.run("document.querySelectorAll('button').forEach(button => button.click())")
    page.settle()
    assert page.of("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded") == []
    asked = [event["request"]["url"] for event in page.of("Network.requestWillBeSent")]
    assert len(asked) >= 1 and asked[0].startswith("file://") and asked[0].endswith("page.html")
    assert set(asked[1:]) <= {"data:,"}


def test_every_curve_is_drawn(page):
    drawn = page.run("[...document.querySelectorAll('.plot')].map(p => p.querySelectorAll('path.line[d]').length)")
    assert drawn == [3] * 4, "two models, two joints: measured, predicted, residual"
    assert page.run("[...document.querySelectorAll('path.line')].every(p => p.getAttribute('d').length > 1000)")


def test_dragging_zooms_every_curve_of_the_log(page):
    whole = page.run(RANGE)
    box = page.box(PLOT)
    y = box["y"] + box["height"] / 3
    page.mouse("mouseMoved", box["x"] + 0.3 * box["width"], y)
    page.mouse("mousePressed", box["x"] + 0.3 * box["width"], y, button="left", clickCount=1)
    page.mouse("mouseMoved", box["x"] + 0.5 * box["width"], y, button="left")
    assert page.run("document.querySelectorAll('rect.drag').length") == 2
    page.mouse("mouseReleased", box["x"] + 0.5 * box["width"], y, button="left", clickCount=1)
    low, high = page.run(RANGE)
    assert whole[0] < low < high < whole[1]
    assert high - low == pytest.approx(0.2 * (whole[1] - whole[0]), rel=0.2)
    ranges = page.run("[...document.querySelectorAll('.plot')].map(p => p.dataset.from + ' ' + p.dataset.to)")
    assert len(set(ranges)) == 1
    page.run("document.querySelector('[data-do=whole]').click()")
    assert page.run(RANGE) == whole


def test_hovering_reads_the_log(page, log):
    before = page.run(READOUT)
    box = page.box(PLOT)
    for share in (0.25, 0.5, 0.9):
        page.mouse("mouseMoved", box["x"] + share * box["width"], box["y"] + 50)
        assert_is_of_the_log(page.run(READOUT), log)
    assert page.run("document.querySelectorAll('.chart circle.dot').length") >= 3
    page.mouse("mouseMoved", 1, 1)
    assert page.run(READOUT) == before


def test_arrows_step_from_sample_to_sample(page, log):
    page.run(f"document.querySelector('{PLOT}').focus()")
    first = numbers(page.run(READOUT))["t"]
    for _ in range(3):
        page.press("ArrowRight")
        assert_is_of_the_log(page.run(READOUT), log)
    assert numbers(page.run(READOUT))["t"] == pytest.approx(first + 3 * 0.01, abs=1e-6)
    page.press("ArrowLeft")
    assert numbers(page.run(READOUT))["t"] == pytest.approx(first + 2 * 0.01, abs=1e-6)
    said = page.run(f"document.querySelector('{PLOT}').getAttribute('aria-valuetext')")
    assert said == page.run(READOUT)
    page.press("Home")
    assert numbers(page.run(READOUT))["t"] == log[0, 0]
    page.press("End")
    assert numbers(page.run(READOUT))["t"] == log[-1, 0]


def test_keys_zoom_and_move_on(page):
    page.run(f"document.querySelector('{PLOT}').focus()")
    whole = page.run(RANGE)
    page.press("+")
    page.press("+")
    low, high = page.run(RANGE)
    assert high - low == pytest.approx((whole[1] - whole[0]) / 1.6**2, rel=1e-6)
    page.press("ArrowRight", shift=True)
    assert page.run(RANGE)[0] > low
    page.press("-")
    wider = page.run(RANGE)
    assert wider[1] - wider[0] > high - low
    page.press("0")
    assert page.run(RANGE) == whole


def test_tab_reaches_charts_and_sections_open_by_key(page):
    reached = []
    page.run("document.activeElement.blur()")
    for _ in range(60):
        page.press("Tab")
        reached.append(page.run("document.activeElement.className || document.activeElement.tagName"))
        if "inner" in reached:
            break
    assert {"skip", "plot", "inner", "SUMMARY"} <= set(reached)
    last = "[...document.querySelectorAll('details')].at(-1)"
    assert page.run(f"{last}.open") is False
    page.run(f"{last}.querySelector('summary').focus()")
    page.press("Enter")
    assert page.run(f"{last}.open") is True
    page.press("Enter")
    assert page.run(f"{last}.open") is False


def test_whatever_takes_the_focus_has_a_name(page):
    """As a screen reader is told: by role and name."""
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    told = [
        (node["role"]["value"], node.get("name", {}).get("value", ""))
        for node in nodes
        if not node["ignored"] and any(p["name"] == "focusable" and p["value"]["value"] for p in node["properties"])
    ]
    unnamed = [(role, name) for role, name in told if not name.strip() and role not in ("RootWebArea", "main")]
    roles = {role for role, _ in told}
    assert unnamed == [] and {"slider", "link", "button", "region"} <= roles, roles


def test_a_map_reads_its_cells(page):
    page.run("document.querySelector('.map .inner').focus()")
    output = "document.querySelector('.map .readout').textContent"
    before = page.run(output)
    page.press("ArrowRight")
    first = page.run(output)
    page.press("ArrowRight")
    assert before != first != page.run(output) and first.startswith("q = ")
    data = json.loads(page.run("document.querySelector('.map .data').textContent"))
    middle = data["mean"][len(data["mean"]) // 2][len(data["q"]) // 2]
    told = first.replace("\u2212", "-").split(": ")[1].split(" ")[0]
    assert told == "not" if middle is None else float(told) == pytest.approx(middle, rel=1e-2)


def test_a_window_of_time_can_be_shown(page):
    whole = page.run(RANGE)
    button = "document.querySelector('[data-show]')"
    if not page.run(f"{button} !== null"):
        pytest.skip("the error of this log stands out in no window of time")
    low, high = page.run(f"[{button}.dataset.from, {button}.dataset.to].map(Number)")
    page.run(f"{button}.click()")
    page.settle()
    shown = page.run(RANGE)
    assert shown != whole and shown[0] <= low < high <= shown[1]


@pytest.mark.parametrize("width", [320, 375, 768])
def test_nothing_is_wider_than_a_phone(browser, made, width):
    browser.open(made / "page.html", width, 700)
    browser.run("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    browser.settle()
    assert browser.run("document.documentElement.scrollWidth") == width
    wide = browser.run(
        "[...document.querySelectorAll('main *')].filter(e => !e.closest('.scroll, .plot, .hidden') && "
        f"e.getBoundingClientRect().right > {width} + 0.5).map(e => e.tagName + '.' + e.getAttribute('class'))"
    )
    assert wide == []
    tables = browser.run(
        "[...document.querySelectorAll('.scroll')].every(box => getComputedStyle(box).overflowX === 'auto')"
    )
    assert tables is True


CONTRAST = """(() => {
  const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
  const linear = (v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = (colour) => colour.slice(0, 3).map(v => linear(v / 255))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const back = (e) => {
    for (; e; e = e.parentElement) {
      const colour = rgb(getComputedStyle(e).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const texts = [...document.querySelectorAll('main *, header *')].filter(e => e.getClientRects().length &&
    [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()) && !e.closest('script'));
  return texts.map(e => {
    const style = getComputedStyle(e), front = rgb(e instanceof SVGElement ? style.fill : style.color);
    const [a, b] = [light(front), light(back(e))].sort((x, y) => y - x);
    return [(a + 0.05) / (b + 0.05), e.tagName + '.' + e.getAttribute('class')];
  });
})()"""


@pytest.mark.parametrize("dark", [False, True])
def test_text_stands_out_by_day_and_by_night(browser, made, dark):
    """WCAG 2 AA: at least 4.5 to 1."""
    browser.open(made / "page.html", dark=dark)
    measured = browser.run(CONTRAST)
    assert len(measured) > 100
    assert [(round(ratio, 2), what) for ratio, what in measured if ratio < 4.5] == []
    back = browser.run("getComputedStyle(document.body).backgroundColor")
    assert (back == "rgb(255, 255, 255)") is not dark


def test_all_of_it_is_printed(browser, made, tmp_path):
    """In print every section is open, also those that were closed, and buttons are gone."""
    browser.open(made / "page.html", dark=True)
    browser.run("document.querySelectorAll('details').forEach(part => { part.open = false; })")
    browser.call("Emulation.setEmulatedMedia", media="print", features=[])
    browser.settle()
    hidden = "[...document.querySelectorAll('details > :not(summary)')].filter(e => !e.checkVisibility()).length"
    assert browser.run("document.querySelectorAll('details[open]').length") == 0
    assert browser.run(hidden.replace("details > :not(summary)", "details .scroll")) == 0
    assert browser.run("getComputedStyle(document.querySelector('.tools')).display") == "none"
    assert browser.run("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    browser.print(tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
    assert browser.run("document.querySelectorAll('details[open]').length") == 0, "as it was before"
