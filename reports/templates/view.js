"use strict";
// The top view: road, boxes and paths on a canvas. One object, `View`; knows nothing of charts or the rest of the page.

/** Index of the last entry of ascending `list` that is <= t, or -1. */
function before(list, t) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
}

/** Linear interpolation of track[name] at t; angles take the short way round; null where nothing was measured. */
function sample(track, name, t, isAngle = false) {
  const values = track[name];
  if (!values) return null;
  const i = before(track.t, t + 1e-9);
  if (i < 0) return values[0];
  const a = values[i];
  if (i + 1 >= values.length || a === null || values[i + 1] === null) return a;
  let d = values[i + 1] - a;
  if (isAngle) d = Math.atan2(Math.sin(d), Math.cos(d));
  return a + d * Math.min(1, (t - track.t[i]) / (track.t[i + 1] - track.t[i]));
}

class View {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.t = 0;
    this.focus = null; // name of the object of the worst moment that was asked for
    this.mode = "follow";
    this.span = 62; // m across the canvas while following
    this.center = [0, 0];
    this.bounds = this.extent();
    this.colours = {};
    this.drag();
  }

  extent() {
    let box = [Infinity, Infinity, -Infinity, -Infinity];
    const take = (x, y) => {
      if (x === null || y === null) return;
      box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
    };
    for (const line of this.data.road) for (const [x, y] of line.points) take(x, y);
    const ego = this.data.ego;
    for (let i = 0; i < ego.t.length; i++) take(ego.x[i], ego.y[i]);
    return Number.isFinite(box[0]) ? box : [-10, -10, 10, 10];
  }

  follow() { this.mode = "follow"; this.span = 62; this.draw(); }

  whole() {
    const [x0, y0, x1, y1] = this.bounds;
    this.mode = "free";
    this.center = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.span = 1.06 * Math.max(x1 - x0, (y1 - y0) * this.canvas.clientWidth / this.canvas.clientHeight, 20);
    this.draw();
  }

  zoom(factor) { this.span = Math.min(2000, Math.max(8, this.span * factor)); this.draw(); }

  drag() {
    const canvas = this.canvas;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => { last = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointerup", () => { last = null; });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const scale = this.span / canvas.clientWidth;
      this.mode = "free";
      this.center = [this.center[0] - (event.clientX - last[0]) * scale, this.center[1] + (event.clientY - last[1]) * scale];
      last = [event.clientX, event.clientY];
      canvas.dispatchEvent(new Event("freed"));
      this.draw();
    });
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(0.0012 * event.deltaY)); }, { passive: false });
  }

  theme() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ground", "asphalt", "edge", "mark", "ego", "vehicle", "pedestrian", "misc", "detected", "planned", "driven", "estimated", "ink", "soft", "bad", "card"])
      this.colours[name] = style.getPropertyValue("--" + name).trim();
    this.colours.bicycle = this.colours.pedestrian;
  }

  draw() {
    const { canvas, data, t, colours: colour } = this;
    const ratio = window.devicePixelRatio || 1;
    const w = canvas.clientWidth, h = canvas.clientHeight;
    if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
      canvas.width = Math.round(w * ratio);
      canvas.height = Math.round(h * ratio);
    }
    const pen = canvas.getContext("2d");
    const ego = data.ego;
    const pose = ego.t.length && ego.x ? [sample(ego, "x", t), sample(ego, "y", t), sample(ego, "yaw", t, true)] : null;
    if (this.mode === "follow" && pose && pose[0] !== null) this.center = [pose[0] + 10 * Math.cos(pose[2]), pose[1] + 10 * Math.sin(pose[2])];
    const scale = w / this.span;
    this.scale = scale;
    const px = (x, y) => [w / 2 + (x - this.center[0]) * scale, h / 2 - (y - this.center[1]) * scale];
    this.px = px;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = colour.ground;
    pen.fillRect(0, 0, w, h);
    this.road(pen, px, scale);
    this.trail(pen, px);
    for (const track of data.objects) this.object(pen, track);
    if (pose && pose[0] !== null) {
      const [x, y, yaw] = pose;
      const cx = x + ego.center_x * Math.cos(yaw), cy = y + ego.center_x * Math.sin(yaw);
      this.box(pen, cx, cy, yaw, ego.length, ego.width, colour.ego, ego.name);
    }
    this.detected(pen);
    this.estimated(pen);
    this.rule(pen, w, h, scale);
  }

  stroke(pen, points, px) {
    pen.beginPath();
    points.forEach(([x, y], i) => { const p = px(x, y); if (i) pen.lineTo(p[0], p[1]); else pen.moveTo(p[0], p[1]); });
    pen.stroke();
  }

  road(pen, px, scale) {
    const { colours: colour } = this;
    for (const line of this.data.road) {
      if (line.kind !== "crosswalk") continue;
      this.crosswalk(pen, line.points, px);
    }
    for (const line of this.data.road) {
      if (line.kind === "crosswalk") continue;
      const isCentre = line.kind === "centre";
      pen.strokeStyle = colour.edge;
      pen.lineWidth = line.kind === "edge" ? 1.8 : 1;
      pen.globalAlpha = line.kind === "edge" ? 1 : 0.65;
      pen.setLineDash(isCentre ? [Math.max(3, 2 * scale), Math.max(3, 2 * scale)] : []);
      this.stroke(pen, line.points, px);
    }
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  crosswalk(pen, points, px) {
    const { colours: colour } = this;
    pen.beginPath();
    points.forEach(([x, y], i) => { const p = px(x, y); if (i) pen.lineTo(p[0], p[1]); else pen.moveTo(p[0], p[1]); });
    pen.closePath();
    pen.fillStyle = colour.asphalt;
    pen.fill();
    if (points.length < 4) return;
    // Stripes along the shorter side, half a metre wide, across the longer one: a zebra.
    let [a, b, , d] = points;
    const side = (p, q) => Math.hypot(q[0] - p[0], q[1] - p[1]);
    if (side(a, b) < side(a, d)) [b, d] = [d, b];
    const n = Math.max(2, Math.floor(side(a, b) / 0.5));
    pen.fillStyle = colour.edge;
    for (let i = 0; i < n; i += 2) {
      const at = (u, v) => px(a[0] + (b[0] - a[0]) * u + (d[0] - a[0]) * v, a[1] + (b[1] - a[1]) * u + (d[1] - a[1]) * v);
      pen.beginPath();
      for (const [u, v] of [[i / n, 0], [(i + 1) / n, 0], [(i + 1) / n, 1], [i / n, 1]]) pen.lineTo(...at(u, v));
      pen.fill();
    }
  }

  trail(pen, px) {
    const { data, t, colours: colour } = this;
    const ego = data.ego;
    const k = before(data.paths.t, t + 1e-9);
    const ahead = k < 0 ? [] : this.ahead(data.paths.points[k], data.paths.t[k], t);
    if (ahead.length > 1) {
      pen.strokeStyle = colour.planned;
      pen.lineWidth = 3.2;
      this.stroke(pen, ahead, px);
    }
    if (!ego.x) return;
    const now = before(ego.t, t) + 1;
    pen.strokeStyle = colour.driven;
    const part = (from, to) => this.stroke(pen, ego.t.slice(from, to).map((_, i) => [ego.x[from + i], ego.y[from + i]]).filter((p) => p[0] !== null), px);
    pen.lineWidth = 1;
    pen.globalAlpha = 0.28;
    part(Math.max(0, now - 1), ego.t.length);
    pen.globalAlpha = 1;
    pen.lineWidth = 2;
    part(0, now);
  }

  /** The part of a path planned at `from` that lies before the ego at t; nothing once the ego has left the path. */
  ahead(points, from, t) {
    const here = this.along(points, from, t);
    if (!here) return points;
    if (here.away > 6) return [];
    const rest = [[here.x, here.y], ...points.slice(here.i + 1)];
    const goal = this.data.events.some((event) => event.kind === "goal");
    if (!goal) return rest;
    // A path runs on beyond its goal; the ego stopped there, so what follows was never meant to be driven.
    const end = this.along(points, from, this.data.ego.t[this.data.ego.t.length - 1]);
    return [[here.x, here.y], ...points.slice(here.i + 1, end.i + 1), [end.x, end.y]];
  }

  /** Foot of the ego on a path at t: segment i, point, distance. A path may cross itself, so the ego's way since
      `from` is followed along it instead of taking the nearest of all points. */
  along(points, from, t) {
    const ego = this.data.ego;
    if (!ego.x || points.length < 2) return null;
    const foot = (i, x, y) => {
      const [ax, ay] = points[i], [bx, by] = points[i + 1];
      const ux = bx - ax, uy = by - ay, l2 = ux * ux + uy * uy;
      const u = l2 > 0 ? Math.min(1, Math.max(0, ((x - ax) * ux + (y - ay) * uy) / l2)) : 0;
      return { i, x: ax + u * ux, y: ay + u * uy, away: Math.hypot(ax + u * ux - x, ay + u * uy - y), length: Math.sqrt(l2), ux, uy };
    };
    const nearest = (x, y, first, reach, yaw) => {
      let best = null;
      for (let i = first, way = 0; i + 1 < points.length && way < reach; i++) {
        const f = foot(i, x, y);
        if (i > first) way += f.length;
        if (yaw !== null && f.ux * Math.cos(yaw) + f.uy * Math.sin(yaw) < 0) continue;
        if (!best || f.away < best.away - 1e-9) best = f;
      }
      return best;
    };
    const pose = (time) => [sample(ego, "x", time), sample(ego, "y", time), ego.yaw ? sample(ego, "yaw", time, true) : null];
    const begin = pose(from);
    if (begin[0] === null) return null;
    let here = nearest(begin[0], begin[1], 0, Infinity, begin[2]) || nearest(begin[0], begin[1], 0, Infinity, null);
    for (let time = from; time < t;) {
      time = Math.min(t, time + 0.5);
      const [x, y] = pose(time);
      if (x !== null) here = nearest(x, y, here.i, 40, null) || here;
    }
    return here;
  }

  object(pen, track) {
    const { t, colours: colour } = this;
    if (!track.t.length || t < track.t[0] - 0.06 || t > track.t[track.t.length - 1] + 0.06) return;
    const x = sample(track, "x", t), y = sample(track, "y", t), yaw = sample(track, "yaw", t, true);
    const fill = colour[track.kind] || colour.misc;
    this.box(pen, x, y, yaw, track.length, track.width, fill, track.name);
    if (Math.max(track.length, track.width) * this.scale < 9) { // too small to see: a dot in its place
      pen.fillStyle = fill;
      pen.beginPath();
      pen.arc(...this.px(x, y), 5, 0, 2 * Math.PI);
      pen.fill();
    }
    if (track.name !== this.focus) return;
    const [cx, cy] = this.px(x, y);
    pen.strokeStyle = colour.bad;
    pen.lineWidth = 2.5;
    pen.beginPath();
    pen.arc(cx, cy, Math.max(14, 0.75 * track.length * this.scale), 0, 2 * Math.PI);
    pen.stroke();
  }

  corners(x, y, yaw, length, width) {
    const c = Math.cos(yaw), s = Math.sin(yaw);
    return [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([u, v]) => this.px(x + 0.5 * (u * length * c - v * width * s), y + 0.5 * (u * length * s + v * width * c)));
  }

  box(pen, x, y, yaw, length, width, fill, name) {
    const p = this.corners(x, y, yaw, length, width);
    pen.beginPath();
    p.forEach((q, i) => (i ? pen.lineTo(...q) : pen.moveTo(...q)));
    pen.closePath();
    pen.fillStyle = fill;
    pen.fill();
    pen.lineWidth = 1;
    pen.strokeStyle = this.colours.ink;
    pen.stroke();
    // The nose: a line across a quarter of the length behind the front.
    const mix = (a, b) => [a[0] + (b[0] - a[0]) * 0.25, a[1] + (b[1] - a[1]) * 0.25];
    pen.beginPath();
    pen.moveTo(...mix(p[0], p[3]));
    pen.lineTo((p[0][0] + p[1][0]) / 2, (p[0][1] + p[1][1]) / 2);
    pen.lineTo(...mix(p[1], p[2]));
    pen.stroke();
    if (!name) return;
    pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    const [tx, ty] = [Math.max(...p.map((q) => q[0])) + 5, Math.min(...p.map((q) => q[1])) - 3];
    pen.lineWidth = 3;
    pen.strokeStyle = this.colours.ground;
    pen.strokeText(name, tx, ty);
    pen.fillStyle = this.colours.ink;
    pen.fillText(name, tx, ty);
  }

  detected(pen) {
    const { data, t } = this;
    const k = before(data.detections.t, t + 1e-9);
    if (k < 0 || t - data.detections.t[k] > 0.3) return;
    const boxes = data.detections.boxes[k];
    pen.strokeStyle = this.colours.detected;
    pen.lineWidth = 1.7;
    pen.setLineDash([4, 3]);
    for (let i = 0; i + 4 < boxes.length; i += 5) {
      const [x, y, yaw, length, width] = boxes.slice(i, i + 5);
      pen.beginPath();
      this.corners(x, y, yaw, length, width).forEach((q, j) => (j ? pen.lineTo(...q) : pen.moveTo(...q)));
      pen.closePath();
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  /** Where the stack believes the ego to be. */
  estimated(pen) {
    const ego = this.data.ego, t = this.t;
    if (!ego["ads.x"] || !ego["ads.yaw"]) return;
    const x = sample(ego, "ads.x", t), y = sample(ego, "ads.y", t), yaw = sample(ego, "ads.yaw", t, true);
    if (x === null || y === null || yaw === null) return;
    const p = this.corners(x + ego.center_x * Math.cos(yaw), y + ego.center_x * Math.sin(yaw), yaw, ego.length, ego.width);
    pen.strokeStyle = this.colours.estimated;
    pen.lineWidth = 2;
    pen.beginPath();
    p.forEach((q, j) => (j ? pen.lineTo(...q) : pen.moveTo(...q)));
    pen.closePath();
    pen.stroke();
  }

  rule(pen, w, h, scale) {
    const metres = [1, 2, 5, 10, 20, 50, 100, 200].find((m) => m * scale > 60) || 500;
    pen.strokeStyle = pen.fillStyle = this.colours.soft;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(14, h - 14);
    pen.lineTo(14 + metres * scale, h - 14);
    pen.stroke();
    pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    pen.fillText(`${metres} m`, 14, h - 20);
  }
}
