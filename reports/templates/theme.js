"use strict";
// What every page of ours uses: its data, the library that draws, and a figure in the colours of the page.

/** Bytes of deflated data (RFC 1951) from byte `start` on, `size` of them. The browser's own DecompressionStream works
    beside the page: a picture of the page, or its print, would be taken before the figures are there. */
function inflated(input, start, size) {
  const out = new Uint8Array(size);
  let at = start, end = 0, held = 0, count = 0;
  const bits = (n) => {
    while (count < n) { held |= input[at++] << count; count += 8; }
    const value = held & ((1 << n) - 1);
    held >>>= n;
    count -= n;
    return value;
  };
  // A code: of each length how many symbols have it, and the symbols by length
  const code = (lengths) => {
    const many = new Uint16Array(16), first = new Uint16Array(16), symbols = new Uint16Array(lengths.length);
    for (const length of lengths) many[length]++;
    many[0] = 0;
    for (let n = 1; n < 15; n++) first[n + 1] = first[n] + many[n];
    lengths.forEach((length, symbol) => { if (length) symbols[first[length]++] = symbol; });
    return { many, symbols };
  };
  const next = ({ many, symbols }) => {
    let value = 0, first = 0, place = 0;
    for (let n = 1; n < 16; n++) {
      value |= bits(1);
      if (value - many[n] < first) return symbols[place + value - first];
      place += many[n];
      first = (first + many[n]) << 1;
      value <<= 1;
    }
    throw new Error("damaged");
  };
  const fixed = [
    code(Array.from({ length: 288 }, (_, k) => k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8)),
    code(new Array(30).fill(5)),
  ];
  const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
  const told = () => {
    const literals = bits(5) + 257, distances = bits(5) + 1, lengths = bits(4) + 4;
    const sizes = new Array(19).fill(0);
    for (let k = 0; k < lengths; k++) sizes[ORDER[k]] = bits(3);
    const by = code(sizes), all = [];
    while (all.length < literals + distances) {
      const symbol = next(by);
      if (symbol < 16) { all.push(symbol); continue; }
      const again = symbol === 16 ? 3 + bits(2) : symbol === 17 ? 3 + bits(3) : 11 + bits(7);
      const value = symbol === 16 ? all[all.length - 1] : 0;
      for (let k = 0; k < again; k++) all.push(value);
    }
    return [code(all.slice(0, literals)), code(all.slice(literals))];
  };
  const block = ([literals, distances]) => {
    for (;;) {
      const symbol = next(literals);
      if (symbol === 256) return;
      if (symbol < 256) { out[end++] = symbol; continue; }
      const k = symbol - 257, more = k < 8 || k === 28 ? 0 : (k >> 2) - 1;
      const length = k === 28 ? 258 : k < 8 ? 3 + k : 3 + ((4 + (k & 3)) << more) + bits(more);
      const d = next(distances), wide = d < 4 ? 0 : (d >> 1) - 1;
      const back = d < 4 ? 1 + d : 1 + ((2 + (d & 1)) << wide) + bits(wide);
      if (back > end || end + length > size) throw new Error("damaged");
      for (const to = end + length; end < to; end++) out[end] = out[end - back];
    }
  };
  for (let last = 0; !last;) {
    last = bits(1);
    const kind = bits(2);
    if (kind === 1) block(fixed);
    else if (kind === 2) block(told());
    else {
      held = count = 0;
      const length = input[at] | (input[at + 1] << 8);
      out.set(input.subarray(at + 4, at + 4 + length), end);
      at += 4 + length;
      end += length;
    }
  }
  return out;
}

/** Text of a script element that holds gzip (RFC 1952, without a name, as reports/embed.py writes it) in base64. */
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const size = new DataView(bytes.buffer).getUint32(bytes.length - 4, true);
  return new TextDecoder().decode(inflated(bytes, 10, size));
}

/** The page's data; reports/embed.py says how long lists of numbers are written. */
function contents() {
  const data = JSON.parse(document.getElementById("data").textContent);
  if (!data["@arrays"]) return data;
  const lists = JSON.parse(unpacked(data["@arrays"])).map((list) => {
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
function drawable() {
  const packed = document.getElementById("library");
  if (!window.Plotly && packed) {
    const script = document.createElement("script");
    try { script.textContent = unpacked(packed.textContent); } catch { return false; }
    document.head.append(script);
  }
  return Boolean(window.Plotly);
}

/** Run `start(data, whether figures can be drawn)` before the page counts as loaded; where something is missing, one
    line above the page says so. */
function begin(start) {
  const drawn = drawable();
  document.getElementById("missing").hidden = drawn;
  start(contents(), drawn);
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
