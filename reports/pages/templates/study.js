// The study's lists of instances and runs, and the panel in which one of them opens. Needs page.js.
const data = JSON.parse(document.getElementById("data").textContent);
const PAGE = 50;

const number = (value, digits = 6) =>
  value === null || value === undefined ? dash : Number(value).toLocaleString("en", { maximumSignificantDigits: digits });
const percent = (value) => {
  if (value === null || value === undefined) return dash;
  const p = 100 * value;
  return Math.abs(p) < 5e-5 ? "0 %" : Math.abs(p) < 0.005 ? "< 0.01 %" : (Math.abs(p) < 10 ? p.toFixed(2) : p.toFixed(1)) + " %";
};
const seconds = (value) => (value === null || value === undefined ? dash : value >= 100 ? Math.round(value).toLocaleString("en") : value >= 10 ? value.toFixed(1) : value >= 0.1 ? value.toFixed(2) : value > 0 && value < 0.0005 ? "< 0.001" : value.toFixed(3));

// ---- lists: rows that are in the page, filtered, sorted and opened; fifty at a time ---------------------------------
// entries: { row, … } in the order of the table's rows. filters: { label, of: entry → text }. name: in the address; none in a panel.
const list = (table, { name = "", entries, filters, open }) => {
  let shown = PAGE, order = entries;
  const id = name || "own-list", heads = [...table.tHead.rows[0].cells];
  const words = heads.map((head, i) => (head.classList.contains("left") ? i : -1)).filter((i) => i >= 0);
  const told = new Map(entries.map((entry) => [entry, words.map((i) => entry.row.cells[i].textContent).join(" ").toLowerCase()]));
  const search = make("input", { type: "search", id: `${id}-search`, placeholder: "name, method, …", autocomplete: "off" });
  const selects = filters.map(({ label, of }) => {
    const select = make("select", { id: `${id}-${label.toLowerCase()}` }, make("option", { value: "" }, "all"));
    [...new Set(entries.map(of))].sort(compare).forEach((value) => select.append(make("option", { value }, value)));
    return { select, of, label };
  });
  const count = make("output", { "aria-live": "polite" });
  const bar = make("div", { class: "filters" }, make("label", {}, "Search", search),
    ...selects.map(({ select, label }) => make("label", {}, label, select)), count);
  const more = make("button", { type: "button", class: "more", onclick: () => { shown += 4 * PAGE; show(); } }, "Show more");

  const opening = (entry) => {
    const cell = entry.row.cells[0];
    if (entry.row.className !== "opens") {
      const button = make("button", { type: "button" }, ...cell.childNodes);
      cell.append(button);
      entry.row.className = "opens";
      entry.row.addEventListener("click", () => { button.focus(); open(entry); });
    }
    return entry.row;
  };
  const show = () => {
    const wanted = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const kept = order.filter((entry) => wanted.every((word) => told.get(entry).includes(word)) &&
      selects.every(({ select, of }) => select.value === "" || of(entry) === select.value));
    table.tBodies[0].replaceChildren(...kept.slice(0, shown).map(opening));
    count.textContent = `${Math.min(shown, kept.length).toLocaleString("en")} of ${kept.length.toLocaleString("en")} shown` +
      (kept.length < entries.length ? ` (${entries.length.toLocaleString("en")} in all)` : "");
    more.hidden = kept.length <= shown;
  };
  const valueOf = (entry, column) => {
    const exact = entry[heads[column].dataset.key];
    return typeof exact === "number" ? exact : shownValue(entry.row.cells[column]);
  };
  const fields = [[search, "search"], ...selects.map(({ select, label }) => [select, label.toLowerCase()])];
  for (const [field, key] of fields) field.addEventListener("input", () => {
    shown = PAGE;
    if (name) tell(`${name}.${key}`, field.value);
    show();
  });
  table.parentElement.before(bar);
  table.parentElement.after(more);
  sortable(table, (column, descending) => {
    order = column < 0 ? entries : sorted(entries, (entry) => valueOf(entry, column), descending);
    show();
  }, name);
  show();
  if (name) keep((said) => {
    const changed = fields.filter(([field, key]) => field.value !== (said.get(`${name}.${key}`) ?? ""));
    changed.forEach(([field, key]) => { field.value = said.get(`${name}.${key}`) ?? ""; });
    if (changed.length) show(); // else the rows stay as they are, and the focus in them
  });
};

