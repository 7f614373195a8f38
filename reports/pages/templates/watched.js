// Ask for what is new every two seconds while the page is seen; keep sorted columns and open parts as they are.
const live = document.getElementById("live"), lost = document.getElementById("lost");
const replace = (html) => {
  const sorted = [...live.querySelectorAll('th[aria-sort$="scending"]')].map((h) => [h.closest("table").id, h.cellIndex, h.getAttribute("aria-sort")]);
  const opened = [...live.querySelectorAll("details")].map((part) => part.open);
  live.innerHTML = html;
  sortTables(live);
  live.querySelectorAll("details").forEach((part, i) => { part.open = opened[i] ?? false; });
  for (const [id, column, way] of sorted) {
    const head = document.getElementById(id)?.tHead.rows[0].cells[column];
    for (let i = 0; head && i < 2 && head.getAttribute("aria-sort") !== way; i += 1) head.querySelector("button").click();
  }
};
const look = async () => {
  try {
    const answer = await fetch("data.json", { cache: "no-store" });
    if (!answer.ok) throw new Error(answer.statusText);
    const data = await answer.json();
    if (data.version !== live.dataset.version) replace(data.html);
    live.dataset.version = data.version;
    lost.hidden = true;
  } catch { lost.hidden = false; }
};
setInterval(() => { if (!document.hidden) look(); }, 2000);
document.addEventListener("visibilitychange", () => { if (!document.hidden) look(); });
