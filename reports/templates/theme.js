"use strict";
// A figure in the colours of the page, light or dark; every page of ours uses it.
const themed = (() => {
  const BLUE = "#0072B2", SKY = "#56B4E9";
  function themed(figure) {
    const style = getComputedStyle(document.documentElement);
    const value = (name) => style.getPropertyValue(name).trim();
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const copy = structuredClone(figure);
    for (const trace of copy.data)
      for (const part of [trace.line, trace.marker, trace.textfont])
        if (part && part.color === BLUE && dark) part.color = SKY;
    Object.assign(copy.layout, { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" });
    copy.layout.font.color = value("--ink");
    for (const name of Object.keys(copy.layout)) {
      if (!/^[xy]axis/.test(name)) continue;
      Object.assign(copy.layout[name], { gridcolor: value("--grid"), zerolinecolor: value("--rule"), linecolor: value("--rule") });
    }
    return copy;
  }
  return themed;
})();
