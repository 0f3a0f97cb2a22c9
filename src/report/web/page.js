// The page alive: charts that answer the pointer, the part that turns. Everything it shows stands in the page's data.
import uPlot from 'uplot';
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Mesh, MeshStandardMaterial,
  PerspectiveCamera, Scene, WebGLRenderer
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const data = JSON.parse(document.getElementById('data').textContent);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function drawChart(box) {
  const chart = data.charts[+box.dataset.chart];
  const columns = [chart.x], series = [{ label: chart.x_label }], bands = [];
  chart.series.forEach((s, i) => {
    const colour = style(`--c${i % 8}`);
    columns.push(s.y);
    series.push({
      label: s.name || chart.y_label, stroke: colour, width: chart.points ? 0 : 1.8, spanGaps: true,
      paths: chart.points ? () => null : undefined,
      points: { show: chart.points || s.y.length < 40, size: chart.points ? 4 : 5, fill: colour, stroke: colour }
    });
    if (s.half.length) {
      const at = columns.length;
      columns.push(s.y.map((y, k) => y === null ? null : y + s.half[k]), s.y.map((y, k) => y === null ? null : y - s.half[k]));
      for (const end of ['+ 2 s', '- 2 s'])
        series.push({ label: end, stroke: 'transparent', points: { show: false }, width: 0 });
      bands.push({ series: [at, at + 1], fill: colour + '33' });
    }
  });
  const axis = { stroke: style('--soft'), grid: { stroke: style('--line'), width: 1 }, ticks: { stroke: style('--line') } };
  box.replaceChildren();
  const plot = new uPlot({
    width: box.clientWidth, height: 260, series, bands, cursor: { drag: { x: true, y: true } },
    scales: { x: { time: false } },
    axes: [{ ...axis, label: chart.x_label }, { ...axis, label: chart.y_label, size: 60 }]
  }, columns, box);
  // Keys move the cursor from value to value.
  let at = 0;
  box.onkeydown = event => {
    if (event.key !== 'ArrowRight' && event.key !== 'ArrowLeft') return;
    event.preventDefault();
    at = Math.min(chart.x.length - 1, Math.max(0, at + (event.key === 'ArrowRight' ? 1 : -1)));
    plot.setCursor({ left: plot.valToPos(chart.x[at], 'x'), top: 20 });
  };
  box.closest('figure').classList.add('alive');
  return plot;
}

const low = new Color('#2166ac'), middle = new Color('#f7f7f7'), high = new Color('#b2600a');
function colour(value, largest) {
  const share = Math.max(-1, Math.min(1, value / largest));
  return middle.clone().lerp(share < 0 ? low : high, Math.abs(share));
}

