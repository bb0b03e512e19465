"use strict";
/* Curves with zoom and read-out, maps with read-out, sections that open. Text from files goes in as text only. */
(function () {
  const SVG = "http://www.w3.org/2000/svg";
  const MARGIN = { left: 58, right: 8, top: 8, bottom: 34, between: 14 };
  const SHARE = 0.64; // of the height, for the torques; the rest is for the residual
  const STEP = 1.6; // of one zoom
  const all = (root, what) => Array.from(root.querySelectorAll(what));

  function make(parent, name, attributes, text) {
    const node = document.createElementNS(SVG, name);
    for (const key of Object.keys(attributes || {})) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    if (parent) parent.appendChild(node);
    return node;
  }

  function unpack(text, Kind) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return new Kind(bytes.buffer);
  }

  const tidy = (text) => text.replace(/-/g, "\u2212");
  function say(value, digits) {
    return Number.isFinite(value) ? tidy(String(Number(value.toPrecision(digits || 5)))) : "\u2013";
  }

  function ticks(low, high, count) {
    const rough = 0.9 * (high - low) / Math.max(count, 1), power = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = power * ([1, 2, 5].find((m) => m * power >= rough) || 10), out = [];
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push([k * step, tidy((k * step).toFixed(Math.min(digits, 12)))]);
    return out.length < 2 && count < 16 ? ticks(low, high, 2 * count) : out;
  }

  /* index of the first instant at or after x; gaps have the instant of the sample before them */
  function find(t, x) {
    let low = 0, high = t.length;
    while (low < high) { const middle = (low + high) >> 1; if (t[middle] < x) low = middle + 1; else high = middle; }
    return low;
  }

  const groups = new Map(); // curves of one log share their range and their instant

  class Curve {
    constructor(figure) {
      const data = JSON.parse(figure.querySelector(".data").textContent);
      this.figure = figure;
      this.plot = figure.querySelector(".plot");
      this.output = figure.querySelector(".readout");
      this.rest = this.output.textContent;
      this.unit = figure.dataset.unit;
      this.what = figure.dataset.what;
      this.t = unpack(data.t, Float64Array);
      this.measured = unpack(data.measured, Float32Array);
      this.predicted = unpack(data.predicted, Float32Array);
      this.residual = this.measured.map((value, i) => value - this.predicted[i]);
      this.records = data.records;
      this.unused = data.unused;
      this.at = null;
      const name = figure.dataset.group;
      if (!groups.has(name)) groups.set(name, { curves: [], low: Infinity, high: -Infinity, from: 0, to: 1 });
      this.group = groups.get(name);
      this.group.curves.push(this);
      this.group.low = this.group.from = Math.min(this.group.low, this.t[0]);
      this.group.high = this.group.to = Math.max(this.group.high, this.t[this.t.length - 1]);
      this.listen();
      new ResizeObserver(() => this.draw()).observe(this.plot);
    }

    listen() {
      const plot = this.plot;
      plot.addEventListener("keydown", (event) => this.key(event));
      plot.addEventListener("pointerdown", (event) => { if (event.button === 0) this.begin(event); });
      plot.addEventListener("pointermove", (event) => this.move(event));
      plot.addEventListener("pointerup", (event) => this.end(event));
      plot.addEventListener("pointercancel", () => { this.dragged = null; this.cross(); });
      plot.addEventListener("pointerleave", () => { if (!this.dragged && document.activeElement !== plot) pick(this.group, null); });
      plot.addEventListener("dblclick", () => range(this.group, -Infinity, Infinity));
      plot.addEventListener("focus", () => { if (this.at === null) pick(this.group, (this.group.from + this.group.to) / 2); });
      for (const button of all(this.figure, "[data-do]")) button.addEventListener("click", () => this.act(button.dataset.do));
    }

    act(what) {
      const g = this.group, width = g.to - g.from, centre = this.at === null ? (g.from + g.to) / 2 : this.t[this.at];
      if (what === "in") range(g, centre - (centre - g.from) / STEP, centre + (g.to - centre) / STEP);
      if (what === "out") range(g, centre - (centre - g.from) * STEP, centre + (g.to - centre) * STEP);
      if (what === "whole") range(g, -Infinity, Infinity);
      if (what === "left") range(g, Math.max(g.low, g.from - width / 2), Math.max(g.low, g.from - width / 2) + width);
      if (what === "right") range(g, Math.min(g.high, g.to + width / 2) - width, Math.min(g.high, g.to + width / 2));
    }

    key(event) {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const moves = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1, PageDown: -50, PageUp: 50 };
      const acts = { "+": "in", "=": "in", "-": "out", "_": "out", "0": "whole", Escape: "whole" };
      if (event.shiftKey && event.key in moves) this.act(moves[event.key] < 0 ? "left" : "right");
      else if (event.key in moves) this.step(moves[event.key]);
      else if (event.key === "Home") pick(this.group, this.group.from);
      else if (event.key === "End") pick(this.group, this.group.to);
      else if (event.key in acts) this.act(acts[event.key]);
      else return;
      event.preventDefault();
    }

    step(by) {
      let i = this.at === null ? find(this.t, this.group.from) : this.at + by;
      i = Math.max(0, Math.min(this.t.length - 1, i));
      while (i > 0 && i < this.t.length - 1 && Number.isNaN(this.predicted[i])) i += Math.sign(by) || 1;
      const g = this.group, width = g.to - g.from, x = this.t[i];
      if (x < g.from || x > g.to) range(g, Math.max(g.low, Math.min(g.high - width, x - width / 2)), Math.max(g.low, Math.min(g.high - width, x - width / 2)) + width);
      for (const curve of g.curves) curve.show(curve === this ? i : curve.near(x));
    }

    begin(event) {
      this.dragged = { start: this.time(event), x: event.clientX };
      try { this.plot.setPointerCapture(event.pointerId); } catch (_) { /* a pointer that is gone already */ }
    }

    move(event) {
      pick(this.group, this.time(event));
      if (this.dragged) this.cross(this.dragged.start, this.time(event));
    }

    end(event) {
      const drag = this.dragged;
      this.dragged = null;
      if (!drag) return;
      const stop = this.time(event);
      if (Math.abs(event.clientX - drag.x) > 6) range(this.group, Math.min(drag.start, stop), Math.max(drag.start, stop));
      else this.cross();
    }

    time(event) {
      const box = this.plot.getBoundingClientRect(), inner = box.width - MARGIN.left - MARGIN.right;
      const share = Math.max(0, Math.min(1, (event.clientX - box.left - MARGIN.left) / inner));
      return this.group.from + share * (this.group.to - this.group.from);
    }

    near(x) {
      let i = find(this.t, x);
      if (i > 0 && (i === this.t.length || x - this.t[i - 1] < this.t[i] - x)) i -= 1;
      if (Number.isNaN(this.predicted[i])) i += i > 0 ? -1 : 1;
      return i;
    }

    show(i) {
      this.at = i;
      const text = i === null ? this.rest : this.words(i);
      this.output.textContent = text;
      if (i !== null) {
        this.plot.setAttribute("aria-valuenow", String(Number(this.t[i].toPrecision(7))));
        this.plot.setAttribute("aria-valuetext", text);
      }
      this.cross();
    }

    words(i) {
      let record = 0;
      while (record + 1 < this.records.length && this.records[record + 1][0] <= i) record += 1;
      const t = this.t[i] - this.records[record][1];
      const which = this.records.length > 1 ? "record " + (record + 1) + ", " : "";
      return which + "t = " + say(t, 7) + " s: measured " + say(this.measured[i]) + ", predicted " + say(this.predicted[i]) +
        ", residual " + say(this.residual[i], 4) + " " + this.unit;
    }

    draw() {
      const width = this.plot.clientWidth, height = this.plot.clientHeight;
      if (!width || !height) return;
      const g = this.group, inner = width - MARGIN.left - MARGIN.right;
      const room = height - MARGIN.top - MARGIN.bottom - MARGIN.between;
      const first = Math.max(0, find(this.t, g.from) - 1), last = Math.min(this.t.length, find(this.t, g.to) + 1);
      this.x = (t) => MARGIN.left + inner * (t - g.from) / (g.to - g.from);
      this.panels = [
        this.panel([this.measured, this.predicted], first, last, MARGIN.top, room * SHARE),
        this.panel([this.residual], first, last, MARGIN.top + room * SHARE + MARGIN.between, room * (1 - SHARE)),
      ];
      const svg = make(null, "svg", { viewBox: "0 0 " + width + " " + height, "aria-hidden": "true", focusable: "false" });
      const clip = "clip-" + this.figure.id;
      make(make(svg, "clipPath", { id: clip }), "rect", { x: MARGIN.left, y: 0, width: inner, height: height });
      const shade = make(svg, "g", { "clip-path": "url(#" + clip + ")" });
      this.frame(svg, shade, inner, height);
      this.lines(shade, inner, first, last);
      this.over = make(svg, "g", {});
      this.plot.replaceChildren(svg);
      this.plot.setAttribute("aria-valuemin", String(g.from));
      this.plot.setAttribute("aria-valuemax", String(g.to));
      if (!this.plot.hasAttribute("aria-valuenow")) this.plot.setAttribute("aria-valuenow", String(g.from));
      this.plot.dataset.from = String(g.from);
      this.plot.dataset.to = String(g.to);
      this.cross();
    }

    panel(columns, first, last, top, height) {
      let low = Infinity, high = -Infinity;
      for (const values of columns) for (let i = first; i < last; i++) { const v = values[i]; if (v < low) low = v; if (v > high) high = v; }
      if (!(low <= high)) { low = -1; high = 1; }
      const room = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1;
      low -= room; high += room;
      return { low, high, top, height, y: (v) => top + height * (high - v) / (high - low) };
    }

    frame(svg, shade, inner, height) {
      const g = this.group, right = MARGIN.left + inner, bottom = height - MARGIN.bottom;
      for (const [a, b] of this.unused) {
        if (b < g.from || a > g.to) continue;
        const from = Math.max(this.x(a), MARGIN.left), to = Math.min(this.x(b), right);
        for (const p of this.panels) make(shade, "rect", { class: "unused", x: from, y: p.top, width: Math.max(0, to - from), height: p.height });
      }
      for (const p of this.panels) {
        for (const [value, label] of ticks(p.low, p.high, Math.max(3, p.height / 40))) {
          make(shade, "line", { class: "grid", x1: MARGIN.left, x2: right, y1: p.y(value), y2: p.y(value) });
          make(svg, "text", { x: MARGIN.left - 6, y: p.y(value) + 4, "text-anchor": "end" }, label);
        }
        make(svg, "line", { class: "axis", x1: MARGIN.left, x2: MARGIN.left, y1: p.top, y2: p.top + p.height });
      }
      const base = this.panels[1];
      if (base.low < 0 && base.high > 0) make(shade, "line", { class: "axis", x1: MARGIN.left, x2: right, y1: base.y(0), y2: base.y(0) });
      for (const [value, label] of ticks(g.from, g.to, inner / 90)) {
        for (const p of this.panels) make(shade, "line", { class: "grid", y1: p.top, y2: p.top + p.height, x1: this.x(value), x2: this.x(value) });
        make(svg, "text", { x: this.x(value), y: bottom + 15, "text-anchor": "middle" }, label);
      }
      make(svg, "text", { x: MARGIN.left + inner / 2, y: height - 4, "text-anchor": "middle" }, "time (s)");
      [this.what, "residual"].forEach((name, i) => {
        const p = this.panels[i], y = p.top + p.height / 2;
        make(svg, "text", { x: 11, y: y, "text-anchor": "middle", transform: "rotate(-90 11 " + y + ")" }, name + " (" + this.unit + ")");
      });
    }

    lines(parent, inner, first, last) {
      for (const [name, panel] of [["measured", 0], ["predicted", 0], ["residual", 1]])
        make(parent, "path", { class: "line " + name, d: this.path(this[name], this.panels[panel], inner, first, last) });
    }

    /* of the samples within one pixel the first, the least, the largest and the last */
    path(values, panel, inner, first, last) {
      const parts = [];
      let pen = "M";
      const put = (i) => { parts.push(pen, this.x(this.t[i]).toFixed(1), " ", panel.y(values[i]).toFixed(1)); pen = "L"; };
      const dense = last - first > 4 * inner;
      for (let i = first; i < last;) {
        if (Number.isNaN(values[i])) { pen = "M"; i += 1; continue; }
        if (!dense) { put(i); i += 1; continue; }
        const column = Math.floor(this.x(this.t[i]));
        let stop = i, low = i, high = i;
        while (stop < last && !Number.isNaN(values[stop]) && Math.floor(this.x(this.t[stop])) === column) {
          if (values[stop] < values[low]) low = stop;
          if (values[stop] > values[high]) high = stop;
          stop += 1;
        }
        for (const k of Array.from(new Set([i, Math.min(low, high), Math.max(low, high), stop - 1]))) put(k);
        i = stop;
      }
      return parts.join("");
    }

    /* the read-out's line and dots, and what is being dragged across */
    cross(from, to) {
      if (!this.over) return;
      this.over.replaceChildren();
      if (from !== undefined) {
        const a = this.x(Math.min(from, to)), b = this.x(Math.max(from, to));
        for (const p of this.panels) make(this.over, "rect", { class: "drag", x: a, y: p.top, width: b - a, height: p.height });
      }
      const i = this.at;
      if (i === null || this.t[i] < this.group.from || this.t[i] > this.group.to) return;
      const x = this.x(this.t[i]), base = this.panels[1];
      make(this.over, "line", { class: "hair", x1: x, x2: x, y1: MARGIN.top, y2: base.top + base.height });
      for (const [name, panel] of [["measured", 0], ["predicted", 0], ["residual", 1]])
        if (Number.isFinite(this[name][i])) make(this.over, "circle", { class: "dot " + name, cx: x, cy: this.panels[panel].y(this[name][i]), r: 4 });
    }
  }

  function pick(group, x) {
    for (const curve of group.curves) curve.show(x === null ? null : curve.near(x));
  }

  function range(group, from, to) {
    const whole = group.high - group.low;
    from = Math.max(group.low, from);
    to = Math.min(group.high, to);
    if (to - from < 1e-4 * whole) return;
    group.from = from;
    group.to = to;
    for (const curve of group.curves) curve.draw();
  }

  function readMap(figure) {
    const data = JSON.parse(figure.querySelector(".data").textContent), box = figure.querySelector(".inner");
    const output = figure.querySelector(".readout"), rest = output.textContent, cursor = box.querySelector(".cursor");
    const rows = data.mean.length, columns = data.mean[0].length, unit = figure.dataset.unit;
    let at = null;
    function show(row, column) {
      at = [Math.max(0, Math.min(rows - 1, row)), Math.max(0, Math.min(columns - 1, column))];
      const mean = data.mean[at[0]][at[1]];
      output.textContent = "q = " + say(data.q[at[1]], 4) + " " + figure.dataset.position + ", dq = " + say(data.dq[at[0]], 4) + " " +
        figure.dataset.velocity + ": " + (mean === null ? "not visited" : say(mean, 3) + " " + unit);
      cursor.setAttribute("x", at[1]);
      cursor.setAttribute("y", at[0]);
      cursor.setAttribute("visibility", "visible");
    }
    function hide() { at = null; output.textContent = rest; cursor.setAttribute("visibility", "hidden"); }
    box.addEventListener("pointermove", (event) => {
      const area = box.getBoundingClientRect();
      show(Math.floor(rows * (event.clientY - area.top) / area.height), Math.floor(columns * (event.clientX - area.left) / area.width));
    });
    box.addEventListener("pointerleave", () => { if (document.activeElement !== box) hide(); });
    box.addEventListener("blur", hide);
    box.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
      if (!by || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      if (at === null) show(Math.floor(rows / 2), Math.floor(columns / 2)); else show(at[0] + by[0], at[1] + by[1]);
    });
  }

  function showWindow(button) {
    const group = groups.get(button.dataset.show);
    if (!group) return;
    const from = Number(button.dataset.from), to = Number(button.dataset.to), room = 0.25 * (to - from);
    range(group, from - room, to + room);
    const section = document.getElementById(button.dataset.sheet);
    const curve = group.curves.find((one) => section.contains(one.figure) && one.figure.dataset.joint === button.dataset.joint);
    if (!curve) return;
    curve.figure.closest("details").open = true;
    curve.plot.focus();
    pick(group, (from + to) / 2);
    curve.figure.scrollIntoView({ block: "center" });
  }

  for (const figure of all(document, ".chart")) new Curve(figure);
  for (const figure of all(document, ".map")) readMap(figure);
  for (const button of all(document, "[data-show]")) button.addEventListener("click", () => showWindow(button));
  for (const button of all(document, "[data-fold]"))
    button.addEventListener("click", () => { for (const part of all(document, "details")) part.open = button.dataset.fold === "open"; });
  let closed = [];
  window.addEventListener("beforeprint", () => { closed = all(document, "details:not([open])"); for (const part of closed) part.open = true; });
  window.addEventListener("afterprint", () => { for (const part of closed) part.open = false; closed = []; });
  document.documentElement.dataset.ready = "yes";
})();