// ---- what the rows stand for ----------------------------------------------------------------------------------------
const rowsOf = (id) => [...document.getElementById(id).tBodies[0].rows];
const instances = rowsOf("instance-list-table").map((row, index) =>
  ({ row, index, ...Object.fromEntries(Object.entries(data.instances).map(([key, values]) => [key, values[index]])) }));
const runHeads = [...document.getElementById("run-list-table").tHead.rows[0].cells];
const runPlace = Object.fromEntries(runHeads.map((head, i) => [head.dataset.key, i]));
// what the list says of a run, with its unit
const said = (run, key) => {
  if (!(key in runPlace)) return dash;
  const text = run.row.cells[runPlace[key]].textContent, unit = runHeads[runPlace[key]].dataset.unit;
  return text === dash || !unit ? text : `${text} ${unit}`;
};
const runs = rowsOf("run-list-table").map((row, index) => {
  const run = { row, index, on: instances[data.runs.instance[index]] };
  [run.value, run.bound] = data.details[index]?.end ?? ["value", "bound"].map((key) => shownValue(row.cells[runPlace[key]]));
  for (const key of ["method", "seed", "status"]) run[key] = said(run, key);
  return run;
});
// label in the address → what it opens: an instance by its digest, a run by what tells it from the others
const entries = new Map(instances.map((instance) => [instance.digest, instance]));
for (const run of runs) {
  const label = [run.on.digest, run.method, run.seed, said(run, "time_limit").split(" ")[0]].join("~");
  run.label = label;
  for (let k = 2; entries.has(run.label); k++) run.label = `${label}~${k}`;
  entries.set(run.label, run);
}
const go = (entry) => openPanel(entry.label ?? entry.digest);

list(document.getElementById("instance-list-table"), {
  name: "instance-list", entries: instances, open: go,
  filters: [{ label: "Family", of: (r) => r.family }, { label: "Proved", of: (r) => r.proved }],
});
list(document.getElementById("run-list-table"), {
  name: "run-list", entries: runs, open: go,
  filters: [{ label: "Method", of: (r) => r.method }, { label: "Status", of: (r) => r.status }, { label: "Family", of: (r) => r.on.family }],
});

// ---- drawings ---------------------------------------------------------------------------------------------------
const ticks = (low, high, count = 5) => {
  const step = 10 ** Math.floor(Math.log10((high - low) / count)), ratio = (high - low) / count / step;
  const nice = step * (ratio > 5 ? 10 : ratio > 2 ? 5 : ratio > 1 ? 2 : 1), found = [];
  for (let k = Math.ceil(low / nice - 1e-9); k * nice <= high + 1e-9 * nice; k++) found.push(k * nice);
  return found;
};
const text = (x, y, words, attributes = {}) => draw("text", { x, y, "font-size": 12, fill: "currentColor", ...attributes }, words);