/** The flank of a cone: rings of points, moved out along the normal by what is left there. */
function flank(part, deviation, magnify, geometry) {
  const rings = part.h_mm.length, around = part.phi_deg.length, half = part.half_angle_deg * Math.PI / 180;
  const places = new Float32Array(3 * rings * (around + 1)), colours = new Float32Array(places.length), index = [];
  for (let r = 0; r < rings; ++r)
    for (let k = 0; k <= around; ++k) {
      const value = deviation[r * around + k % around], phi = part.phi_deg[k % around] * Math.PI / 180;
      const out = part.base_diameter_mm / 2 - part.h_mm[r] * Math.tan(half) + 1e-3 * value * magnify * Math.cos(half);
      const at = 3 * (r * (around + 1) + k), c = colour(value, part.largest_um);
      places.set([out * Math.cos(phi), out * Math.sin(phi), part.h_mm[r] + 1e-3 * value * magnify * Math.sin(half)], at);
      colours.set([c.r, c.g, c.b], at);
      if (r + 1 < rings && k < around) {
        const a = r * (around + 1) + k, b = a + around + 1;
        index.push(a, a + 1, b, b, a + 1, b + 1);
      }
    }
  geometry.setAttribute('position', new BufferAttribute(places, 3));
  geometry.setAttribute('color', new BufferAttribute(colours, 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
}

function webgl() {
  try {
    return !!document.createElement('canvas').getContext('webgl2');
  } catch {
    return false;
  }
}

function drawPart(figure) {
  if (!webgl()) return;  // the still stays
  const part = data.parts[+figure.dataset.part], view = figure.querySelector('.view');
  const canvas = document.createElement('canvas');
  canvas.tabIndex = 0;
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', 'The cone before and after compensation; arrow keys turn it');
  const names = part.variants.map(v => v.name);
  const controls = document.createElement('div');
  controls.className = 'controls';
  controls.innerHTML = '<label>magnified <input type="range" min="0" max="4" step="0.1" value="3"> <output></output></label>' +
    '<label>left <select></select></label><label>right <select></select></label>';
  view.replaceChildren(controls, canvas);
  view.insertAdjacentHTML('beforeend', `<div class="bar" role="presentation"></div><div class="ends"><span>-${part.largest_um.toFixed(2)} um</span><span>0</span><span>+${part.largest_um.toFixed(2)} um</span></div>`);
  const [slider] = controls.getElementsByTagName('input'), [output] = controls.getElementsByTagName('output');
  const choices = [...controls.getElementsByTagName('select')];
  choices.forEach((choice, side) => {
    for (const name of names) choice.add(new Option(name));
    choice.selectedIndex = side === 0 ? 0 : names.length - 1;
  });
  const renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  const camera = new PerspectiveCamera(35, 1, 1, 2000);
  camera.up.set(0, 0, 1);
  camera.position.set(part.base_diameter_mm * 1.6, -part.base_diameter_mm * 1.6, part.base_diameter_mm * 1.3);
  const scenes = choices.map(() => {
    const scene = new Scene(), geometry = new BufferGeometry();
    scene.add(new AmbientLight(0xffffff, 2), new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, side: DoubleSide, roughness: .8 })));
    const sun = new DirectionalLight(0xffffff, 1.5);
    sun.position.set(1, -2, 3);
    scene.add(sun);
    return { scene, geometry };
  });
  const orbit = new OrbitControls(camera, canvas);
  orbit.target.set(0, 0, part.h_mm[part.h_mm.length - 1] / 2);
  const render = () => {
    const width = view.clientWidth, height = Math.min(420, width / 2), each = width / 2;
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(width, height, false);
    canvas.style.height = height + 'px';
    camera.aspect = each / height;
    camera.updateProjectionMatrix();
    renderer.setScissorTest(true);
    scenes.forEach(({ scene }, side) => {
      scene.background = new Color(style('--panel'));
      renderer.setViewport(side * each, 0, each, height);
      renderer.setScissor(side * each, 0, each, height);
      renderer.render(scene, camera);
    });
  };
  const rebuild = () => {
    const magnify = Math.round(10 ** +slider.value);
    output.textContent = magnify + ' x';
    scenes.forEach(({ geometry }, side) => flank(part, part.variants[choices[side].selectedIndex].um, magnify, geometry));
    render();
  };
  orbit.addEventListener('change', render);
  slider.oninput = rebuild;
  choices.forEach(choice => { choice.onchange = rebuild; });
  canvas.onkeydown = event => {
    const turn = { ArrowLeft: -.1, ArrowRight: .1 }[event.key];
    if (!turn) return;
    event.preventDefault();
    const { x, y } = camera.position;
    camera.position.x = x * Math.cos(turn) - y * Math.sin(turn);
    camera.position.y = x * Math.sin(turn) + y * Math.cos(turn);
    orbit.update();
    render();
  };
  orbit.update();
  rebuild();
  return render;
}

const boxes = [...document.querySelectorAll('.chart')];
let plots = boxes.map(drawChart);
const parts = [...document.querySelectorAll('figure.part')].map(drawPart).filter(Boolean);
function again() {
  plots.forEach(plot => plot.destroy());
  plots = boxes.map(drawChart);
  parts.forEach(render => render());
}
matchMedia('(prefers-color-scheme:dark)').addEventListener('change', again);
let waiting;
addEventListener('resize', () => {
  clearTimeout(waiting);
  waiting = setTimeout(again, 150);
});
