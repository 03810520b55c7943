/* The page: sliders move parameters, the loop runs, pictures and numbers follow. */

const data = JSON.parse(document.getElementById("data").textContent);
const place = id => document.getElementById(id);
const values = data.parameters.map(p => p.value);
const sliders = [], SHOWN = 12;
let loop, model = null, shown = null, isDue = false;

function bytes(text) {
  return Uint8Array.from(atob(text.trim()), c => c.charCodeAt(0));
}

/* One run with the present values; rows are those that it reached. */
function computed() {
  loop.reset();
  const found = {fault: "", eventCount: 0, events: [], numbers: [], t: [], columns: data.quantities.map(() => [])};
  for (let i = 0; i < values.length; i++)
    if (!loop.set(i, values[i])) return {...found, fault: "There is no run: " + words()};
  const begin = performance.now();
  const count = loop.run(0, data.until);
  found.milliseconds = performance.now() - begin;
  const width = data.quantities.length + 1;
  const rows = new Float64Array(loop.memory.buffer, loop.rows(), count * width);
  found.t = Float64Array.from({length: count}, (_, k) => rows[k * width]);
  found.columns = data.quantities.map((_, i) =>
    Float64Array.from({length: count}, (_, k) => rows[k * width + 1 + i]));
  found.eventCount = loop.event_count();
  const noted = new Float64Array(loop.memory.buffer, loop.noted(), 4 * loop.noted_count());
  const isNoted = (t, clock) => noted.some((_, k) => k % 4 === 0 && noted[k] === t && noted[k + 1] === 2 && noted[k + 2] === clock);
  for (let k = 0; k < noted.length; k += 4) {
    const named = data.events[noted[k + 1]][noted[k + 2]], t = noted[k], isTimed = noted[k + 1] === 2;
    if (isTimed && (!named.told || named.needs.some(clock => isNoted(t, clock)))) found.eventCount -= 1;
    else found.events.push({t, isTimed, name: named.name, after: wordsOf(named, noted[k + 3])});
  }
  if (count <= data.grid) return {...found, fault: "The run ends early: " + words()};
  const most = Math.max(0, ...data.numbers.flatMap(n => n.places.flatMap(p => [p.column, p.happened])),
    ...data.ranges.flatMap(r => [r.high, r.low]));
  const taken = new Float64Array(loop.memory.buffer, loop.taken(), most + 1);
  found.numbers = data.numbers.map(rule => numberOf(rule, taken));
  for (const range of data.ranges) {
    const slack = 1e-9 * Math.max(Math.abs(range.from), Math.abs(range.to));
    const isIn = taken[range.high] <= range.to + slack && -taken[range.low] >= range.from - slack;
    if (!isIn) found.fault = range.words;
  }
  return found;
}

function words() {
  const memory = new Uint8Array(loop.memory.buffer), from = loop.message();
  return new TextDecoder().decode(memory.subarray(from, memory.indexOf(0, from)));
}

function draw() {
  for (const panel of panels) panel.draw(shown, model, [0, data.until]);
}

function rowOf(table, cells) {
  const row = table.insertRow();
  cells.forEach((text, i) => {
    const cell = row.insertCell();
    cell.textContent = text;
    if (i === 1) cell.className = "n";
  });
}

function tell(found) {
  const numbers = place("numbers"), events = place("events");
  numbers.replaceChildren();
  data.numbers.forEach((rule, i) => {
    const value = found.numbers[i];
    const text = value === undefined ? "-" : Number.isNaN(value) ? "does not happen" : amount(value, rule.unit, 6);
    rowOf(numbers, [rule.text, text]);
  });
  events.replaceChildren();
  for (const event of found.events.slice(0, SHOWN)) rowOf(events, [event.name + ": " + event.after, told(event.t, 6) + " s"]);
  if (found.eventCount > SHOWN) rowOf(events, [found.eventCount - SHOWN + " more", ""]);
  if (!found.events.length) rowOf(events, ["none", ""]);
  for (const [part, {head, unit, value}] of Object.entries(data.parts)) {
    const drawn = document.getElementById("s-value of " + part)?.querySelector("text");
    if (!drawn) continue;
    const sum = value?.powers.reduce((product, [i, k]) => product * values[i] ** k, value.factor);
    drawn.textContent = value ? head + short(sum, unit) : "";
  }
}