const drawRoutes = (places, instance, routes) => {
  const W = 520, H = 420, pad = 18;
  const rings = data.walls[instance.index] || [], all = [...places, ...rings.flat()];
  const xs = all.map((p) => p[0]), ys = all.map((p) => p[1]);
  const x0 = Math.min(...xs), y0 = Math.min(...ys), w = Math.max(...xs) - x0 || 1, h = Math.max(...ys) - y0 || 1;
  const scale = Math.min((W - 2 * pad) / w, (H - 2 * pad) / h);
  const put = ([x, y]) => [pad + (x - x0) * scale, pad + h * scale - (y - y0) * scale], at = (i) => put(places[i]);
  const svg = draw("svg", { viewBox: `0 0 ${(w * scale + 2 * pad).toFixed(0)} ${(h * scale + 2 * pad).toFixed(0)}`, role: "img", "aria-label": `Routes of ${routes.filter((r) => r.length).length} UAVs on the map` });
  const outline = rings.map((ring) => "M" + ring.map((p) => put(p).map((v) => v.toFixed(1)).join(",")).join("L") + "Z").join("");
  if (outline) svg.append(draw("path", { d: outline, fill: "var(--wash)", stroke: "var(--faint)", "fill-rule": "evenodd" }));
  const winds = data.winds[instance.index] || [], fastest = Math.max(...winds.map((w) => Math.hypot(w[2], w[3])));
  for (const [x, y, u, v] of winds) {
    const [a, b] = put([x, y]), size = 22 / fastest, ends = [a - u * size / 2, b + v * size / 2, a + u * size / 2, b - v * size / 2].map((c) => c.toFixed(1));
    svg.append(draw("line", { x1: ends[0], y1: ends[1], x2: ends[2], y2: ends[3], stroke: "var(--faint)", "stroke-width": 1 }));
    svg.append(draw("circle", { cx: ends[2], cy: ends[3], r: 1.6, fill: "var(--faint)" }));
  }
  routes.forEach((route, k) => {
    if (!route.length) return;
    const stops = [instance.n_tasks + k, ...route, instance.n_tasks + k].map(at), colour = data.colours[k % data.colours.length];
    svg.append(draw("polyline", { points: stops.map((p) => p.map((v) => v.toFixed(1)).join(",")).join(" "), fill: "none", stroke: colour, "stroke-width": 1.8, "stroke-linejoin": "round" }));
    if (instance.n_tasks < 300) stops.slice(1).forEach(([x, y], i) => {
      const [a, b] = stops[i], length = Math.hypot(x - a, y - b);
      if (length < 14) return;
      const ux = (x - a) / length, uy = (y - b) / length, mx = a + 0.56 * (x - a), my = b + 0.56 * (y - b);
      svg.append(draw("polygon", { fill: colour, points: [[mx + 5 * ux, my + 5 * uy], [mx - 3 * ux - 3.2 * uy, my - 3 * uy + 3.2 * ux], [mx - 3 * ux + 3.2 * uy, my - 3 * uy - 3.2 * ux]].map((p) => p.map((v) => v.toFixed(1)).join(",")).join(" ") }));
    });
  });
  const r = Math.max(1, 3.4 - instance.n_tasks / 150);
  for (let i = 0; i < instance.n_tasks; i++) { const [cx, cy] = at(i); svg.append(draw("circle", { cx: cx.toFixed(1), cy: cy.toFixed(1), r, fill: "currentColor" })); }
  for (let k = 0; k < instance.n_depots; k++) { const [x, y] = at(instance.n_tasks + k); svg.append(draw("rect", { x: (x - 6).toFixed(1), y: (y - 6).toFixed(1), width: 12, height: 12, fill: data.colours[k % data.colours.length], stroke: "var(--paper)", "stroke-width": 1.5 })); }
  const notes = [
    ...(winds.length ? [`Grey: the wind, towards the dot, up to ${number(fastest, 2)} m/s.`] : []),
    ...(outline ? ["Stops are joined by straight lines here; around walls the UAVs fly by the corners."] : []),
  ];
  return notes.length ? make("div", {}, svg, make("p", { class: "soft" }, notes.join(" "))) : svg;
};

const drawTours = (tours) => {
  const top = Math.max(...tours) || 1, row = 20, kept = tours.slice(0, 40);
  const svg = draw("svg", { viewBox: `0 0 420 ${kept.length * row + 24}`, role: "img", "aria-label": `Cost of each tour: ${kept.map((c) => number(c)).join(", ")} seconds` });
  kept.forEach((cost, k) => {
    const width = 280 * cost / top;
    svg.append(draw("rect", { x: 46, y: k * row + 3, width, height: row - 6, fill: data.colours[k % data.colours.length] }));
    svg.append(text(40, k * row + 14, `UAV ${k}`, { "text-anchor": "end" }), text(52 + width, k * row + 14, cost ? `${number(cost)} s` : "stays home"));
  });
  if (tours.length > kept.length) svg.append(text(46, kept.length * row + 14, `… and ${tours.length - kept.length} more`));
  return svg;
};

