/* Camera, size of the picture, dark colours and keys. */

const VIEWS = { home: null, front: [0, -1, 0], side: [1, 0, 0], top: [0, 0, 1] }; // directions to the camera, world axes

const stage = viewer.dom_element;
const handles = []; // of live pages: {control, turns, axis, object}
let fitted = null; // {distance, target} of the camera after the last fit

/** The points that a picture must contain, in the axes of three.js (y up): present vertices, stations of all frames, tips of arrows and axes. */
function outline() {
  const points = [];
  viewer.scene.updateMatrixWorld(true);
  for (const robot of page.robots) {
    const { frames, pose, twist } = robot.scene.stations, e = state.exaggeration;
    for (const { mesh } of robot.solids.values()) {
      if (!visible(mesh)) continue;
      const p = mesh.geometry.attributes.position;
      for (let v = 0; v < p.count; v += 1 + Math.floor(p.count / 2000)) points.push(new THREE.Vector3().fromBufferAttribute(p, v).applyMatrix4(mesh.matrixWorld));
    }
    if (frames > 1) for (let o = 0; o < pose.length; o += 7) points.push(new THREE.Vector3(pose[o], pose[o + 2], -pose[o + 1]));
    if (state.mode) for (let t = 0, K = robot.scene.modes.length; t < twist.length; t += 6) for (const sign of [e, -e]) { // both ends of all modes
      const o = 7 * Math.floor(t / 6 / K);
      points.push(new THREE.Vector3(pose[o] + sign * twist[t], pose[o + 2] + sign * twist[t + 2], -pose[o + 1] - sign * twist[t + 1]));
    }
    for (const { object, tip } of robot.arrows.values()) if (object.seen && visible(object)) points.push(tip.getWorldPosition(new THREE.Vector3()));
    for (const { spec, object } of robot.frames.values()) {
      if (spec.size && visible(object)) for (const tip of [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) points.push(new THREE.Vector3(...tip).multiplyScalar(spec.size).applyMatrix4(object.matrixWorld));
    }
  }
  for (const { object } of handles) for (const part of object.children) points.push(part.getWorldPosition(new THREE.Vector3()));
  return points.length ? points : [new THREE.Vector3()];
}

/** Place the camera in the direction (x, y, z), world axes, so that the robot fills the picture. */
function look(x, y, z) {
  const camera = viewer.camera, points = outline(), margin = 18;
  const box = new THREE.Box3().setFromPoints(points), centre = box.getCenter(new THREE.Vector3());
  const radius = 0.5 * box.getSize(new THREE.Vector3()).length() || 1;
  const d = new THREE.Vector3(x, z, -y).normalize();
  const right = (Math.hypot(x, y) > 1e-3 * Math.abs(z) ? new THREE.Vector3(0, 1, 0).cross(d) : new THREE.Vector3(1, 0, 0)).normalize();
  const up = d.clone().cross(right), [{ width }] = panes(), height = stage.offsetHeight;
  const w = Math.max(width - 2 * margin, 0.5 * width), h = Math.max(height - 2 * margin, 0.5 * height);
  camera.fov = page.robots[0].scene.field_of_view; camera.near = radius / 50; camera.far = radius * 80;
  const f = height / 2 / Math.tan(camera.fov * Math.PI / 360);
  const local = points.map((p) => { const q = p.clone().sub(centre); return [q.dot(right), q.dot(up), q.dot(d)]; });
  // a point (x, z) is visible if |x - s| <= k (D - z), linear in the shift s and the distance D of the camera
  const [across, along] = [w, h].map((pixels, c) => {
    const k = pixels / 2 / f;
    let most = -Infinity, least = Infinity;
    for (const q of local) { most = Math.max(most, q[c] + k * q[2]); least = Math.min(least, q[c] - k * q[2]); }
    return { shift: (most + least) / 2, distance: (most - least) / 2 / k };
  });
  const distance = Math.max(across.distance, along.distance);
  viewer.controls.target.copy(centre).addScaledVector(right, across.shift).addScaledVector(up, along.shift);
  camera.position.copy(viewer.controls.target).addScaledVector(d, distance);
  viewer.controls.update();
  fitted = { distance, target: viewer.controls.target.clone() };
  viewer.set_dirty();
}

/** Whether the whole robot is in the picture. */
function isInPicture() {
  return outline().every((p) => { p.project(viewer.camera); return Math.abs(p.x) < 1 && Math.abs(p.y) < 1; });
}

/** Fit the robot into the picture, from the present direction. */
function fit() {
  const d = viewer.camera.position.clone().sub(viewer.controls.target);
  look(d.x, -d.z, d.y);
}

function showView(name) {
  look(...(VIEWS[name] || page.robots[0].scene.view));
}

/** Whether the camera has only been turned since the last fit. */
function stillFits() {
  const distance = viewer.camera.position.distanceTo(viewer.controls.target);
  return fitted && Math.abs(distance / fitted.distance - 1) < 1e-3 && viewer.controls.target.distanceTo(fitted.target) < 1e-3 * distance;
}

/** Keep the canvas at the size of its part of the page; meshcat would use that of the window. */
function watchSize() {
  const set = viewer.set_3d_pane_size.bind(viewer);
  viewer.set_3d_pane_size = () => {
    const height = Math.max(stage.offsetHeight, 1);
    set(Math.max(stage.offsetWidth, 1), height);
    viewer.camera.aspect = Math.max(panes()[0].width, 1) / height;
    viewer.camera.updateProjectionMatrix();
  };
  viewer.set_3d_pane_size();
  new ResizeObserver(() => {
    viewer.set_3d_pane_size();
    if (page.ready && stillFits()) fit();
    viewer.render(); // resizing clears the canvas
  }).observe(stage);
}

// ---------------------------------------------------------------- light and dark

const prefersDark = window.matchMedia("(prefers-color-scheme: dark)");

/** A colour of labels and arrows, lighter on dark pages. */
function shade(colour) {
  const c = new THREE.Color(colour);
  return page.dark ? c.lerp(new THREE.Color(1, 1, 1), 0.45) : c;
}

function setDark(dark) {
  page.dark = dark;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  const background = new THREE.Color(dark ? "#14181f" : "#ffffff").toArray();
  for (const end of ["top_color", "bottom_color"]) viewer.set_property(["Background"], end, background);
  for (const robot of page.robots) for (const { object } of robot.arrows.values()) object.paint(shade);
  for (const { element, leader, colour } of labels) for (const item of [element, leader]) item.style.setProperty("--colour", `#${shade(colour).getHexString()}`);
  viewer.set_dirty();
}

// ---------------------------------------------------------------- keyboard

const KEYS = [ // key, description, action
  ["f", "fit the robot into the picture", fit],
  ["0", "view: home", () => showView("home")],
  ["1", "view: front", () => showView("front")],
  ["2", "view: side", () => showView("side")],
  ["3", "view: top", () => showView("top")],
  ["+", "larger displacements", () => scaleBy(1.25)],
  ["-", "smaller displacements", () => scaleBy(0.8)],
  ["r", "robot at rest on or off", () => toggle("Rest")],
  ["a", "forces and moments on or off", () => toggle("Arrows")],
  ["l", "names on or off", () => toggle("Labels")],
  [" ", "play or pause a path or mode", () => { if (controls.has("path")) playOrPause(); }],
  ["c", "colour by the next quantity", () => nextQuantity()],
  ["i", "save an image with legend (PNG)", () => savePicture()],
  ["d", "dark or light", () => setDark(!page.dark)],
  ["p", "panel on or off", () => document.body.classList.toggle("without-panel")],
  ["?", "these keys", () => showHelp()],
  ["Escape", "close help or card", () => closeAll()],
];
const KEY_NAMES = { " ": "space", Escape: "Esc" };

function watchKeys() {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target, typing = target instanceof HTMLElement && target.matches("input:not([type=checkbox]), select, textarea");
    if (typing && event.key !== "Escape" && event.key !== "?") return;
    if (event.key === " " && target instanceof HTMLElement && target.matches("button, summary, input")) return; // the key presses them
    const found = KEYS.find(([key]) => key === event.key || key === event.key.toLowerCase());
    if (!found) return;
    event.preventDefault();
    found[2]();
  });
}
