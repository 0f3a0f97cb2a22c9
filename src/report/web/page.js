// The page comes to life: charts that answer the pointer and the keys, a part that turns, the choice of light or dark.
import uPlotStyle from "uplot/dist/uPlot.min.css";
import { liveCharts } from "./charts.js";
import { liveParts } from "./part.js";

const style = document.createElement("style");
style.textContent = uPlotStyle;
document.head.append(style);

const charts = liveCharts(document.querySelectorAll("figure.chart"));
const parts = liveParts(document.querySelectorAll("figure.part"));
const redraw = () => [...charts, ...parts].forEach((drawn) => drawn.redraw());

const system = matchMedia("(prefers-color-scheme: dark)");
const button = document.getElementById("theme");
button.hidden = false;
button.addEventListener("click", () => {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : system.matches;
  root.dataset.theme = dark ? "light" : "dark";
  redraw();
});
system.addEventListener("change", redraw);