// The ends of an axis for values that come over time: those from a third of the (logarithmic) time on, where all of them,
// first routes and first bounds included, would squeeze these into less than a third of the axis.
const ends = (lines, from) => {
  const all = [], late = [];
  for (const { trace, bounds } of lines) for (const k of bounds ? [1, 2] : [1]) {
    let last = null;
    for (const p of trace) if (p[k] !== null) {
      if (p[0] >= from) late.push(p[k], last ?? p[k]);
      all.push(last = p[k]);
    }
    if (last !== null) late.push(last);
  }
  const span = (values) => [Math.min(...values), Math.max(...values)];
  if (!all.length) return null;
  const [low, high] = span(all), [lowLate, highLate] = span(late);
  return high - low > 3 * (highLate - lowLate) && highLate > lowLate ? { low: lowLate, high: highLate, before: [low, high] } : { low, high };
};

// lines: [{ trace, colour, dashes, bounds }] of one instance, step functions of time up to `limit` [s]
const drawTrace = (lines, limit, label) => {
  const W = 520, H = 300, left = 62, right = 12, top = 12, bottom = 40;
  const times = lines.flatMap(({ trace }) => trace.map((p) => p[0])).filter((t) => t > 0);
  const first = Math.min(Math.max(Math.min(...times, limit / 10), 1e-3), limit / 10), span = Math.log(limit / first) || 1;
  const found = ends(lines, first * Math.exp(span / 3));
  if (!found) return make("p", { class: "soft" }, "No trace: the run reported nothing on its way.");
  let { low, high } = found;
  const slack = (high - low || Math.abs(high) || 1) * 0.06; low -= slack; high += slack;
  const x = (t) => left + (W - left - right) * Math.max(0, Math.min(1, Math.log(Math.max(t, first) / first) / span));
  const y = (v) => top + (H - top - bottom) * Math.max(0, Math.min(1, (high - v) / (high - low)));
  const svg = draw("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": label });
  for (const v of ticks(low, high)) svg.append(draw("line", { x1: left, x2: W - right, y1: y(v), y2: y(v), stroke: "var(--faint)", "stroke-width": 0.5 }), text(left - 6, y(v) + 4, number(v, 6), { "text-anchor": "end" }));
  for (let e = Math.ceil(Math.log10(first)); e <= Math.log10(limit); e++) svg.append(draw("line", { x1: x(10 ** e), x2: x(10 ** e), y1: top, y2: H - bottom, stroke: "var(--faint)", "stroke-width": 0.5 }), text(x(10 ** e), H - bottom + 16, number(10 ** e), { "text-anchor": "middle" }));
  svg.append(text((left + W - right) / 2, H - 6, "time [s], logarithmic", { "text-anchor": "middle" }));
  const steps = (trace, k) => {
    let path = "", last = null;
    for (const p of trace) if (p[k] !== null) { path += last === null ? `M${x(p[0]).toFixed(1)},${y(p[k]).toFixed(1)}` : `H${x(p[0]).toFixed(1)}V${y(p[k]).toFixed(1)}`; last = p[k]; }
    return last === null ? "" : path + `H${x(limit).toFixed(1)}`;
  };
  for (const { trace, colour, dashes, bounds } of lines) {
    svg.append(draw("path", { d: steps(trace, 1), fill: "none", stroke: colour, "stroke-width": 2, "stroke-dasharray": dashes || "" }));
    if (bounds && steps(trace, 2)) svg.append(draw("path", { d: steps(trace, 2), fill: "none", stroke: colour, "stroke-width": 1.4, "stroke-dasharray": "2 3" }));
  }
  if (!found.before) return svg;
  const [least, most] = found.before.map((v) => number(v, 4));
  return make("div", {}, svg, make("p", { class: "soft" }, `The axis is cut where the first values, ${least} to ${most} s in all, would flatten the rest.`));
};

