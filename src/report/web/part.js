// The part in three dimensions: as it was cut in two ways, side by side, its deviations magnified and coloured.
import {
  AmbientLight, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial, PerspectiveCamera,
  Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const TURN = 2 * Math.PI;

function hasWebGL() {
  try {
    return !!document.createElement("canvas").getContext("webgl2");
  } catch {
    return false;
  }
}

/// The flank of a cone frustum as a mesh: a vertex for each height and turn, the lids fans over its first and last circle.
function flankMesh(told) {
  const { turns, heights_mm: heights, piece } = told;
  const slope = Math.tan((piece.half_angle_deg * Math.PI) / 180), cos = 1 / Math.hypot(1, slope), sin = slope * cos;
  const vertices = heights.length * turns;
  const nominal = new Float32Array(3 * vertices), normal = new Float32Array(3 * vertices), index = [];
  for (let j = 0; j < heights.length; ++j)
    for (let k = 0; k < turns; ++k) {
      const phi = (TURN * k) / turns, r = piece.base_diameter_mm / 2 - heights[j] * slope, at = 3 * (j * turns + k);
      nominal.set([r * Math.cos(phi), r * Math.sin(phi), heights[j]], at);
      normal.set([cos * Math.cos(phi), cos * Math.sin(phi), sin], at);
      if (j + 1 < heights.length) {
        const a = j * turns + k, b = j * turns + ((k + 1) % turns);
        index.push(a, b, b + turns, a, b + turns, a + turns);
      }
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(nominal.slice(), 3));
  geometry.setAttribute("normal", new BufferAttribute(normal.slice(), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * vertices), 3));
  geometry.setIndex(index);
  const mesh = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
  const lids = [0, heights.length - 1].map((j) => {
    const points = new Float32Array(3 * (turns + 1)), faces = [];
    points[3 * turns + 2] = heights[j];
    for (let k = 0; k < turns; ++k) faces.push(turns, k, (k + 1) % turns);
    const disc = new BufferGeometry();
    disc.setAttribute("position", new BufferAttribute(points, 3));
    disc.setAttribute("normal", new BufferAttribute(new Float32Array(points.length).map((_, i) => +(i % 3 === 2)), 3));
    disc.setIndex(faces);
    const lid = new Mesh(disc, new MeshLambertMaterial({ color: 0x9a9a9a, side: DoubleSide }));
    mesh.add(lid);
    return { disc, from: 3 * j * turns };
  });
  return { mesh, nominal, normal, lids };
}

/// Linear light of an sRGB colour, for vertex colours.
const linear = (byte) => {
  const c = byte / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};

class PartView {
  constructor(figure) {
    this.told = JSON.parse(figure.querySelector("script").textContent);
    this.palette = this.told.palette.map((rgb) => rgb.map(linear));
    const live = figure.querySelector(".live");
    live.hidden = false;
    this.stage = live.querySelector(".stage");
    this.reading = live.querySelector(".reading");
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.stage.append(this.canvas);

    this.sides = ["left", "right"].map((side) => {
      const scene = new Scene(), flank = flankMesh(this.told), choice = live.querySelector(`select.${side}`);
      const sun = new DirectionalLight(0xffffff, 1.4);
      sun.position.set(0.4, -1, 1.2);
      scene.add(new AmbientLight(0xffffff, 1.9), sun, flank.mesh);
      choice.addEventListener("change", () => this.shape());
      return { scene, choice, ...flank };
    });
    const cuts = [...this.sides[0].choice.options].map((option) => option.value);
    const after = cuts.includes("corrected") ? "corrected" : cuts[1] ?? cuts[0];
    this.sides[0].choice.value = cuts[0];
    this.sides[1].choice.value = after;

    const size = this.told.piece.base_diameter_mm;
    this.camera = new PerspectiveCamera(32, 1, size / 20, 20 * size);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(0.5 * size, -1.55 * size, 1.05 * size);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.set(0, 0, this.told.piece.height_mm / 2);
    this.controls.enablePan = false;
    this.controls.addEventListener("change", () => this.draw());
    this.controls.update();

    this.slider = live.querySelector("input[type=range]");
    this.output = live.querySelector("output");
    this.slider.addEventListener("input", () => this.shape());
    this.canvas.addEventListener("keydown", (event) => this.turn(event));
    this.canvas.addEventListener("pointermove", (event) => this.read(event));
    new ResizeObserver(() => this.fit()).observe(this.stage);
    this.fit();
    this.shape();
  }

