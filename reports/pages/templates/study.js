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
// ---- lists made from the data: filter, sort, open; fifty rows at a time -------------------------------------------
const list = (place, { name, columns, rows, filters, open }) => {
  let shown = PAGE, column = null, way = "ascending";
  const search = make("input", { type: "search", id: `${name}-search`, placeholder: "name, method, …", autocomplete: "off" });
  const selects = filters.map(({ label, of, values }) => {
    const select = make("select", { id: `${name}-${label.toLowerCase()}` }, make("option", { value: "" }, "all"));
    values.forEach((value) => select.append(make("option", { value }, String(value))));
    return { select, of, label };
  });
  const count = make("output", { "aria-live": "polite" });
  const bar = make("div", { class: "filters" }, make("label", {}, "Search", search),
    ...selects.map(({ select, label }) => make("label", {}, label, select)), count);
  const body = make("tbody");
  const heads = columns.map((c) => make("th", { scope: "col", title: c.meaning || null, class: c.text ? "left" : null }, c.heading));
  const table = make("table", { id: `${name}-table` }, make("thead", {}, make("tr", {}, ...heads)), body);
  const more = make("button", { type: "button", class: "more", onclick: () => { shown += 4 * PAGE; show(); } }, "Show more");
  const texts = rows.map((row) => columns.filter((c) => c.text).map((c) => c.of(row)).join(" ").toLowerCase());

  const chosen = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const kept = rows.map((_, i) => i).filter((i) => words.every((w) => texts[i].includes(w)) &&
      selects.every(({ select, of }) => select.value === "" || String(of(rows[i])) === select.value));
    if (column) {
      const sign = way === "ascending" ? 1 : -1;
      kept.sort((a, b) => {
        const x = column.of(rows[a]), y = column.of(rows[b]);
        return x === null || y === null ? compare(x, y) : sign * compare(x, y);
      });
    }
    return kept;
  };
  const show = () => {
    const kept = chosen();
    body.replaceChildren(...kept.slice(0, shown).map((i) => {
      const row = rows[i];
      const cells = columns.map((c, j) => {
        const text = c.write(c.of(row));
        const cell = make("td", { class: [c.text ? "left" : "", c.mark(row)].join(" ").trim() || null });
        cell.append(j === 0 ? make("button", { type: "button" }, text) : text);
        return cell;
      });
      return make("tr", { class: "opens", onclick: () => open(row) }, ...cells);
    }));
    count.textContent = `${Math.min(shown, kept.length).toLocaleString("en")} of ${kept.length.toLocaleString("en")} shown` +
      (kept.length < rows.length ? ` (${rows.length.toLocaleString("en")} in all)` : "");
    more.hidden = kept.length <= shown;
  };
  heads.forEach((head, i) => sortable(head, (to) => { column = columns[i]; way = to; setSorted(heads, head, to); show(); }));
  const changed = () => { shown = PAGE; show(); };
  search.addEventListener("input", changed);
  selects.forEach(({ select }) => select.addEventListener("change", changed));
  place.append(bar, make("div", { class: "scroll" }, table), more);
  show();
};

// rows of a table that comes column by column
const rowsOf = (table) => Object.values(table)[0].map((_, index) =>
  ({ index, ...Object.fromEntries(Object.entries(table).map(([key, values]) => [key, values[index]])) }));
const instances = rowsOf(data.instances);
const runs = rowsOf(data.runs).map((run) => ({
  ...run, on: instances[run.instance], instance: instances[run.instance].instance,
  method: data.methods[run.method], status: data.statuses[run.status],
}));
const columnsOf = (described) => described.map(([key, heading, kind, meaning]) => ({
  heading, meaning, key, text: kind === "text", write: { number, percent, seconds }[kind] || ((value) => value ?? dash),
  of: (row) => row[key], mark: (row) => (key === "status" && ["ERROR", "KILLED"].includes(row[key]) ? "bad" : ""),
}));
const runColumns = columnsOf(data.columns.runs);