// ---- the panel ----------------------------------------------------------------------------------------------------
const heading = make("h2", { id: "panel-h", tabindex: "-1", autofocus: "" }), body = make("div", { class: "body", id: "panel-body" });
const panel = make("dialog", { id: "panel", "aria-labelledby": "panel-h" },
  make("header", {}, heading, make("button", { type: "button", id: "panel-close", onclick: () => panel.close() }, "Close")), body);
document.body.append(panel);
panel.addEventListener("click", (event) => { if (event.target === panel) panel.close(); });
// Closed by its button, Escape or a click beside it: back to the page as it was before the first panel opened.
panel.addEventListener("close", () => {
  const panels = history.state?.panels ?? 0;
  if (!readAddress().said.has("open")) return;
  if (panels > 0) history.go(-panels); else tell("open", null);
});
const openPanel = (label) => {
  writeAddress(({ said }) => said.set("open", label), "panel");
  showPanel(label);
};
const showPanel = (label) => {
  const entry = entries.get(label);
  if (!entry) { panel.close(); return; }
  const { title, parts, then } = entry.digest ? aboutInstance(entry) : aboutRun(entry);
  heading.textContent = title;
  body.replaceChildren(...parts);
  if (panel.open) heading.focus(); else panel.showModal();
  panel.scrollTop = 0;
  then?.();
  body.querySelectorAll(".scroll, pre").forEach((box) => watching.observe(box));
};
const facts = (pairs) => make("dl", {}, ...pairs.filter(([, v]) => v !== null && v !== "" && v !== undefined).flatMap(([k, v]) => [make("dt", {}, k), make("dd", {}, v)]));
const part = (title, ...content) => make("section", {}, make("h3", {}, title), ...content);
const limitOf = (run) => Number(said(run, "time_limit").replace(/,| .*/g, ""));

const aboutRun = (run) => {
  const detail = data.details[run.index], instance = run.on, parts = [];
  const back = make("button", { type: "button", onclick: () => go(instance) }, `All runs on ${instance.instance}`);
  const memory = data.runs.megabytes[run.index], stopped = said(run, "stopped_by");
  parts.push(make("p", {}, back));
  parts.push(facts([
    ["Instance", `${instance.instance} (${instance.family}, n = ${instance.n_tasks}, m = ${instance.n_depots}, digest ${instance.digest})`],
    ["Status", `${run.status}${[dash, ""].includes(stopped) ? "" : `, stopped by ${stopped}`}`], ["Message", detail && detail.message],
    ["Longest tour", run.value === null ? "none, or its stated cost is wrong" : `${number(run.value, 9)} s`],
    ["Lower bound", run.bound === null ? null : `${number(run.bound, 9)} s`],
    ["Gap", `to best found ${said(run, "gap_found")}, to best bound ${said(run, "gap_bound")}${instance.bound_by ? ` (claimed by ${instance.bound_by})` : ""}`],
    ["Time", `${said(run, "elapsed")} of ${said(run, "time_limit")}` + (detail ? `; start and compilation ${seconds(detail.times[0])} s, processor ${seconds(detail.times[2])} s` : "")],
    ["Peak memory", memory === null ? null : `${Math.round(memory)} MB`],
    ["Options", detail && (detail.options || "all at their defaults")],
    ["Figures of the method", detail && detail.statistics],
    ["File", detail && detail.file],
  ]));
  if (!detail) parts.push(make("p", { class: "soft" }, "Routes, trace and log of this run are not embedded in this page (it keeps those of the best runs); they are in the store."));
  else {
    const drawings = [], beside = make("div"), map = data.maps[instance.index];
    if (detail.routes && map) drawings.push(part("Routes", drawRoutes(map, instance, detail.routes)));
    drawings.push(beside);
    if (detail.tours.length) beside.append(part("Cost of each tour", drawTours(detail.tours)));
    const colour = data.styles[run.method][0];
    beside.append(part("Trace: longest tour (solid) and bound (dotted) [s]", drawTrace([{ trace: detail.trace, colour, bounds: true }], limitOf(run), "Objective and bound over time")));
    parts.push(make("div", { class: "pair" }, ...drawings));
    if (detail.routes) parts.push(make("details", {}, make("summary", {}, "Routes as task numbers"), make("pre", {}, detail.routes.map((r, k) => `UAV ${k}: ${r.join(" ") || "stays home"}`).join("\n"))));
    if (detail.log) parts.push(make("details", {}, make("summary", {}, "End of its output"), make("pre", {}, detail.log)));
  }
  return { title: `${run.method}, seed ${run.seed}, on ${instance.instance}`, parts };
};