function show() {
  isDue = false;
  const begin = performance.now(), found = computed();
  place("fault").textContent = found.fault;
  shown = found;
  tell(found);
  draw();
  const passed = performance.now() - begin;
  place("state").textContent = found.milliseconds === undefined ? ""
    : "run computed in " + told(found.milliseconds, 2) + " ms, page drawn in " + told(passed, 2) + " ms";
  place("link").href = link();
}

function due() {
  if (!isDue) requestAnimationFrame(show);
  isDue = true;
}

const inside = each => each.is_ratio ? Math.log : value => value;

function addSlider(each) {
  const {name, unit} = data.parameters[each.place], root = document.createElement("div");
  root.className = "slider";
  root.innerHTML = "<label><div><b></b><output></output></div><small></small><input type=range step=any></label>";
  root.querySelector("b").textContent = name;
  root.querySelector("small").textContent = each.text;
  const input = root.querySelector("input"), output = root.querySelector("output");
  const scale = inside(each);
  input.min = scale(each.low);
  input.max = scale(each.high);
  input.step = (input.max - input.min) / 400;
  const own = {place: each.place, each, write() {
    input.value = scale(values[each.place]);
    output.textContent = amount(values[each.place], unit);
  }};
  input.addEventListener("input", () => {
    const at = Number(input.value), moved = each.is_ratio ? Math.exp(at) : at;
    values[each.place] = Math.min(Math.max(moved, each.low), each.high);
    output.textContent = amount(values[each.place], unit);
    due();
  });
  own.write();
  sliders.push(own);
  place("sliders").append(root);
}

function setAll(given) {
  for (const [at, value] of given) values[at] = value;
  for (const own of sliders) own.write();
  due();
}

function link() {
  const changed = data.parameters.flatMap((p, i) =>
    values[i] === p.value ? [] : [encodeURIComponent(p.name) + "=" + values[i]]);
  return "#" + changed.join("&");
}

/* Parameters of the link. */
function followLink() {
  const given = new Map(data.parameters.map((p, i) => [i, p.value]));
  try {
    for (const pair of location.hash.slice(1).split("&").filter(Boolean)) {
      const [name, text] = pair.split("=").map(decodeURIComponent);
      for (const [at, value] of readParameters(JSON.stringify({[name]: text}), data.parameters)) given.set(at, value);
    }
    setAll(given);
  } catch (fault) {
    place("fault").textContent = "The link cannot be followed. " + fault.message;
  }
}

const panels = data.panels.map(columns => new Panel(place("panels"), data.quantities, columns));
place("title").textContent = document.title;
data.sliders.forEach(addSlider);
place("reset").addEventListener("click", () => setAll(data.parameters.map((p, i) => [i, p.value])));
place("save").addEventListener("click", () => {
  const file = new Blob([parameterFile(data.name, data.parameters, values)], {type: "text/plain"});
  const save = document.createElement("a");
  save.href = URL.createObjectURL(file);
  save.download = "parameters.toml";
  save.click();
});
place("load").addEventListener("change", async event => {
  const file = event.target.files[0];
  if (!file) return;
  try {
    setAll(readParameters(await file.text(), data.parameters));
  } catch (fault) {
    place("fault").textContent = "The file cannot be read. " + fault.message;
  }
  event.target.value = "";
});
window.addEventListener("hashchange", followLink);
window.addEventListener("resize", draw);

WebAssembly.instantiate(bytes(place("code").textContent), {}).then(made => {
  loop = made.instance.exports;
  loop._initialize();
  model = computed();
  followLink();
}).catch(fault => { place("fault").textContent = "This browser cannot run the model: " + fault; });
