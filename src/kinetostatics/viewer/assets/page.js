/* Start: needs meshcat's `viewer`, and the description in <script id="robot-scene">. */

/** Draw everything anew after a slider moved. */
function refresh() {
  const start = performance.now(), scale = roundUp(largest());
  now = solve();
  for (const solid of solids.values()) placeSolid(solid, scale);
  for (const arrow of arrows.values()) placeArrow(arrow);
  for (const { spec, object } of frames.values()) {
    object.position.fromArray(now.deformed, 7 * spec.station);
    object.quaternion.fromArray(now.deformed, 7 * spec.station + 3);
  }
  writePanel(scale);
  viewer.set_dirty();
  page.refreshTime = performance.now() - start;
}

/** Draw a description. Objects that are there already are updated in place, so sliders, camera and check boxes stay. */
function load(description) {
  scene = read(description);
  scene.meshes.forEach(addMesh);
  scene.frames.forEach(addFrame);
  scene.arrows.forEach(addArrow);
  scene.labels.forEach(addMark);
  const present = new Set(scene.arrows.map((spec) => spec.path));
  for (const [path, entry] of arrows) entry.gone = !present.has(path);
  state.time = Math.min(state.time, scene.stations.frames - 1);
  if (scene.live && page.ready) showLive();
  refresh();
}

/** White background, no grid, and lights to the size of the scene. */
function stage() {
  viewer.set_property(["Background"], "top_color", [1, 1, 1]);
  viewer.set_property(["Background"], "bottom_color", [1, 1, 1]);
  for (const name of ["Grid", "Axes"]) viewer.set_property([name], "visible", false);
  for (const name of ["PointLightNegativeX", "PointLightPositiveX"]) viewer.set_property(["Lights", name], "visible", false);
  const key = new THREE.DirectionalLight(0xffffff, 0.45);
  key.position.set(1, -2, 4);
  viewer.set_object(["Lights", "Key"], key);
  for (const path of scene.hidden) viewer.set_property(path.split("/"), "visible", false);
}

/** Every point that the picture must hold, in the axes of three.js (y up): vertices now, stations in all frames, ends of arrows and axes. */
function outline() {
  const points = [], pose = scene.stations.pose;
  viewer.scene.updateMatrixWorld(true);
  for (const { mesh } of solids.values()) {
    const p = mesh.geometry.attributes.position;
    for (let v = 0; v < p.count; v += 1 + Math.floor(p.count / 400)) points.push(new THREE.Vector3().fromBufferAttribute(p, v).applyMatrix4(mesh.matrixWorld));
  }
  if (scene.stations.frames > 1) for (let o = 0; o < pose.length; o += 7) points.push(new THREE.Vector3(pose[o], pose[o + 2], -pose[o + 1]));
  const visible = (object) => !object || (object.visible && visible(object.parent));
  for (const { object, tip } of arrows.values()) if (object.seen && visible(object)) points.push(tip.getWorldPosition(new THREE.Vector3()));
  for (const { spec, object } of frames.values()) {
    for (const tip of [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) if (spec.size) points.push(new THREE.Vector3(...tip).multiplyScalar(spec.size).applyMatrix4(object.matrixWorld));
  }
  return points;
}

/** Look at the robot from the direction (x, y, z), filling what panel and sliders leave free. */
function look(x, y, z) {
  const camera = viewer.camera, points = outline();
  const box = new THREE.Box3().setFromPoints(points), centre = box.getCenter(new THREE.Vector3());
  const radius = 0.5 * box.getSize(new THREE.Vector3()).length() || 1;
  const d = new THREE.Vector3(x, z, -y).normalize(), right = new THREE.Vector3(0, 1, 0).cross(d).normalize(), up = d.clone().cross(right);
  const width = viewer.dom_element.offsetWidth, height = window.innerHeight, margin = 14;
  const edge = (selector) => { const e = document.querySelector(selector); return e && e.offsetWidth ? e.getBoundingClientRect() : null; };
  const panel = edge("#robot-panel"), gui = edge(".dg.main");
  let left = margin, end = width - margin;
  if (panel && gui && end - panel.right - gui.width > 0.25 * width) [left, end] = [panel.right + margin, gui.left - margin];
  else if (panel && !gui && end - panel.right > 0.5 * width) left = panel.right + margin;
  else if (gui && end - gui.width > 0.5 * width) end = gui.left - margin;
  camera.fov = 32; camera.near = radius / 50; camera.far = radius * 80;
  const f = height / 2 / Math.tan(camera.fov * Math.PI / 360);
  const local = points.map((p) => { const q = p.clone().sub(centre); return [q.dot(right), q.dot(up), q.dot(d)]; });
  const span = (distance, c) => {
    const values = local.map((q) => f * q[c] / (distance - q[2]));
    return [Math.min(...values), Math.max(...values)];
  };
  let near = 1.05 * radius, far = 40 * radius;
  for (let n = 0; n < 40; n++) { // the nearest distance at which everything fits
    const middle = (near + far) / 2, [a, b] = span(middle, 0), [u, v] = span(middle, 1);
    if (b - a > end - left || v - u > height - 4 * margin) near = middle; else far = middle;
  }
  const [a, b] = span(far, 0), [u, v] = span(far, 1);
  const sideways = ((a + b) / 2 - ((left + end) / 2 - width / 2)) * far / f, upwards = (u + v) / 2 * far / f;
  viewer.controls.target.copy(centre).addScaledVector(right, sideways).addScaledVector(up, upwards);
  camera.position.copy(viewer.controls.target).addScaledVector(d, far);
  viewer.controls.update();
  viewer.set_3d_pane_size();
}

const page = window.robot_page = {
  state, solids, arrows, labels, answers: 0, error: null, refreshTime: 0, ready: false, look, readout,
  get stations() { return now; }, get scene() { return scene; },
};
{
  const description = JSON.parse(document.getElementById("robot-scene").textContent);
  state.exaggeration = description.exaggeration.value;
  state.shares = description.contributions.map(() => 1);
  buildPanel();
  load(description);
  stage();
  buildControls();
  look(...scene.view);
  const render = viewer.render.bind(viewer);
  viewer.render = () => { render(); placeLabels(); };
  viewer.set_dirty();
  page.ready = true;
}
