// The growing map: a slider over the kept maps, with tracks and samples up to the moment. Needs page.js.
const film = JSON.parse(document.getElementById("data").textContent);
const slider = document.getElementById("tick"), said = document.getElementById("said"), play = document.getElementById("play");
const panels = ["mean", "sd"].map((kind) => {
  const svg = document.getElementById("film-" + kind);
  return { kind, picture: svg.querySelector("image"), layer: svg.querySelector("g.flown"), wind: svg.querySelectorAll("g.wind path") };
});
const size = Math.max(film.box.width, film.box.height);
const showFrame = (number) => {
  const frame = film.frames[number];
  for (const { kind, picture, layer, wind } of panels) {
    for (const path of wind) path.setAttribute("d", frame.wind);
    picture.setAttribute("href", frame[kind]);
    layer.replaceChildren();
    for (const track of film.tracks) {
      const done = track.points.filter((p) => p[2] <= frame.time);
      if (!done.length) continue;
      const points = done.map((p) => p[0] + "," + p[1]).join(" ");
      layer.append(draw("polyline", { points, fill: "none", stroke: "#fff", "stroke-width": size / 120, "stroke-linejoin": "round" }));
      layer.append(draw("polyline", { points, fill: "none", stroke: track.colour, "stroke-width": size / 220, "stroke-linejoin": "round" }));
      const last = done[done.length - 1];
      layer.append(draw("circle", { cx: last[0], cy: last[1], r: size / 70, fill: track.colour, stroke: "#fff", "stroke-width": size / 300 }));
    }
    for (const [x, y, time] of film.samples) {
      if (time <= frame.time) layer.append(draw("circle", { cx: x, cy: y, r: size / 230, fill: "#111", stroke: "#fff", "stroke-width": size / 900 }));
    }
  }
  said.textContent = `${frame.time} s, ${frame.samples} samples, RMSE ${frame.rmse.toFixed(2)} ${film.unit}`;
};
slider.max = film.frames.length - 1;
slider.addEventListener("input", () => showFrame(+slider.value));
let timer = null;
const stop = () => { clearInterval(timer); timer = null; play.textContent = "Play"; };
play.addEventListener("click", () => {
  if (timer) return stop();
  if (+slider.value >= +slider.max) slider.value = 0;
  play.textContent = "Pause";
  showFrame(+slider.value);
  timer = setInterval(() => {
    slider.value = +slider.value + 1;
    showFrame(+slider.value);
    if (+slider.value >= +slider.max) stop();
  }, 350);
});
slider.value = slider.max;
showFrame(film.frames.length - 1);
