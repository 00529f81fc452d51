"use strict";
// Run by ci/check-report in a page with the report in two frames: looks at everything in it and leaves lines of text. All at
// once when the frames are loaded: Chromium writes the page out after that and waits for nothing.
window.addEventListener("load", () => {
  const lines = [];
  let drawings = 0, faults = 0;
  const fault = (text) => { ++faults; lines.push("report: FAULT " + text); };
  const frames = [...document.querySelectorAll("iframe")];
  const look = (frame) => {
    const page = frame.contentDocument, width = frame.clientWidth, view = frame.contentWindow;
    const at = (what) => `${what} at ${width} pixels: `;
    for (const part of page.querySelectorAll("details")) part.open = true;
    const root = page.documentElement;
    if (view.innerWidth !== width) fault(at("frame") + "is " + view.innerWidth + " wide");
    if (root.scrollWidth > width) {
      const wide = [...page.querySelectorAll("main *")].filter((node) => node.getBoundingClientRect().right > width + 1 && !node.closest(".scroll, svg"));
      fault(at("page") + `is ${root.scrollWidth} wide: ` + wide.slice(0, 3).map((node) => node.outerHTML.slice(0, 80)).join(" | "));
    }
    if (view.performance.getEntriesByType("resource").length > 0) fault(at("page") + "fetched something");
    const ids = [...page.querySelectorAll("[id]")].map((node) => node.id);
    if (new Set(ids).size !== ids.length) fault(at("page") + "has an id twice: " + ids.find((id, i) => ids.indexOf(id) !== i));
    for (const link of page.querySelectorAll('a[href^="#"]'))
      if (!page.getElementById(link.getAttribute("href").slice(1))) fault(at("link") + link.getAttribute("href") + " leads nowhere");
    for (const reference of page.querySelectorAll("svg [href^='#']"))
      if (!reference.closest("svg").querySelector(reference.getAttribute("href"))) fault(at("drawing") + reference.getAttribute("href") + " is not in it");

    for (const svg of page.querySelectorAll("svg")) {
      ++drawings;
      const name = at((svg.getAttribute("aria-label") ?? svg.closest("figure")?.id ?? "a drawing"));
      const seen = svg.getBoundingClientRect(), drawn = svg.getBBox(), box = svg.viewBox.baseVal;
      if (!(seen.width > 20 && seen.height > 10)) fault(name + `takes ${seen.width} x ${seen.height} pixels`);
      if (!(drawn.width > 0 && drawn.height > 0)) fault(name + "is empty");
      const chart = svg.classList.contains("chart") || svg.classList.contains("spark");
      const marks = svg.querySelectorAll(chart ? ".line, .dot, .bars rect, .bar, .band, .cross" : "path, rect, circle, polygon, image");
      const visible = [...marks].filter((mark) => { const b = mark.getBBox(); return b.width > 0 || b.height > 0; });
      if (visible.length === 0) fault(name + "shows no data");
      if (/NaN|Infinity|undefined/.test(svg.outerHTML.replace(/base64,[^"]*/g, ""))) fault(name + "has a number that is none");
      for (const image of svg.querySelectorAll("image")) {
        // The head of a PNG file; that its pixels are right is shown by the unit tests.
        const [kind, bytes] = image.getAttribute("href").split(",");
        const head = atob(bytes.slice(0, 32)), size = (at) => (head.charCodeAt(at) << 8) + head.charCodeAt(at + 1);
        if (kind !== "data:image/png;base64" || head.slice(1, 4) !== "PNG" || !(size(18) > 100 && size(22) > 100))
          fault(name + "has a broken picture");
      }
      if (!svg.classList.contains("chart")) continue;
      for (const text of svg.querySelectorAll("text")) {
        const b = text.getBBox();
        if (b.x < box.x - 1 || b.x + b.width > box.x + box.width + 1 || b.y < box.y - 3 || b.y + b.height > box.y + box.height + 3)
          fault(name + `"${text.textContent}" is cut off`);
      }
      const ticks = [...svg.querySelectorAll(".tick.mid")].map((text) => text.getBBox()).sort((a, b) => a.x - b.x);
      for (let i = 1; i < ticks.length; ++i)
        if (ticks[i].x < ticks[i - 1].x + ticks[i - 1].width) fault(name + "has labels of ticks over each other");
      // The pointer on the first mark has to bring its value up.
      const target = svg.querySelector(".dot, .bars rect, .bar, polyline.line, .cross"), b = target?.getBBox();
      if (!target) continue;
      const spot = target.points ? target.points[0] : { x: b.x + b.width / 2, y: b.y + b.height / 2 };
      const on = new DOMPoint(spot.x, spot.y).matrixTransform(svg.getScreenCTM());
      svg.dispatchEvent(new view.PointerEvent("pointermove", { clientX: on.x, clientY: on.y }));
      const tip = page.getElementById("tip");
      if (tip.hidden || !/\d/.test(tip.textContent)) fault(name + "tells no value under the pointer");
      svg.dispatchEvent(new view.PointerEvent("pointerleave"));
    }
    for (const figure of page.querySelectorAll("figure"))
      if (figure.querySelector("figcaption")?.textContent.length < 30) fault(at(figure.id) + "has no caption");
  };
  try {
    for (const frame of frames) look(frame);
  } catch (error) {
    fault("the probe failed: " + error.stack);
  }
  lines.push(`report: ${drawings} drawings, ${faults} faults`);
  document.title = "done";
  const text = document.createElement("pre");
  text.textContent = "\n" + lines.join("\n") + "\n";
  document.body.replaceChildren(text);
});
