"use strict";
// Zoom by wheel or buttons, pan by dragging, and the value of the nearest point of a curve.

const short = (value) => String(Number(value.toPrecision(5)));

function button(box, text, label, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.setAttribute("aria-label", label);
  made.addEventListener("click", action);
  box.append(made);
}

function zoomable(figure) {
  const svg = figure.querySelector("svg");
  const { x, y, width, height } = svg.viewBox.baseVal;
  const home = [x, y, width, height];
  let view = home.slice();
  let grip = null;
  const show = () => svg.setAttribute("viewBox", view.join(" "));
  const place = (event) => new DOMPoint(event.clientX, event.clientY)
    .matrixTransform(svg.getScreenCTM().inverse());
  const zoom = (factor, px, py) => {
    const size = Math.min(Math.max(view[2] * factor, home[2] / 200), home[2]);
    const k = size / view[2];
    view = [px + (view[0] - px) * k, py + (view[1] - py) * k, size, view[3] * k];
    if (size === home[2]) view = home.slice();
    show();
  };
  const centre = (factor) => zoom(factor, view[0] + view[2] / 2, view[1] + view[3] / 2);

  const bar = document.createElement("div");
  button(bar, "+", "zoom in", () => centre(0.7));
  button(bar, "\u2212", "zoom out", () => centre(1 / 0.7));
  button(bar, "reset", "show all again", () => { view = home.slice(); show(); });
  const value = document.createElement("output");
  bar.append(value);
  figure.prepend(bar);

  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const p = place(event);
    zoom(event.deltaY < 0 ? 0.8 : 1.25, p.x, p.y);
  }, { passive: false });
  svg.addEventListener("pointerdown", (event) => {
    grip = place(event);
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointerup", () => { grip = null; });
  svg.addEventListener("pointermove", (event) => {
    const p = place(event);
    if (grip) {
      view[0] += grip.x - p.x;
      view[1] += grip.y - p.y;
      show();
    } else {
      value.textContent = nearest(axes, svg, p);
    }
  });
  const axes = JSON.parse(figure.dataset.axes);
}

function points(svg, line) {
  if (!line.points) {
    const path = svg.querySelector(`[id="${line.id}"] path`);
    const numbers = path ? path.getAttribute("d").match(/-?[\d.]+(?:e-?\d+)?/g).map(Number) : [];
    line.points = numbers;
  }
  return line.points;
}

function nearest(axes, svg, p) {
  const on = (a) => p.x >= a.box[0] && p.x <= a.box[2] && p.y >= a.box[1] && p.y <= a.box[3];
  const axis = axes.find(on);
  if (!axis) return "";
  let best = { distance: Infinity, x: p.x, y: p.y, label: "" };
  for (const line of axis.lines) {
    const numbers = points(svg, line);
    for (let i = 0; i + 1 < numbers.length; i += 2) {
      const distance = Math.hypot(numbers[i] - p.x, numbers[i + 1] - p.y);
      if (distance < best.distance) {
        best = { distance, x: numbers[i], y: numbers[i + 1], label: line.label };
      }
    }
  }
  const [x0, y0, x1, y1] = axis.box;
  const scaled = (share, [from, to], log) => (log
    ? from * (to / from) ** share : from + share * (to - from));
  const x = scaled((best.x - x0) / (x1 - x0), axis.x, axis.logx);
  const y = scaled((y1 - best.y) / (y1 - y0), axis.y, axis.logy);
  const name = best.label ? `${best.label}: ` : "";
  return `${name}${axis.xlabel || "x"} ${short(x)}; ${axis.ylabel || "y"} ${short(y)}`;
}

document.querySelectorAll("figure[data-axes]").forEach(zoomable);
