// The still charts of the page, drawn again by uPlot so that they tell their values.
import uPlot from "uplot";

const HEIGHT = 260;
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 5], [1, 4]];
const SHAPES_WIDE = 4;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const withTrueMinus = (text) => text.replaceAll("-", "−");
const digits = (value) => (value == null ? "–" : withTrueMinus(Number(value.toPrecision(4)).toString()));

/// A value with its standard uncertainty, both to the decimal where that has two significant digits.
function withUncertainty(value, std) {
  if (!(std > 0)) return digits(value);
  const decimals = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(std))));
  return `${withTrueMinus(value.toFixed(decimals))} ± ${std.toFixed(decimals)}`;
}

/// What an abscissa says: a number, or the kind that stands nearest.
const abscissa = (chart, value) =>
  value == null || !chart.categories ? digits(value) : chart.categories[Math.round(value)] ?? "–";

/// Names of kinds in place of numbers, as many as there is room for.
const kinds = (chart) => {
  const every = Math.ceil(chart.categories.length / 12);
  const places = chart.categories.map((_, k) => k).filter((k) => k % every === 0);
  return { splits: () => places, values: (plot, at) => at.map((k) => chart.categories[k] ?? "") };
};

/// uPlot's data and series of a chart; a band is two more series that have no line of their own.
function seriesOf(chart) {
  const data = [chart.x];
  const series = [{ label: chart.x_name, value: (plot, value) => abscissa(chart, value) }];
  const bands = [];
  chart.series.forEach((told, k) => {
    const ink = () => colour(`--s${k % 6}`);
    const of = (value, half) => (value == null || half == null ? digits(value) : withUncertainty(value, half / 2));
    series.push({
      label: told.name,
      stroke: ink,
      width: 2,
      dash: chart.points ? [] : DASHES[k % 6],
      paths: chart.points ? () => null : undefined,
      points: { show: chart.points || chart.x.length <= 40, size: chart.points ? SHAPES_WIDE : 5, fill: ink, stroke: ink },
      value: (plot, value, s, i) => (i == null ? "–" : `${of(value, told.half_width?.[i])} ${chart.y_unit}`),
    });
    data.push(told.values);
  });
  chart.series.forEach((told, k) => {
    if (!told.half_width) return;
    for (const sign of [1, -1]) {
      data.push(told.values.map((v, i) => (v == null || told.half_width[i] == null ? null : v + sign * told.half_width[i])));
      series.push({ label: `${told.name} band`, width: 0, points: { show: false }, class: "band-row" });
    }
    const upper = series.length - 2;
    bands.push({ series: [upper, upper + 1], fill: () => `${colour(`--s${k % 6}`)}2e` });
  });
  return { data, series, bands };
}

/// Points get room at both ends, so that none is cut in half; kinds have their own.
function edges(chart, low, high) {
  if (chart.categories && low <= 0 && high >= chart.categories.length - 1.5) return [-0.5, chart.categories.length - 0.5];
  const room = chart.points ? 0.02 * (high - low) : 0;
  return [low - room, high + room];
}

function live(figure) {
  const chart = JSON.parse(figure.querySelector("script").textContent);
  const still = figure.querySelector(".still");
  const place = document.createElement("div");
  place.className = "live";
  place.tabIndex = 0;
  place.setAttribute("role", "application");
  place.setAttribute("aria-label", `${chart.title}: ${chart.y_label} over ${chart.x_label}. Arrow keys read the values.`);
  const reading = document.createElement("p");
  reading.className = "reading";
  reading.setAttribute("role", "status");
  still.after(place, reading);
  figure.classList.add("alive");

  const { data, series, bands } = seriesOf(chart);
  const axis = (label, size) => ({
    values: (u, at) => at.map((v) => (v == null ? "" : withTrueMinus(Number(v.toPrecision(9)).toString()))),
    label, size, labelSize: 22, labelFont: "13px sans-serif", font: "12px sans-serif",
    stroke: () => colour("--ink"), grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { stroke: () => colour("--grid"), width: 1 },
  });
  const plot = new uPlot({
    width: Math.max(240, place.clientWidth),
    height: HEIGHT,
    scales: { x: { time: false, range: (u, low, high) => edges(chart, low, high) }, y: { range: (u, low, high) => uPlot.rangeNum(Math.min(low, 0), Math.max(high, 0), 0.08, true) } },
    axes: [{ ...axis(chart.x_label, 44), ...(chart.categories ? kinds(chart) : {}) }, axis(chart.y_label, 56)],
    series, bands,
    cursor: { drag: { x: true, y: false } },
  }, data, place);
  place.querySelectorAll(".band-row").forEach((row) => (row.hidden = true));
  // In the legend the lines as they are drawn, with their dashes, in place of squares of their colour.
  const rows = place.querySelectorAll(".u-series");
  still.querySelectorAll(".legend svg").forEach((sample, k) =>
    rows[k + 1].querySelector(".u-marker").replaceWith(sample.cloneNode(true)));

  const tell = (i) => {
    reading.textContent = `${chart.x_name} ${abscissa(chart, chart.x[i])}: ` + chart.series
      .map((told, k) => `${told.name} ${series[k + 1].value(plot, told.values[i], k + 1, i)}`).join("; ");
  };
  let at = -1;
  place.addEventListener("keydown", (event) => {
    const steps = { ArrowRight: 1, ArrowLeft: -1, Home: -chart.x.length, End: chart.x.length };
    if (!(event.key in steps)) return;
    event.preventDefault();
    at = Math.min(chart.x.length - 1, Math.max(0, at + steps[event.key]));
    plot.setCursor({ left: plot.valToPos(chart.x[at], "x"), top: plot.bbox.height / 2 / devicePixelRatio });
    tell(at);
  });
  new ResizeObserver(() => plot.setSize({ width: Math.max(240, place.clientWidth), height: HEIGHT })).observe(place);
  return { redraw: () => plot.redraw(false) };
}

export const liveCharts = (figures) => [...figures].map(live);
