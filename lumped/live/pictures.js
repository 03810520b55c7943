/* Curves on canvases: axes, curves of the run, and those of the model as it was. */

const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"];
const EDGE = {left: 58, right: 10, top: 8, bottom: 30};

function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find(m => m * power >= raw) * power;
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

class Panel {
  constructor(root, quantities, columns) {
    this.columns = columns;
    this.quantities = quantities;
    const unit = quantities[columns[0]].unit;
    const legend = document.createElement("div");
    legend.className = "legend";
    legend.append(unit === "1" ? "" : "in " + unit + ": ");
    columns.forEach((column, i) => {
      const entry = document.createElement("span");
      entry.innerHTML = '<b style="color:' + COLOURS[i % COLOURS.length] + '">\u2014</b> ';
      entry.append(quantities[column].name);
      entry.title = quantities[column].text;
      legend.append(entry);
    });
    this.at = document.createElement("span");
    legend.append(this.at);
    this.canvas = document.createElement("canvas");
    root.append(legend, this.canvas);
    this.canvas.addEventListener("pointermove", event => this.point(event));
    this.canvas.addEventListener("pointerleave", () => { this.at.textContent = ""; });
  }

  range(rows) {
    let low = Infinity, high = -Infinity;
    for (const found of rows) {
      if (!found) continue;
      for (const column of this.columns)
        for (const value of found.columns[column]) {
          if (value < low) low = value;
          if (value > high) high = value;
        }
    }
    if (!(high >= low)) return [0, 1];
    const room = high > low ? 0.05 * (high - low) : 0.05 * Math.abs(high) || 1;
    return [low - room, high + room];
  }

  /* `now` and `before` have times and one array of values for each quantity. */
  draw(now, before, span) {
    const ratio = window.devicePixelRatio || 1, {clientWidth: width, clientHeight: height} = this.canvas;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const [low, high] = this.range([now, before]);
    const x = t => EDGE.left + (t - span[0]) / (span[1] - span[0]) * (width - EDGE.left - EDGE.right);
    const y = v => height - EDGE.bottom - (v - low) / (high - low) * (height - EDGE.top - EDGE.bottom);
    this.time = place => span[0] + (place - EDGE.left) / (width - EDGE.left - EDGE.right) * (span[1] - span[0]);
    this.now = now;
    pen.font = "11px system-ui, sans-serif";
    pen.lineWidth = 1;
    pen.strokeStyle = "#e5e8eb";
    pen.fillStyle = "#57606a";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const digits = Math.max(4, 2 + Math.ceil(Math.log10(Math.max(-low, high) / (high - low))));
    for (const value of ticks(low, high, 4)) {
      pen.beginPath();
      pen.moveTo(EDGE.left, y(value));
      pen.lineTo(width - EDGE.right, y(value));
      pen.stroke();
      pen.fillText(told(value, digits), EDGE.left - 5, y(value));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const value of ticks(span[0], span[1], 8)) {
      pen.beginPath();
      pen.moveTo(x(value), EDGE.top);
      pen.lineTo(x(value), height - EDGE.bottom);
      pen.stroke();
      pen.fillText(told(value, 4), x(value), height - EDGE.bottom + 3);
    }
    pen.fillText("time in s", (width + EDGE.left) / 2, height - 13);
    pen.lineJoin = "round";
    if (before) this.curves(pen, before, x, y, () => "#c4c9ce", 1);
    if (now) this.curves(pen, now, x, y, i => COLOURS[i % COLOURS.length], 1.6);
  }

  curves(pen, found, x, y, colour, thickness) {
    pen.lineWidth = thickness;
    this.columns.forEach((column, i) => {
      const values = found.columns[column];
      pen.strokeStyle = colour(i);
      pen.beginPath();
      for (let k = 0; k < values.length; k++) pen.lineTo(x(found.t[k]), y(values[k]));
      pen.stroke();
    });
  }

  point(event) {
    if (!this.now || !this.now.t.length) return;
    const t = this.time(event.offsetX), times = this.now.t;
    let k = 0;
    while (k < times.length - 1 && times[k] < t) k++;
    const values = this.columns.map(c => amount(this.now.columns[c][k], this.quantities[c].unit));
    this.at.textContent = "at " + told(times[k]) + " s: " + values.join(", ");
  }
}