  /// 0 at the left end; in the middle the scale's end stands a tenth of the part's radius out; four times that at the right.
  magnification() {
    const share = Number(this.slider.value) / 50;
    return Math.round((share * share * 0.05 * this.told.piece.base_diameter_mm) / (1e-3 * this.told.scale_um));
  }

  shape() {
    const times = this.magnification();
    this.output.textContent = `× ${times}`;
    for (const { mesh, nominal, normal, lids, choice } of this.sides) {
      const values = this.told.cuts[choice.value];
      const position = mesh.geometry.attributes.position, colour = mesh.geometry.attributes.color;
      for (let i = 0; i < values.length; ++i) {
        const out = 1e-3 * times * values[i];
        for (let c = 0; c < 3; ++c) position.array[3 * i + c] = nominal[3 * i + c] + out * normal[3 * i + c];
        const share = Math.min(1, Math.max(-1, values[i] / this.told.scale_um));
        colour.array.set(this.palette[Math.round(((share + 1) / 2) * (this.palette.length - 1))], 3 * i);
      }
      position.needsUpdate = colour.needsUpdate = true;
      mesh.geometry.computeBoundingSphere();
      for (const { disc, from } of lids) {
        const edge = disc.attributes.position;
        edge.array.set(position.array.subarray(from, from + 3 * this.told.turns));
        edge.needsUpdate = true;
        disc.computeBoundingSphere();
      }
    }
    this.canvas.setAttribute("aria-label", "The part coloured by its deviation: left " + this.sides[0].choice.value +
      ", right " + this.sides[1].choice.value + `, deviations magnified ${times} times. Arrow keys turn it.`);
    this.draw();
  }

  fit() {
    const width = Math.max(240, this.stage.clientWidth), height = Math.min(420, Math.max(200, width / 2));
    this.renderer.setSize(width, height, false);
    this.canvas.style.cssText = `width:${width}px;height:${height}px`;
    this.camera.aspect = width / 2 / height;
    this.camera.zoom = Math.min(1, this.camera.aspect / 1.2);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    const size = this.renderer.getSize(new Vector2());
    this.renderer.setScissorTest(true);
    this.sides.forEach(({ scene }, k) => {
      this.renderer.setViewport((k * size.x) / 2, 0, size.x / 2, size.y);
      this.renderer.setScissor((k * size.x) / 2, 0, size.x / 2, size.y);
      this.renderer.render(scene, this.camera);
    });
  }

  turn(event) {
    const about = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const nearer = { "+": 0.9, "=": 0.9, "-": 1 / 0.9 }[event.key];
    if (!about && !nearer) return;
    event.preventDefault();
    const from = this.camera.position.clone().sub(this.controls.target);
    if (nearer) from.multiplyScalar(nearer);
    if (about) {
      const tilt = Math.acos(from.z / from.length()), to = Math.min(3.0, Math.max(0.14, tilt + about[1]));
      from.applyAxisAngle(new Vector3().crossVectors(this.camera.up, from).normalize(), to - tilt);
      from.applyAxisAngle(this.camera.up, about[0]);
    }
    this.camera.position.copy(this.controls.target).add(from);
    this.controls.update();
    this.draw();
  }

  read(event) {
    const box = this.canvas.getBoundingClientRect(), half = box.width / 2;
    const x = event.clientX - box.left, side = this.sides[x < half ? 0 : 1];
    const pointer = new Vector2(((x % half) / half) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const hit = ray.intersectObject(side.mesh, true)[0];
    if (hit?.object !== side.mesh) {
      this.reading.textContent = "";
      return;
    }
    const { turns, heights_mm: heights } = this.told, i = hit.face.a;
    const value = this.told.cuts[side.choice.value][i];
    this.reading.textContent = `${side.choice.value}: ${value.toFixed(2).replace("-", "−")} µm at phi ` +
      `${Math.round(((i % turns) * 360) / turns)}°, h ${heights[Math.floor(i / turns)].toFixed(1)} mm`;
  }

  redraw() {
    this.draw();
  }
}

/// Without WebGL the still maps of the page stand for the part.
export function liveParts(figures) {
  if (hasWebGL()) return [...figures].map((figure) => new PartView(figure));
  for (const figure of figures) {
    const note = document.createElement("p");
    note.className = "note";
    note.textContent = "This browser draws no three-dimensional pictures (WebGL); the unrolled flank below shows the same.";
    figure.append(note);
  }
  return [];
}
