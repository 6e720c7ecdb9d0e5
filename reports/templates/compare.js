"use strict";
// Draws the figures of a comparison in the page's colours.
(() => {
  const figures = JSON.parse(document.getElementById("data").textContent);
  const BLUE = "#0072B2", SKY = "#56B4E9";
  function themed(figure) {
    const style = getComputedStyle(document.documentElement);
    const value = (name) => style.getPropertyValue(name).trim();
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const copy = structuredClone(figure);
    for (const trace of copy.data) if (trace.line && trace.line.color === BLUE && dark) trace.line.color = SKY;
    Object.assign(copy.layout, { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" });
    copy.layout.font.color = value("--ink");
    for (const name of Object.keys(copy.layout)) {
      if (!/^[xy]axis/.test(name)) continue;
      Object.assign(copy.layout[name], { gridcolor: value("--grid"), zerolinecolor: value("--rule"), linecolor: value("--rule") });
    }
    return copy;
  }
  function draw() {
    for (const [id, figure] of Object.entries(figures)) {
      const place = document.getElementById(id);
      if (!place) continue;
      const { data, layout } = themed(figure);
      layout.width = place.clientWidth;
      Plotly.react(place, data, layout, { displayModeBar: false, doubleClick: "reset", scrollZoom: id.startsWith("path") });
    }
    document.body.dataset.ready = "true";
  }
  draw();
  let pending = 0;
  window.addEventListener("resize", () => { cancelAnimationFrame(pending); pending = requestAnimationFrame(draw); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
})();
