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

/** Rectangles of the window that panel, legend and sliders leave free: [left, right, top, bottom]. */
function freeRectangles() {
  const width = viewer.dom_element.offsetWidth, height = window.innerHeight, margin = 14;
  const edge = (selector) => { const e = document.querySelector(selector); return e && e.offsetWidth ? e.getBoundingClientRect() : null; };
  const panel = edge("#robot-panel"), legend = edge("#robot-legend"), gui = edge(".dg.main");
  const right = (gui && gui.left > 0.5 * width ? gui.left : width) - margin, top = 2 * margin, bottom = height - 2 * margin;
  const all = [
    [Math.max(panel.right, legend.right) + margin, right, top, bottom], // beside both
    [margin, right, panel.bottom + margin, legend.top - margin], // between them
    [legend.right + margin, right, panel.bottom + margin, bottom], // below the panel
  ].filter(([l, r, t, b]) => r - l > 0.2 * width && b - t > 0.2 * height);
  return all.length ? all : [[margin, right, top, bottom]];
}

/** Look at the robot from the direction (x, y, z), where it fits largest. */
function look(x, y, z) {
  const camera = viewer.camera, points = outline();
  const box = new THREE.Box3().setFromPoints(points), centre = box.getCenter(new THREE.Vector3());
  const radius = 0.5 * box.getSize(new THREE.Vector3()).length() || 1;
  const d = new THREE.Vector3(x, z, -y).normalize();
  const right = (Math.hypot(x, y) > 1e-6 ? new THREE.Vector3(0, 1, 0).cross(d) : new THREE.Vector3(1, 0, 0)).normalize();
  const up = d.clone().cross(right), width = viewer.dom_element.offsetWidth, height = window.innerHeight;
  camera.fov = 32; camera.near = radius / 50; camera.far = radius * 80;
  const f = height / 2 / Math.tan(camera.fov * Math.PI / 360);
  const local = points.map((p) => { const q = p.clone().sub(centre); return [q.dot(right), q.dot(up), q.dot(d)]; });
  const span = (distance, c) => {
    const values = local.map((q) => f * q[c] / (distance - q[2]));
    return [Math.min(...values), Math.max(...values)];
  };
  const nearest = ([l, r, t, b]) => { // the nearest distance at which everything fits
    let near = 1.05 * radius, far = 40 * radius;
    for (let n = 0; n < 30; n++) {
      const middle = (near + far) / 2, [left, end] = span(middle, 0), [low, high] = span(middle, 1);
      if (end - left > r - l || high - low > b - t) near = middle; else far = middle;
    }
    return far;
  };
  const best = freeRectangles().map((rectangle) => [nearest(rectangle), rectangle]).reduce((a, b) => (b[0] < 0.97 * a[0] ? b : a));
  const [distance, [l, r, t, b]] = best, [left, end] = span(distance, 0), [low, high] = span(distance, 1);
  const sideways = ((left + end) / 2 - ((l + r) / 2 - width / 2)) * distance / f;
  const upwards = ((low + high) / 2 - (height / 2 - (t + b) / 2)) * distance / f;
  viewer.controls.target.copy(centre).addScaledVector(right, sideways).addScaledVector(up, upwards);
  camera.position.copy(viewer.controls.target).addScaledVector(d, distance);
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
  ramp = description.ramp.map((hex) => new THREE.Color(hex));
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
