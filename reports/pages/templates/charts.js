// Charts: Bokeh's panels in the place of each drawing, one row of methods that hides and shows them in all figures,
// zoom by buttons, and figures saved as SVG and CSV. Needs page.js. A chart that cannot be drawn stays an SVG.
{
const charts = [];
const hidden = new Set();
const later = () => new Promise((go) => (window.requestIdleCallback ? requestIdleCallback(go, { timeout: 200 }) : setTimeout(go)));

// ---- ink and paper are the page's ------------------------------------------------------------------------------
const INKS = { "#1b1c1e": "--ink", "#fefefd": "--paper", "#8a8c91": "--faint" };
const probe = make("span", { hidden: "" });
document.body.append(probe);
const colourOf = (name) => { probe.style.color = `var(${name})`; return getComputedStyle(probe).color; };
const inked = (models) => [...models].flatMap((model) => [...model].flatMap((property) => {
  const value = property.is_unset ? null : property.get_value(), plain = typeof value === "string" ? value : value && value.value;
  return typeof plain === "string" && INKS[plain] ? [{ model, name: property.attr, ink: INKS[plain], wrapped: plain !== value }] : [];
}));
const colour = ({ inks }) => {
  for (const { model, name, ink, wrapped } of inks) model[name] = wrapped ? { value: colourOf(ink) } : colourOf(ink);
};

// ---- methods hidden and shown ------------------------------------------------------------------------------------
const names = () => [...new Set(charts.flatMap(({ told }) => told.legend.map(({ name }) => name)))];
const apply = (chart) => {
  for (const model of chart.renderers) model.visible = !hidden.has(model.name);
};
const changed = () => {
  charts.filter((chart) => chart.renderers).forEach(apply);
  for (const button of document.querySelectorAll("button.method")) button.setAttribute("aria-pressed", String(!hidden.has(button.value)));
  document.dispatchEvent(new CustomEvent("charts:changed", { detail: window.charts.shown() }));
};
const toggle = (name) => { if (!hidden.delete(name)) hidden.add(name); changed(); };
const keyOf = ({ colour, dashes, line, hollow }) => draw("svg", { class: "key", viewBox: "0 0 30 10", "aria-hidden": "true" }, line
  ? draw("line", { x1: 0, x2: 30, y1: 5, y2: 5, stroke: colour, "stroke-width": 3.5, "stroke-dasharray": dashes.join(" ") })
  : draw("circle", { cx: 15, cy: 5, r: 4, fill: hollow ? "none" : colour, stroke: colour, "stroke-width": 2 }));
const methodButton = (entry) => make("button", {
  type: "button", class: "method", value: entry.name, "aria-pressed": String(!hidden.has(entry.name)), onclick: () => toggle(entry.name),
}, keyOf(entry), entry.name);

// Names in several figures are the page's methods: one row of them above the first chart, which stays in sight.
const methodRow = () => {
  const often = charts.flatMap(({ told }) => told.legend);
  const shared = often.filter((entry, i) => often.findIndex((e) => e.name === entry.name) === i && often.filter((e) => e.name === entry.name).length > 1);
  if (shared.length < 2) return;
  const some = (label, kept) => make("button", { type: "button", onclick: () => window.charts.show(kept) }, label);
  const row = make("div", { class: "methods", role: "group", "aria-label": "Methods shown in all figures" },
    some("All", names()), some("None", names().filter((name) => !shared.some((entry) => entry.name === name))), ...shared.map(methodButton));
  const main = document.querySelector("main");
  let first = charts[0].figure;
  while (first.parentElement !== main) first = first.parentElement;
  first.before(row);
};

// ---- zoom ----------------------------------------------------------------------------------------------------------
const rangesOf = (chart) => [...new Set(chart.plots.flatMap((plot) => [plot.x_range, plot.y_range]))];
const zoom = (chart, factor) => {
  const logarithmic = new Set(chart.plots.flatMap((plot) => [[plot.x_range, plot.x_scale], [plot.y_range, plot.y_scale]])
    .filter(([, scale]) => scale.type === "LogScale").map(([range]) => range));
  for (const range of rangesOf(chart)) {
    const [to, from] = logarithmic.has(range) ? [Math.log, Math.exp] : [(v) => v, (v) => v];
    const middle = (to(range.start) + to(range.end)) / 2, half = factor * (to(range.end) - to(range.start)) / 2;
    range.setv({ start: from(middle - half), end: from(middle + half) });
  }
};
const reset = (chart) => chart.ends.forEach(([range, start, end]) => range.setv({ start, end }));
const dragTo = (chart, type) => {
  for (const plot of chart.plots) for (const tool of plot.toolbar.tools) if (tool.type === type) tool.active = true;
};

// ---- save ----------------------------------------------------------------------------------------------------------
const save = (name, type, text) => {
  const address = URL.createObjectURL(new Blob([text], { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
};
const svgText = (svg) => {
  const copy = svg.cloneNode(true), box = svg.viewBox.baseVal, paper = colourOf("--paper");
  for (const [key, value] of [["xmlns", SVG], ["xmlns:xlink", "http://www.w3.org/1999/xlink"], ["width", box.width], ["height", box.height]]) copy.setAttribute(key, value);
  copy.prepend(draw("rect", { width: box.width, height: box.height, fill: paper }));
  copy.setAttribute("color", colourOf("--ink"));
  return new XMLSerializer().serializeToString(copy).replaceAll("var(--paper)", paper).replaceAll("var(--faint)", colourOf("--faint"));
};
const csvText = ({ document: doc, told }) => {
  const field = (value) => {
    const text = value === undefined || Number.isNaN(value) ? "" : String(value), safe = typeof value === "string" && /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
    return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
  };
  const rows = told.series.flatMap(({ source, same, fields }) => {
    const columns = doc.get_model_by_id(source).data, at = (name, i) => (name in same ? same[name] : fields[name] ? columns[fields[name]][i] : undefined);
    return Array.from(Object.values(fields).map((name) => columns[name])[0], (_, i) => told.columns.map((name) => at(name, i)));
  });
  return [told.columns, ...rows].map((row) => row.map(field).join(",")).join("\n") + "\n";
};

// ---- a chart in its place --------------------------------------------------------------------------------------------
const bar = (chart) => {
  const button = (label, act, title) => make("button", { type: "button", title, "aria-label": `${label}: ${title}, ${chart.title}`, onclick: act }, label);
  const pan = make("button", { type: "button", "aria-pressed": "false", title: "Dragging moves the figure instead of zooming", "aria-label": `Move: dragging moves ${chart.title}`, onclick: () => {
    const on = pan.getAttribute("aria-pressed") === "false";
    pan.setAttribute("aria-pressed", String(on));
    dragTo(chart, on ? "PanTool" : "BoxZoomTool");
  } }, "Move");
  return make("div", { class: "tools" }, button("+", () => zoom(chart, 0.5), "zoom in (or drag over a part, or Ctrl and the wheel)"), button("−", () => zoom(chart, 2), "zoom out"), pan,
    button("Reset", () => reset(chart), "back to the whole figure"), button("CSV", () => save(`${chart.name}.csv`, "text/csv", csvText(chart)), "save the values"));
};
const TIP = ":host { --tooltip-color: var(--paper); --tooltip-text: var(--ink); --tooltip-border: var(--faint); --tooltip-arrow-color: var(--faint); --tooltip-arrow-inner-color: var(--paper); } .bk-tooltip-row-label { color: var(--soft) }";
const place = async (chart) => {
  const { told, figure, title } = chart, live = make("div", { class: "live" });
  const boxes = told.roots.map((_, i) => make("div", { role: "img", "aria-label": told.roots.length > 1 ? `${title}, panel ${i + 1} of ${told.roots.length}` : title }));
  live.append(make("div", { class: `panels columns-${told.across}` }, ...boxes));
  if (told.legend.length > 1 && !told.titled) live.append(make("div", { class: "legend", role: "group", "aria-label": `Legend of ${title}` }, ...told.legend.map(methodButton)));
  figure.querySelector(".drawing").after(live);
  figure.classList.add("interactive");
  const roots = Object.fromEntries(told.roots.map((id, i) => [id, boxes[i]]));
  const views = await Bokeh.embed.embed_items({ chart: told.document }, [{ docid: "chart", roots, root_ids: told.roots }]);
  chart.plots = told.roots.map((id) => [...views[0].roots].map((view) => view.model).find((model) => model.id === id));
  chart.document = chart.plots[0].document;
  chart.inks = inked(chart.document._all_models.values());
  chart.renderers = chart.plots.flatMap((plot) => plot.renderers.filter((model) => model.name));
  chart.ends = rangesOf(chart).map((range) => [range, range.start, range.end]);
  if (matchMedia("(pointer: coarse)").matches) for (const plot of chart.plots) plot.toolbar.tools.forEach((tool) => { tool.active = tool.type === "HoverTool"; }); // a finger scrolls the page
  figure.querySelector(".save").prepend(bar(chart));
  for (const hover of views[0].query((view) => view.ttmodels)) for (const tip of hover.ttmodels.values()) tip.stylesheets = [TIP];
  for (const canvas of views[0].query((view) => view.events_el)) canvas.events_el.removeAttribute("tabindex"); // the buttons serve the keyboard
  colour(chart);
  apply(chart);
};

for (const figure of document.querySelectorAll("figure")) {
  const words = figure.querySelector("figcaption"), svg = figure.querySelector(".drawing svg");
  if (!svg) continue;
  const title = (words.querySelector("b") || words).textContent.replace(/\.$/, ""), name = figure.id.replace(/^figure-/, "");
  figure.append(make("div", { class: "save" }, make("div", { class: "tools" },
    make("button", { type: "button", "aria-label": `SVG: save the figure, ${title}`, onclick: () => save(`${name}.svg`, "image/svg+xml", svgText(svg)) }, "SVG"))));
  const told = figure.querySelector("script.chart");
  if (told) charts.push({ figure, title, name, told: JSON.parse(told.textContent) });
}
window.charts = {
  names,
  shown: () => names().filter((name) => !hidden.has(name)),
  show: (kept) => { hidden.clear(); names().filter((name) => !kept.includes(name)).forEach((name) => hidden.add(name)); changed(); },
};
methodRow();
const recolour = () => charts.filter((chart) => chart.inks).forEach(colour);
new MutationObserver(recolour).observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
if (charts.length) Bokeh.set_log_level("warn");
window.charts.ready = (async () => {
  for (const chart of charts) {
    await later();
    try { await place(chart); } catch (error) {
      chart.figure.classList.remove("interactive");
      console.warn(`${chart.name} stays a drawing: ${error.message}`);
    }
  }
})();
}
