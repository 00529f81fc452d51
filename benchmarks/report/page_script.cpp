#include "benchmarks/report/page_parts.hpp"

namespace finegauge {

// Values are read back from the drawing by the chart's scales (data-x, data-y: low, high, logarithmic, pixels), so that
// they need not stand in the page twice. Marks with a title of their own show that.
const char* const page_script = R"js("use strict";
(() => {
  const tip = document.getElementById("tip");
  const space = "http://www.w3.org/2000/svg";
  const digits = (v) => {
    const size = Math.abs(v);
    if (v !== 0 && (size < 1e-3 || size >= 1e7)) return v.toExponential(2).replace("-", "\u2212");
    const text = size >= 1000 ? Math.round(v).toLocaleString("en") : Number(v.toPrecision(3)).toString();
    return text.replace("-", "\u2212");
  };
  const scale = (text) => {
    const [low, high, log, from, to] = text.split(" ").map(Number);
    const a = log ? Math.log10(low) : low, b = log ? Math.log10(high) : high;
    return (px) => { const v = a + (b - a) * (px - from) / (to - from); return log ? 10 ** v : v; };
  };
  const show = (event, text) => {
    tip.textContent = text;
    tip.hidden = false;
    const room = document.documentElement.clientWidth, width = tip.offsetWidth;
    tip.style.left = Math.max(4, Math.min(event.pageX + 14, window.scrollX + room - width - 8)) + "px";
    tip.style.top = event.pageY + 16 + "px";
  };
  const read = (svg) => {
    const curves = [], marks = [];
    for (const group of svg.querySelectorAll("[data-label]"))
      for (const line of group.querySelectorAll("polyline"))
        curves.push({ label: group.dataset.label, points: Array.from(line.points, (p) => [p.x, p.y]) });
    for (const band of svg.querySelectorAll("polygon.band")) {  // its upper side, and its lower one backwards
      const label = band.querySelector("title").textContent, upper = Number(band.dataset.upper), points = Array.from(band.points, (p) => [p.x, p.y]);
      curves.push({ label: label + ", most", points: points.slice(0, upper) });
      curves.push({ label: label + ", least", points: points.slice(upper) });
      band.querySelector("title").remove();
    }
    for (const shape of svg.querySelectorAll("circle, rect, .cross")) {
      const title = shape.querySelector("title");
      if (!title) continue;
      const text = title.textContent, box = shape.getBBox();
      marks.push({ text, box, round: shape.tagName === "circle" });
      title.remove();  // the browser's own would stand beside ours
      shape.setAttribute("aria-label", text);
    }
    for (const title of svg.querySelectorAll("polyline > title")) title.remove();
    const spot = document.createElementNS(space, "g");
    svg.append(spot);
    return { curves, marks, spot, x: svg.dataset.x && scale(svg.dataset.x), y: svg.dataset.y && scale(svg.dataset.y),
             name: svg.querySelector(".name.mid")?.textContent ?? "" };
  };
  const add = (parent, name, attributes) => {
    const node = document.createElementNS(space, name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    parent.append(node);
  };
  for (const svg of document.querySelectorAll("svg.chart")) {
    let chart = null;
    const leave = () => { tip.hidden = true; chart?.spot.replaceChildren(); };
    svg.addEventListener("pointerleave", leave);
    svg.addEventListener("pointermove", (event) => {
      chart ??= read(svg);
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      chart.spot.replaceChildren();
      let best = null, least = 14;
      for (const mark of chart.marks) {
        const b = mark.box;
        const away = mark.round ? Math.hypot(b.x + b.width / 2 - at.x, b.y + b.height / 2 - at.y)
                                : at.x >= b.x - 1 && at.x <= b.x + b.width + 1 && at.y >= b.y - 2 && at.y <= b.y + b.height + 2 ? 13 : 99;
        if (away < least) { least = away; best = mark; }
      }
      if (best) {
        if (best.round) add(chart.spot, "circle", { cx: best.box.x + best.box.width / 2, cy: best.box.y + best.box.height / 2, r: 6, class: "spot" });
        return show(event, best.text);
      }
      if (!chart.x || chart.curves.length === 0) return leave();
      const nearest = svg.dataset.nearest;
      const found = new Map();
      for (const curve of chart.curves)
        for (const p of curve.points) {
          const away = nearest ? Math.hypot(p[0] - at.x, p[1] - at.y) : Math.abs(p[0] - at.x);
          const key = nearest ? "" : curve.label;
          if (!found.has(key) || away < found.get(key).away) found.set(key, { away, p, label: curve.label });
        }
      const close = [...found.values()].filter((one) => one.away < (nearest ? 30 : 20));
      if (close.length === 0) return leave();
      const lines = [chart.name.replace(/ \[.*/, "") + " " + digits(chart.x(close[0].p[0]))];
      for (const one of close) {
        lines.push(one.label + ": " + digits(chart.y(one.p[1])));
        add(chart.spot, "circle", { cx: one.p[0], cy: one.p[1], r: 5, class: "spot" });
      }
      if (!nearest) add(chart.spot, "path", { d: `M${close[0].p[0]} 30V280`, class: "cross-hair" });
      show(event, lines.join("\n"));
    });
  }
})();
)js";

}  // namespace finegauge
