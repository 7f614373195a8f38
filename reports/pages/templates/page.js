// What every page does: state in the address, the light/dark switch, tables that sort, parts that print; small helpers.
const dash = "–";
const make = (tag, attributes = {}, ...children) => {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "onclick") node.addEventListener("click", value);
    else if (value !== null && value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
};
const SVG = "http://www.w3.org/2000/svg";
const draw = (tag, attributes = {}, ...children) => {
  const node = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
const compare = (a, b) => {
  const gone = (x) => x === null || x === undefined || x === "";
  if (gone(a) || gone(b)) return gone(a) - gone(b);
  return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b), "en", { numeric: true });
};

// ---- the address -------------------------------------------------------------------------------------------------
// Behind the # stand the section and what is open, sorted, filtered and chosen: #runs&open=…&sort.run-list=-gap_found.
// So a link shows what its sender saw, a reload keeps it, and Back goes back. Each part of the page `keeps` its own share.
const readAddress = () => {
  const parts = location.hash.slice(1).split("&").filter(Boolean);
  const section = parts.length && !parts[0].includes("=") ? parts.shift() : "";
  return { section, said: new URLSearchParams(parts.join("&")) };
};
let shownAddress = location.hash;
// push: "" to amend the entry of the history, "section" or "panel" for a new one; panels: how many lie above the page
const writeAddress = (change, push = "") => {
  const now = readAddress();
  change(now);
  const hash = [now.section, now.said.toString()].filter(Boolean).join("&");
  const panels = push === "section" ? 0 : (history.state?.panels ?? 0) + (push === "panel");
  try {
    history[push ? "pushState" : "replaceState"]({ panels }, "", location.href.split("#")[0] + (hash && "#" + hash));
  } catch { /* a viewer that embeds the page may forbid it: then the address says nothing */ }
  shownAddress = location.hash;
};
// put a value into the address, or take it out: null, "" or what is shown anyhow
const tell = (key, value, usual = "") => writeAddress(({ said }) => {
  if (value === null || value === usual) said.delete(key); else said.set(key, value);
});
const restorers = [];
// restore(said): make the part look as the address says; called now, and whenever the reader goes back or forth
const keep = (restore) => { restorers.push(restore); restore(readAddress().said); };
const show = (section) => {
  const target = section && document.getElementById(decodeURIComponent(section));
  if (target) target.scrollIntoView();
};
const follow = () => {
  if (location.hash === shownAddress) return;
  shownAddress = location.hash;
  restorers.forEach((restore) => restore(readAddress().said));
};
addEventListener("popstate", follow);
addEventListener("hashchange", () => { follow(); show(readAddress().section); });
for (const link of document.querySelectorAll("a[href^='#']")) {
  link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    const section = link.getAttribute("href").slice(1), target = document.getElementById(section);
    writeAddress((now) => { now.section = section; }, readAddress().section !== section ? "section" : "");
    show(section);
    target.tabIndex = -1; // the next Tab goes on from here
    target.focus({ preventScroll: true });
  });
}
addEventListener("load", () => show(readAddress().section));

