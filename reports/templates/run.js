"use strict";
// Ties the page together: one time, shown by slider, top view, charts and figures alike.
begin((data, drawn) => {
  const by = (id) => document.getElementById(id);
  const slider = by("time"), chart = by("chart"), cursor = by("cursor");
  const view = new View(by("scene"), data);
  const times = data.ego.t;
  const start = times.length ? times[0] : 0, end = times.length ? times[times.length - 1] : 1;
  let t = start, playing = false, last = 0;
  slider.min = start;
  slider.max = end;

  function show(time, focus) {
    t = Math.min(end, Math.max(start, time));
    if (focus !== undefined) view.focus = focus;
    view.t = t;
    slider.value = t;
    by("now").textContent = `${t.toFixed(2)} s`;
    document.body.dataset.time = t.toFixed(2);
    view.draw();
    readout();
    moveCursor();
  }

  function readout() {
    const ego = data.ego;
    const entries = [];
    const add = (label, value, digits, unit) => { if (value !== null && value !== undefined) entries.push([label, `${value.toFixed(digits)} ${unit}`]); };
    add("speed", sample(ego, "v", t), 2, "m/s");
    const steer = sample(ego, "steer", t);
    add("steer", steer === null ? null : steer * 180 / Math.PI, 1, "deg");
    add("acceleration", sample(ego, "ax", t), 2, "m/s²");
    if (data.ttc && data.ttc.t.length) {
      const k = before(data.ttc.t, t + 1e-6);
      const inverse = k >= 0 ? data.ttc.value[k] : null;
      entries.push(["time to collision", inverse ? `${(1 / inverse).toFixed(2)} s` : "none"]);
    }
    const places = data.places.filter(([, , from, to]) => from <= t && (t < to || to >= end)).map(([net, place]) => `${net}: ${place}`);
    const active = new Set(data.places.filter(([, , from, to]) => from <= t && (t < to || to >= end)).map(([net, place]) => `${net}\n${place}`));
    for (const mark of document.querySelectorAll("[data-net]")) mark.classList.toggle("active", active.has(`${mark.dataset.net}\n${mark.dataset.place}`));
    if (data.places.length) entries.push(["decision", places.join(" · ") || "none"]);
    const list = by("readout");
    list.replaceChildren(...entries.map(([label, value]) => {
      const item = document.createElement("div"), name = document.createElement("dt"), text = document.createElement("dd");
      if (label === "decision") item.className = "places";
      name.textContent = label;
      text.textContent = value;
      item.append(name, text);
      return item;
    }));
  }

  // Charts ----------------------------------------------------------------------------------------------------------
  function plot() {
    if (!data.figure) { chart.textContent = "Nothing was recorded."; return; }
    if (!drawn) return;
    const { data: traces, layout } = themed(data.figure);
    layout.width = chart.clientWidth;
    Plotly.react(chart, traces, layout, { displayModeBar: false, doubleClick: "reset" }).then(moveCursor);
  }

  function axis() { return chart._fullLayout ? chart._fullLayout.xaxis : null; }

  function moveCursor() {
    const x = axis();
    if (!x) return;
    const at = x.d2p(t);
    cursor.style.display = at >= 0 && at <= x._length ? "block" : "none";
    cursor.style.left = `${x._offset + at}px`;
    const size = chart._fullLayout._size;
    cursor.style.top = `${size.t}px`;
    cursor.style.height = `${size.h}px`;
  }

  let pressed = null;
  chart.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; }, true);
  window.addEventListener("pointerup", (event) => {
    const x = axis();
    if (!pressed || !x || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) { pressed = null; return; }
    pressed = null;
    const at = event.clientX - chart.getBoundingClientRect().left - x._offset;
    if (at >= 0 && at <= x._length) show(x.p2d(at), null);
  }, true);

  // Controls --------------------------------------------------------------------------------------------------------
  function play(on) {
    playing = on;
    by("play").textContent = on ? "❚❚ Pause" : "▶ Play";
    if (!on) return;
    if (t >= end - 1e-6) show(start, null);
    last = performance.now();
    requestAnimationFrame(frame);
  }
  function frame(now) {
    if (!playing) return;
    show(t + (now - last) / 1000 * Number(by("pace").value));
    last = now;
    if (t >= end) play(false); else requestAnimationFrame(frame);
  }
  const mode = (name) => { for (const id of ["follow", "whole"]) by(id).setAttribute("aria-pressed", String(id === name)); };
  slider.addEventListener("input", () => show(Number(slider.value), null));
  by("play").addEventListener("click", () => play(!playing));
  by("follow").addEventListener("click", () => { mode("follow"); view.follow(); });
  by("whole").addEventListener("click", () => { mode("whole"); view.whole(); });
  by("closer").addEventListener("click", () => view.zoom(0.75));
  by("wider").addEventListener("click", () => view.zoom(1 / 0.75));
  by("scene").addEventListener("freed", () => mode(""));
  by("unzoom").addEventListener("click", plot);
  for (const button of document.querySelectorAll("button.jump")) {
    button.addEventListener("click", () => {
      play(false);
      show(Number(button.dataset.t), button.dataset.object);
      by("replay").scrollIntoView({ behavior: "auto", block: "nearest" });
    });
  }
  document.addEventListener("keydown", (event) => {
    if (/^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName)) return;
    const step = { ArrowRight: 0.05, ArrowLeft: -0.05 }[event.key];
    if (step) { show(t + step * (event.shiftKey ? 20 : 1)); event.preventDefault(); }
    if (event.key === " ") { play(!playing); event.preventDefault(); }
  });

  const ticks = by("ticks");
  const tick = (time, kind, label, focus) => {
    const button = document.createElement("button");
    button.className = kind;
    button.title = label;
    button.setAttribute("aria-label", label);
    button.style.left = `${100 * (time - start) / (end - start || 1)}%`;
    button.addEventListener("click", () => show(time, focus));
    ticks.append(button);
  };
  for (const event of data.events) tick(event.t, "event", event.label, null);
  for (const mark of data.marks) tick(mark.t, "worst", `worst ${mark.metric} at ${mark.t.toFixed(2)} s ${mark.object}`, mark.object);

  function repaint() { view.theme(); plot(); show(t); }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  let pending = 0;
  window.addEventListener("resize", () => { cancelAnimationFrame(pending); pending = requestAnimationFrame(repaint); });
  const fromAddress = () => { const wanted = /[#&]t=([0-9.]+)/.exec(location.hash); return wanted ? Number(wanted[1]) : null; };
  window.addEventListener("hashchange", () => { const wanted = fromAddress(); if (wanted !== null) show(wanted); });
  view.theme();
  const first = fromAddress();
  // Without a wish the page opens on what matters: the worst moment of the verdict at the top of the table.
  if (first !== null) show(first);
  else if (data.marks.length) show(data.marks[0].t, data.marks[0].object);
  else show(start);
  plot();
  document.body.dataset.ready = "true";
});
