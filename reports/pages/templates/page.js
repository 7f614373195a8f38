// What every page does: the light/dark switch, tables that sort, folded parts that open for print; and small helpers.
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

// ---- light and dark -----------------------------------------------------------------------------------------
const theme = document.getElementById("theme");
const isDark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};
const nameTheme = () => { theme.textContent = isDark() ? "Light" : "Dark"; };
try { const kept = localStorage.getItem("theme"); if (kept) document.documentElement.dataset.theme = kept; } catch { /* storage may be off for files */ }
theme.addEventListener("click", () => {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  try { localStorage.setItem("theme", document.documentElement.dataset.theme); } catch { /* as above */ }
  nameTheme();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", nameTheme);
nameTheme();

// ---- tables that are already in the page: sort by a click on a heading ------------------------------------------
const setSorted = (heads, head, way) => heads.forEach((h) => h.setAttribute("aria-sort", h === head ? way : "none"));
const sortable = (head, sort) => {
  const button = make("button", { type: "button", onclick: () => sort(head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending") });
  button.append(...head.childNodes);
  head.append(button);
  head.setAttribute("aria-sort", "none");
};
const sortTables = (part) => part.querySelectorAll("table.sortable").forEach((table) => {
  const heads = [...table.tHead.rows[0].cells];
  const key = (row, i) => {
    const cell = row.cells[i], given = cell.dataset.sort;
    if (given !== undefined) return Number(given);
    const text = cell.textContent.trim();
    return text === dash ? null : text !== "" && !isNaN(text) ? Number(text) : text;
  };
  heads.forEach((head, i) => sortable(head, (way) => {
    const rows = [...table.tBodies[0].rows], sign = way === "ascending" ? 1 : -1;
    const missing = (row) => key(row, i) === null;
    rows.sort((a, b) => (missing(a) || missing(b) ? missing(a) - missing(b) : sign * compare(key(a, i), key(b, i))));
    table.tBodies[0].append(...rows);
    setSorted(heads, head, way);
  }));
});
sortTables(document);

addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => { part.open = true; }));
