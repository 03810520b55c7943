"use strict";
/* Numbers as text, and parameters as a file and as a link. */

function told(value, digits = 5) {
  if (!Number.isFinite(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits)));
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  return mantissa.replace(/\.?0+$/, "") + "e" + Number(power);
}

function amount(value, unit, digits) {
  return told(value, digits) + (unit === "1" ? "" : " " + unit);
}

/* A value in three digits, forces and torques in larger units. */
function short(value, unit) {
  const larger = [[1e9, 1e9, "G"], [1e6, 1e6, "M"], [1e4, 1e3, "k"]].find(row => Math.abs(value) >= row[0]);
  const [, factor, prefix] = (unit[0] === "N" && larger) || [0, 1, ""];
  return amount(Number((value / factor).toPrecision(3)), prefix + unit, 6);
}

/* What the position of an event says; pieces of a period are counted on. */
function wordsOf(named, number) {
  if (named.words) return named.words[number] || "";
  const count = named.begins.length;
  const begin = n => told(named.begins[n - count * Math.floor(n / count)] + named.period * Math.floor(n / count), 6);
  return `${named.left} >= ${begin(number)} and ${named.left} < ${begin(number + 1)}`;
}

/* A number of the run from what the loop took; NaN where its event did not happen. */
function numberOf(rule, taken) {
  const r = rule.places.map(place => {
    if (place.column < 0) return place.factor;
    if (place.happened >= 0 && !(taken[place.happened] >= place.least)) return NaN;
    const value = place.factor * taken[place.column];
    return place.is_positive ? Math.max(value, 0) : value;
  });
  return Function("r", "return " + rule.formula)(r);
}

function parameterFile(name, parameters, values) {
  const lines = parameters.map((p, i) =>
    JSON.stringify(p.name) + " = " + JSON.stringify(values[i] + " " + p.unit));
  return "# " + name + "\n" + lines.join("\n") + "\n";
}

/* Values of a file of parameters, TOML lines or JSON, by name; units must be those of the page. */
function readParameters(text, parameters) {
  const pairs = text.trim().startsWith("{")
    ? Object.entries(JSON.parse(text))
    : text.split(/\r?\n/).map(line => line.trim()).filter(line => line && line[0] !== "#")
        .map(line => {
          const parts = line.match(/^("(?:[^"\\]|\\.)*"|[\w.\-\[\]]+)\s*=\s*(.+)$/);
          if (!parts) throw new Error("This line is no parameter: " + line);
          const name = parts[1][0] === '"' ? JSON.parse(parts[1]) : parts[1];
          return [name, parts[2][0] === '"' ? JSON.parse(parts[2]) : Number(parts[2])];
        });
  const found = new Map();
  for (const [name, given] of pairs) {
    const place = parameters.findIndex(p => p.name === name);
    if (place < 0) throw new Error("The model has no parameter " + name + ".");
    const [number, ...unit] = String(given).trim().split(/\s+/);
    const value = Number(number), own = parameters[place].unit;
    if (!Number.isFinite(value)) throw new Error(name + " = " + given + " is no number.");
    if (unit.length && unit.join(" ") !== own)
      throw new Error(name + " = " + given + ": give it in " + own + ".");
    found.set(place, value);
  }
  return found;
}
