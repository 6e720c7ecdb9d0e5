"use strict";
// Draws the figures of a page in its colours.
begin((figures, drawn) => {
  function draw() {
    for (const [id, figure] of Object.entries(figures)) {
      const place = document.getElementById(id);
      if (!place || !drawn) continue;
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
});