// ---- light and dark -----------------------------------------------------------------------------------------
const theme = document.getElementById("theme");
const isDark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};
const nameTheme = () => { theme.textContent = isDark() ? "Light" : "Dark"; };
let remembered = null;
try { remembered = localStorage.getItem("theme"); } catch { /* storage may be off for files */ }
theme.addEventListener("click", () => {
  remembered = document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  tell("theme", remembered);
  try { localStorage.setItem("theme", remembered); } catch { /* as above */ }
  nameTheme();
});
keep((said) => {
  const chosen = said.get("theme") ?? remembered;
  if (["light", "dark"].includes(chosen)) document.documentElement.dataset.theme = chosen;
  else delete document.documentElement.dataset.theme;
  nameTheme();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", nameTheme);

// ---- methods shown in the figures ---------------------------------------------------------------------------------
let usualMethods = null;
const showMethods = (said) => {
  if (!window.charts) return;
  usualMethods ??= window.charts.shown();
  const wanted = said.has("method") ? said.getAll("method").filter(Boolean) : usualMethods;
  if (wanted.join("\n") !== window.charts.shown().join("\n")) window.charts.show(wanted);
};
const tellMethods = () => writeAddress(({ said }) => {
  const now = window.charts.shown();
  said.delete("method");
  if (usualMethods && now.join("\n") === usualMethods.join("\n")) return;
  (now.length ? now : [""]).forEach((method) => said.append("method", method));
});
addEventListener("load", () => {
  keep(showMethods);
  for (const target of [window, document]) target.addEventListener("charts:changed", tellMethods);
});

// ---- tables: sort by a click on a heading -----------------------------------------------------------------------
// The number a cell shows, its text, or null for a dash; what is "< 0.001" stands just before it.
const shownValue = (cell) => {
  if (cell.dataset.sort !== undefined) return Number(cell.dataset.sort);
  const text = cell.textContent.trim();
  if (text === dash || text === "") return null;
  const found = text.replaceAll(",", "").match(/^([<>]\s)?([−-]?[\d.]+(?:e[+-]?\d+)?|∞)(\s%)?$/);
  if (!found) return text;
  const value = found[2] === "∞" ? 1e300 : Number(found[2].replace("−", "-"));
  return value + (found[1] ? Math.abs(value) * (found[1][0] === "<" ? -1e-6 : 1e-6) : 0);
};
const sorted = (items, valueOf, descending) => {
  const keys = new Map(items.map((item) => [item, valueOf(item)])), sign = descending ? -1 : 1;
  return [...items].sort((a, b) => {
    const x = keys.get(a), y = keys.get(b);
    return x === null || y === null ? (x === null) - (y === null) : sign * compare(x, y);
  });
};
// Give the headings of `table` buttons; order(column number or -1, descending) puts the rows in order. name: in the address.
const sortable = (table, order, name = "") => {
  const heads = [...table.tHead.rows[0].cells];
  let now = "";
  const sort = (column, descending) => {
    now = column < 0 ? "" : (descending ? "-" : "") + heads[column].dataset.key;
    heads.forEach((head, i) => head.setAttribute("aria-sort", i !== column ? "none" : descending ? "descending" : "ascending"));
    order(column, descending);
  };
  heads.forEach((head, column) => {
    const button = make("button", { type: "button", onclick: () => {
      const descending = head.getAttribute("aria-sort") === "ascending";
      sort(column, descending);
      if (name) tell(`sort.${name}`, now);
    } });
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
  });
  if (!name) return;
  keep((said) => {
    const wanted = said.get(`sort.${name}`) ?? "", key = wanted.replace(/^-/, "");
    if (wanted !== now) sort(heads.findIndex((head) => head.dataset.key === key), wanted.startsWith("-"));
  });
};
const sortTables = (part) => part.querySelectorAll("table.sortable").forEach((table) => {
  const body = table.tBodies[0], rows = [...body.rows];
  sortable(table, (column, descending) => {
    body.append(...(column < 0 ? rows : sorted(rows, (row) => shownValue(row.cells[column]), descending)));
  }, table.id.replace(/-table$/, ""));
});
sortTables(document);

// ---- what is wider than the screen scrolls by itself, also by keyboard ----------------------------------------------
const scrolling = (box) => {
  const wider = box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight;
  if (wider) box.tabIndex = 0; else box.removeAttribute("tabindex");
};
const watching = new ResizeObserver((seen) => seen.forEach(({ target }) => scrolling(target)));
document.querySelectorAll(".scroll, figure, pre, .bar").forEach((box) => watching.observe(box));

// ---- folded parts open for print -----------------------------------------------------------------------------------
let unfolded = [];
addEventListener("beforeprint", () => {
  unfolded = [...document.querySelectorAll("details:not([open])")];
  unfolded.forEach((part) => { part.open = true; });
});
addEventListener("afterprint", () => unfolded.splice(0).forEach((part) => { part.open = false; }));