// the runs of one instance as a list of their own, without the column that names it
const ownList = (own) => {
  const table = make("table", { id: "own-list-table" }, make("thead", {}, make("tr")), make("tbody"));
  table.className = document.getElementById("run-list-table").className.replace(/\bl(\d+)\b/g, (_, k) => `l${k - 1}`);
  table.tHead.rows[0].append(...runHeads.slice(1).map((head) => {
    const copy = make("th", { scope: "col", class: head.className || null, title: head.title || null, "data-key": head.dataset.key }, head.textContent);
    return copy;
  }));
  const copies = own.map((run) => {
    const row = make("tr", {}, ...[...run.row.cells].slice(1).map((cell) => make("td", { class: cell.className || null }, cell.textContent)));
    return { row, run, value: run.value, bound: run.bound };
  });
  table.tBodies[0].append(...copies.map(({ row }) => row));
  return { box: make("div", { class: "list" }, make("div", { class: "scroll" }, table)), table, copies };
};

const aboutInstance = (instance) => {
  const own = runs.filter((r) => r.on === instance), elapsed = (r) => shownValue(r.row.cells[runPlace.elapsed]) ?? Infinity;
  const better = (a, b) => (a.value ?? Infinity) - (b.value ?? Infinity) || elapsed(a) - elapsed(b);
  const ordered = [...own].sort(better), best = ordered.find((r) => data.details[r.index] && data.details[r.index].routes);
  const parts = [facts([
    ["What", `${instance.family}, n = ${instance.n_tasks} tasks, m = ${instance.n_depots} UAVs, cost asymmetry ${percent(instance.asymmetry)}, digest ${instance.digest}`],
    ["Best known", instance.best_known === null ? null : `${number(instance.best_known, 9)} s`],
    ["Best found", instance.best_found === null ? "nothing" : `${number(instance.best_found, 9)} s, first by ${instance.best_method}`],
    ["Best bound", instance.best_bound === null ? "none" : `${number(instance.best_bound, 9)} s, claimed by ${instance.bound_by}, gap left ${percent(instance.gap)}${instance.proved === "proved" ? ", proved optimal" : ""}`],
  ])];
  const drawings = [], map = data.maps[instance.index];
  if (best && map) drawings.push(part(`Best routes (${best.method}, seed ${best.seed})`, drawRoutes(map, instance, data.details[best.index].routes)));
  const seen = new Set(), lines = [];
  for (const run of ordered) if (!seen.has(run.method) && data.details[run.index]) {
    seen.add(run.method);
    lines.push({ trace: data.details[run.index].trace, colour: data.styles[run.method][0], dashes: data.styles[run.method][1], method: run.method });
  }
  if (lines.length) {
    const legend = make("p", { class: "soft" }, ...lines.flatMap((l) => {
      const key = draw("svg", { class: "key", viewBox: "0 0 30 10", "aria-hidden": "true" }, draw("line", { x1: 0, x2: 30, y1: 5, y2: 5, stroke: l.colour, "stroke-width": 3.5, "stroke-dasharray": l.dashes }));
      return [key, `${l.method}   `];
    }));
    drawings.push(part("Longest tour over time, best run of each method [s]", drawTrace(lines, Math.max(...own.map(limitOf)), "Objective over time of each method"), legend));
  }
  parts.push(make("div", { class: "pair" }, ...drawings));
  const { box, table, copies } = ownList(ordered);
  parts.push(part("Runs", box));
  return { title: instance.instance, parts, then: () => list(table, { entries: copies, filters: [], open: ({ run }) => go(run) }) };
};

keep((address) => showPanel(address.get("open")));
