"use strict";
// What every page of ours uses: its data, the library that draws, and a figure in the colours of the page.

/** Text of a script element that holds gzip in base64. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

/** The page's data; reports/embed.py says how long lists of numbers are written. */
async function contents() {
  const data = JSON.parse(document.getElementById("data").textContent);
  if (!data["@arrays"]) return data;
  const lists = JSON.parse(await unpacked(data["@arrays"])).map((list) => {
    if (Array.isArray(list)) return list;
    const scale = 10 ** list.digits;
    let sum = 0;
    return list.steps.map((step) => step === null ? null : (sum += step) / scale);
  });
  delete data["@arrays"];
  const filled = (value) => {
    if (value === null || typeof value !== "object") return value;
    if ("@array" in value) return lists[value["@array"]];
    for (const key of Object.keys(value)) value[key] = filled(value[key]);
    return value;
  };
  return filled(data);
}

/** Whether figures can be drawn: the library came from beside the page, or is unpacked from it. */
async function drawable() {
  const packed = document.getElementById("library");
  if (!window.Plotly && packed) {
    const script = document.createElement("script");
    script.textContent = await unpacked(packed.textContent);
    document.head.append(script);
  }
  return Boolean(window.Plotly);
}

/** Run `start(data, whether figures can be drawn)`; where something is missing, one line above the page says so. */
async function begin(start) {
  const missing = document.getElementById("missing");
  if (typeof DecompressionStream === "undefined") {
    missing.hidden = false;
    missing.textContent = "Charts and top view are not shown: this browser has no DecompressionStream (Chrome 80, Firefox 113, Safari 16.4 have it).";
    return;
  }
  const drawn = await drawable().catch(() => false);
  missing.hidden = drawn;
  start(await contents(), drawn);
}

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