list(document.getElementById("instances-list"), {
  name: "instance-list", rows: instances, open: (row) => openInstance(row), columns: columnsOf(data.columns.instances),
  filters: [
    { label: "Family", of: (r) => r.family, values: data.families },
    { label: "Proved", of: (r) => r.proved, values: ["proved", "open"] },
  ],
});
list(document.getElementById("runs-list"), {
  name: "run-list", rows: runs, open: (row) => openRun(row), columns: runColumns,
  filters: [
    { label: "Method", of: (r) => r.method, values: data.methods },
    { label: "Status", of: (r) => r.status, values: [...new Set(runs.map((r) => r.status))].sort(compare) },
    { label: "Family", of: (r) => r.on.family, values: data.families },
  ],
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
  if (!outline) return svg;
  return make("div", {}, svg, make("p", { class: "soft" }, "Stops are joined by straight lines here; around walls the UAVs fly by the corners."));
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

// lines: [{ trace, colour, dashes, bounds }] of one instance, step functions of time up to `limit` [s]
const drawTrace = (lines, limit, label) => {
  const W = 520, H = 300, left = 62, right = 12, top = 12, bottom = 40;
  const all = lines.flatMap(({ trace, bounds }) => trace.flatMap((p) => (bounds ? [p[1], p[2]] : [p[1]]))).filter((v) => v !== null);
  if (!all.length) return make("p", { class: "soft" }, "No trace: the run reported nothing on its way.");
  let low = Math.min(...all), high = Math.max(...all);
  const slack = (high - low || Math.abs(high) || 1) * 0.06; low -= slack; high += slack;
  const times = lines.flatMap(({ trace }) => trace.map((p) => p[0])).filter((t) => t > 0);
  const first = Math.min(Math.max(Math.min(...times, limit / 10), 1e-3), limit / 10), span = Math.log(limit / first) || 1;
  const x = (t) => left + (W - left - right) * Math.max(0, Math.min(1, Math.log(Math.max(t, first) / first) / span));
  const y = (v) => top + (H - top - bottom) * (high - v) / (high - low);
  const svg = draw("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": label });
  for (const v of ticks(low, high)) svg.append(draw("line", { x1: left, x2: W - right, y1: y(v), y2: y(v), stroke: "var(--line)" }), text(left - 6, y(v) + 4, number(v, 6), { "text-anchor": "end" }));
  for (let e = Math.ceil(Math.log10(first)); e <= Math.log10(limit); e++) svg.append(draw("line", { x1: x(10 ** e), x2: x(10 ** e), y1: top, y2: H - bottom, stroke: "var(--line)" }), text(x(10 ** e), H - bottom + 16, number(10 ** e), { "text-anchor": "middle" }));
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
  return svg;
};
// the trace with the end of the run appended
const wholeTrace = (run) => {
  const detail = data.details[run.index];
  if (!detail) return [];
  return run.value === null && run.bound === null ? detail.trace : [...detail.trace, [run.elapsed, run.value, run.bound]];
};

// ---- the panel ----------------------------------------------------------------------------------------------------
const heading = make("h2", { id: "panel-h" }), body = make("div", { class: "body", id: "panel-body" });
const panel = make("dialog", { id: "panel", "aria-labelledby": "panel-h" },
  make("header", {}, heading, make("button", { type: "button", id: "panel-close", onclick: () => panel.close() }, "Close")), body);
document.body.append(panel);
panel.addEventListener("click", (event) => { if (event.target === panel) panel.close(); });
const open = (title, ...content) => {
  heading.textContent = title;
  body.replaceChildren(...content);
  if (!panel.open) panel.showModal();
  panel.scrollTop = 0;
};
const facts = (pairs) => make("dl", {}, ...pairs.filter(([, v]) => v !== null && v !== "" && v !== undefined).flatMap(([k, v]) => [make("dt", {}, k), make("dd", {}, v)]));
const part = (title, ...content) => make("section", {}, make("h3", {}, title), ...content);

const openRun = (run) => {
  const detail = data.details[run.index], instance = run.on, parts = [];
  const back = make("button", { type: "button", onclick: () => openInstance(instance) }, `All runs on ${instance.instance}`);
  parts.push(make("p", {}, back));
  parts.push(facts([
    ["Instance", `${instance.instance} (${instance.family}, n = ${instance.n_tasks}, m = ${instance.n_depots}, digest ${instance.digest})`],
    ["Status", `${run.status}${run.stopped_by ? `, stopped by ${run.stopped_by}` : ""}`], ["Message", detail && detail.message],
    ["Longest tour", run.value === null ? "none, or its stated cost is wrong" : `${number(run.value, 9)} s`],
    ["Lower bound", run.bound === null ? null : `${number(run.bound, 9)} s`],
    ["Gap", `to best found ${percent(run.gap_found)}, to best bound ${percent(run.gap_bound)}${instance.bound_by ? ` (claimed by ${instance.bound_by})` : ""}`],
    ["Time", `${seconds(run.elapsed)} s of ${number(run.time_limit)} s` + (detail ? `; start and compilation ${seconds(detail.times[0])} s, processor ${seconds(detail.times[2])} s` : "")],
    ["Peak memory", run.peak_memory === null ? null : `${Math.round(run.peak_memory / 1e6)} MB`],
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
    beside.append(part("Trace: longest tour (solid) and bound (dotted) [s]", drawTrace([{ trace: wholeTrace(run), colour, bounds: true }], run.time_limit, "Objective and bound over time")));
    parts.push(make("div", { class: "pair" }, ...drawings));
    if (detail.routes) parts.push(make("details", {}, make("summary", {}, "Routes as task numbers"), make("pre", {}, detail.routes.map((r, k) => `UAV ${k}: ${r.join(" ") || "stays home"}`).join("\n"))));
    if (detail.log) parts.push(make("details", {}, make("summary", {}, "End of its output"), make("pre", {}, detail.log)));
  }
  open(`${run.method}, seed ${run.seed}, on ${instance.instance}`, ...parts);
};

const openInstance = (instance) => {
  const own = runs.filter((r) => r.on === instance);
  const better = (a, b) => (a.value ?? Infinity) - (b.value ?? Infinity) || a.elapsed - b.elapsed;
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
    lines.push({ trace: wholeTrace(run), colour: data.styles[run.method][0], dashes: data.styles[run.method][1], method: run.method });
  }
  if (lines.length) {
    const legend = make("p", { class: "soft" }, ...lines.flatMap((l) => {
      const key = draw("svg", { class: "key", viewBox: "0 0 30 10", "aria-hidden": "true" }, draw("line", { x1: 0, x2: 30, y1: 5, y2: 5, stroke: l.colour, "stroke-width": 3.5, "stroke-dasharray": l.dashes }));
      return [key, `${l.method}   `];
    }));
    drawings.push(part("Longest tour over time, best run of each method [s]", drawTrace(lines, Math.max(...own.map((r) => r.time_limit)), "Objective over time of each method"), legend));
  }
  parts.push(make("div", { class: "pair" }, ...drawings));
  const place = make("div");
  parts.push(part("Runs", place));
  open(instance.instance, ...parts);
  list(place, { name: "own-list", rows: ordered, columns: runColumns.filter((c) => c.key !== "instance"), open: openRun, filters: [] });
};
