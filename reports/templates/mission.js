"use strict";
// The growing map: a slider over the kept maps, with tracks and samples up to the moment; and the light/dark switch.
(() => {
  const film = JSON.parse(document.getElementById("film").textContent);
  const slider = document.getElementById("tick"), said = document.getElementById("said"), play = document.getElementById("play");
  const panels = ["mean", "sd"].map((kind) => {
    const svg = document.getElementById("film-" + kind);
    return { kind, picture: svg.querySelector("image"), layer: svg.querySelector("g") };
  });
  const NS = "http://www.w3.org/2000/svg";
  const size = Math.max(film.box.width, film.box.height);
  const add = (layer, name, attributes) => {
    const element = layer.appendChild(document.createElementNS(NS, name));
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  };
  const draw = (number) => {
    const frame = film.frames[number];
    for (const { kind, picture, layer } of panels) {
      picture.setAttribute("href", frame[kind]);
      layer.replaceChildren();
      for (const track of film.tracks) {
        const done = track.points.filter((p) => p[2] <= frame.time);
        if (!done.length) continue;
        const points = done.map((p) => p[0] + "," + p[1]).join(" ");
        add(layer, "polyline", { points, fill: "none", stroke: "#fff", "stroke-width": size / 120, "stroke-linejoin": "round" });
        add(layer, "polyline", { points, fill: "none", stroke: track.colour, "stroke-width": size / 220, "stroke-linejoin": "round" });
        const last = done[done.length - 1];
        add(layer, "circle", { cx: last[0], cy: last[1], r: size / 70, fill: track.colour, stroke: "#fff", "stroke-width": size / 300 });
      }
      for (const [x, y, time] of film.samples) {
        if (time <= frame.time) add(layer, "circle", { cx: x, cy: y, r: size / 260, fill: "#111" });
      }
    }
    said.textContent = `${frame.time} s, ${frame.samples} samples, RMSE ${frame.rmse.toFixed(2)} ${film.unit}`;
  };
  slider.max = film.frames.length - 1;
  slider.addEventListener("input", () => draw(+slider.value));
  let timer = null;
  const stop = () => { clearInterval(timer); timer = null; play.textContent = "Play"; };
  play.addEventListener("click", () => {
    if (timer) return stop();
    if (+slider.value >= +slider.max) slider.value = 0;
    play.textContent = "Pause";
    draw(+slider.value);
    timer = setInterval(() => {
      slider.value = +slider.value + 1;
      draw(+slider.value);
      if (+slider.value >= +slider.max) stop();
    }, 350);
  });
  slider.value = slider.max;
  draw(film.frames.length - 1);

  const root = document.documentElement, theme = document.getElementById("theme");
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
  const label = () => { theme.textContent = dark() ? "Light" : "Dark"; };
  theme.addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; label(); });
  label();
})();
