/* Live pages: sliders and handles at the platform request analyses from the program. */

let busy = false, stale = false, wake = () => {}; // stale: notes and cards are those of an earlier pose
const waiting = new Map(); // kind -> its latest request
const REST = 100; // time without a request [ms] after which notes and cards are requested
const pause = () => new Promise((done) => { wake = done; setTimeout(done, REST); });

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const HANDLE_COLOURS = { x: "#d62728", y: "#2ca02c", z: "#1f77b4" };

function buildLive() {
  document.body.classList.add("live");
  const { live } = page.robots[0].scene, folds = { platform: "Move the platform", actuators: "Actuators", load: "Load at o" };
  for (const [kind, title] of Object.entries(folds)) {
    const mine = live.controls.filter((control) => control.kind === kind);
    if (!mine.length) continue;
    const parent = fold(title);
    if (kind === "platform") make("p", parent, { className: "hint", textContent: "Drag the arrows and rings at o, or the sliders." });
    for (const c of mine) {
      const { input } = slider(parent, c.name, c.name.replace(/^[^:]*: /, ""), c.value, c.min, c.max, (x) => moveLive(c.name, x), (x) => inDigits(c, x));
      input.addEventListener("change", () => lengthen(c.name));
      if (c.reach) showReach(c.name, c);
    }
  }
  for (const name of reaches.keys()) known.add(name);
}

/** A value of a slider, with significant digits. */
const inDigits = (c, x) => fixed(x, c.step < 0.1 ? 2 : c.step < 1 ? 1 : 0);

/** Show the error and the warnings over the picture, where they do not shift the sliders: of several warnings the first, until opened.
 * Without loads, the reason is in place of the twist. */
function writeMessage({ unloaded, notes }) {
  const place = element("robot-message"), [words, warnings] = place.children;
  words.textContent = page.stop || page.error || "";
  if (unloaded) element("robot-reason").textContent = notes.join("; ");
  warnings.hidden = unloaded || !notes.length;
  words.hidden = !words.textContent;
  if (!warnings.hidden) {
    const [summary, all] = warnings.children;
    summary.textContent = notes.length > 1 ? `${notes.length} warnings: ${notes[0]}` : `warning: ${notes[0]}`;
    all.innerHTML = notes.map((note) => `<p>${escape(note)}</p>`).join("");
  }
  place.hidden = words.hidden && warnings.hidden;
}

// ---------------------------------------------------------------- reachable ranges of sliders

const reaches = new Map(); // name of a slider -> {reach: [low, high], ends: reasons for its two ends}
const known = new Set(); // names of sliders whose range is that of the present pose

const controlOf = (name) => page.robots[0].scene.live.controls.find((c) => c.name === name);

/** Colour the track of a slider outside its reachable range; its tooltip gives the reasons. */
function showReach(name, { reach, ends }) {
  const { input } = controls.get(name), c = controlOf(name), least = Number(input.min), span = Number(input.max) - least;
  reaches.set(name, { reach, ends });
  reach.forEach((value, k) => input.style.setProperty(k ? "--high" : "--low", ends[k] ? Math.min(Math.max((value - least) / span, 0), 1) : k ? 2 : -1));
  input.title = ends.map((why, k) => why && `${k ? "up" : "down"} to ${inDigits(c, reach[k])}: ${why}`).filter(Boolean).reverse().join("\n");
}

/** The reachable value nearest to a requested one; `page.stop` is the reason for a difference. */
function within(name, wanted) {
  const { reach, ends } = (known.has(name) && reaches.get(name)) || { reach: [-Infinity, Infinity], ends: ["", ""] };
  const end = wanted < reach[0] ? 0 : wanted > reach[1] ? 1 : null;
  page.stop = null;
  if (end === null || !ends[end]) return wanted;
  const c = controlOf(name), [, label, unit] = name.match(/^[^:]*: (.*) \[(.*)\]$/);
  const place = `${inDigits(c, reach[end])}${unit === "°" ? "" : "\u00a0"}${unit}`, stands = reach[1] - reach[0] < c.step;
  page.stop = stands ? `${label} cannot change by itself here: ${ends[end]}` : `${label} ends at ${place}: ${ends[end]}`;
  return reach[end];
}

/** Extend the track of a slider released at an end of its track, if the robot reaches further. */
function lengthen(name) {
  const { input } = controls.get(name), { reach } = reaches.get(name) || { reach: [Infinity, -Infinity] };
  const value = Number(input.value), least = Number(input.min), most = Number(input.max), near = 0.02 * (most - least);
  const spare = 0.05 * (reach[1] - reach[0]);
  if (value - least < near && reach[0] < least) input.min = reach[0] - spare;
  if (most - value < near && reach[1] > most) input.max = reach[1] + spare;
  if (reaches.has(name)) showReach(name, reaches.get(name));
}

/** The program's response to a request. */
async function answerTo(request) {
  const { url } = page.robots[0].scene.live;
  const answer = await fetch(url, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(request) });
  return answer.json();
}

/** Request the ends of the sliders at the present pose, which takes longer than an analysis; outdated responses are ignored. */
async function requestReach() {
  const at = page.answers;
  if (!reaches.size) return;
  try {
    const found = await answerTo({ kind: "reach" });
    if (busy || page.answers !== at || found.error) return;
    for (const [name, reach] of Object.entries(found)) { showReach(name, reach); known.add(name); }
  } catch { /* the next request reports a missing response */ }
}

/** Request an analysis for a moved slider or handle. One request is sent at a time; the latest of each kind waits. */
async function moveLive(name, value) {
  const { live, contributions } = page.robots[0].scene, moved = controlOf(name), values = {}, held = within(name, value);
  if (held !== value) controls.get(name).set(held);
  if (held === moved.value && page.stop) { refresh(); return; }
  moved.value = held;
  for (const other of known) if (other !== name) known.delete(other);
  for (const c of live.controls) if (c.kind === moved.kind) values[c.coordinate] = c.value;
  const details = selection.path !== null || state.quantity !== "deflection"; // a card or beams show them
  waiting.set(moved.kind, { kind: moved.kind, values, details, contributions });
  wake();
  if (busy) return;
  busy = true;
  try {
    while (waiting.size || stale) {
      if (!waiting.size) await pause();
      const [request] = waiting.size ? waiting.values() : [{ kind: "details" }];
      waiting.delete(request.kind);
      stale = request.kind !== "details" && !request.details;
      const body = await answerTo(request);
      if (request.kind !== "details") page.error = body.error || body.rim || null;
      if (body.error) refresh(); else showAnswer(body);
      if (request.kind === "details" && !waiting.size && stillFits() && !isInPicture()) fit();
    }
  } catch (error) {
    page.error = `no answer: has the program ended? (${error.message})`;
    refresh();
  } finally {
    busy = false;
    page.answers += 1;
  }
  requestReach();
}

/** Show a new scene and the values of all sliders, without a new request. */
function showAnswer(description) {
  if (description.meshes) replaceRobot(description); else page.robots[0].load(description);
  for (const c of page.robots[0].scene.live.controls) {
    if (waiting.has(c.kind)) { c.value = waiting.get(c.kind).values[c.coordinate]; continue; } // a later request is waiting
    const { input, set } = controls.get(c.name);
    if (c.value < Number(input.min) || c.value > Number(input.max)) extendTrack(input, c);
    set(c.value);
  }
  refresh();
}

/** Extend a track to a value. */
function extendTrack(input, { name, value }) {
  if (value < Number(input.min)) input.min = value;
  if (value > Number(input.max)) input.max = value;
  if (reaches.has(name)) showReach(name, reaches.get(name));
}

/** Replace a robot with loads by one without, or the reverse; sliders and camera remain. */
function replaceRobot(description) {
  select(null);
  page.robots[0].remove();
  page.robots[0] = new Robot(description);
  hideGroups(page.robots[0]);
  setExaggeration(description.exaggeration);
  buildTwist();
  buildArrows();
  setDark(page.dark);
}

// ---------------------------------------------------------------- handles at the platform

/** Add handles at o for coordinates with sliders: double arrows along x, y, z, and rings for rx, ry, rz. */
function buildHandles() {
  const { scene } = page.robots[0], reach = 0.2 * scene.size;
  for (const control of scene.live.controls) {
    const [, turns, letter] = control.coordinate.match(/^(r?)([xyz])$/) || [];
    if (control.kind !== "platform" || !letter) continue;
    const material = new THREE.MeshBasicMaterial({ color: HANDLE_COLOURS[letter], transparent: true, opacity: 0.75, depthTest: false });
    const part = (geometry) => Object.assign(new THREE.Mesh(geometry, material), { renderOrder: 20 });
    const object = new THREE.Group(), along = new THREE.Vector3(...AXES[letter]);
    if (turns) {
      object.add(part(new THREE.TorusGeometry(0.85 * reach, 0.035 * reach, 10, 60)));
      object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along);
    } else {
      object.add(part(new THREE.CylinderGeometry(0.03 * reach, 0.03 * reach, 2 * reach, 12)));
      for (const side of [1, -1]) {
        const cone = part(new THREE.ConeGeometry(0.09 * reach, 0.25 * reach, 16));
        cone.position.y = 1.1 * side * reach;
        if (side < 0) cone.rotation.x = Math.PI;
        object.add(cone);
      }
      object.quaternion.setFromUnitVectors(UP, along);
    }
    viewer.set_object(["Handles", control.coordinate], object);
    handles.push({ control: control.name, turns: Boolean(turns), axis: along, object });
  }
  stage.addEventListener("pointerdown", startDrag, { capture: true });
}

function placeHandles() {
  const { now, scene } = page.robots[0];
  for (const { object } of handles) object.position.fromArray(now.deformed, 7 * scene.readout);
}

/** The ray through a position of the window, in world axes. */
function rayAt(x, y) {
  const box = stage.getBoundingClientRect(), caster = new THREE.Raycaster(), turned = (v) => new THREE.Vector3(v.x, -v.z, v.y);
  caster.setFromCamera({ x: 2 * (x - box.left) / box.width - 1, y: 1 - 2 * (y - box.top) / box.height }, viewer.camera);
  return { caster, ray: new THREE.Ray(turned(caster.ray.origin), turned(caster.ray.direction)) };
}

/** The coordinate of a position of the window along a handle's axis [mm], or its angle about the axis [°]; null if undefined. */
function measure({ turns, axis }, start, x, y) {
  const { ray } = rayAt(x, y);
  if (turns) {
    const hit = ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(axis, start), new THREE.Vector3());
    if (!hit) return null;
    const u = new THREE.Vector3(axis.y, axis.z, axis.x), v = axis.clone().cross(u), arm = hit.sub(start);
    return Math.atan2(arm.dot(v), arm.dot(u)) * 180 / Math.PI;
  }
  const between_ = ray.origin.clone().sub(start), d = ray.direction, b = d.dot(axis), denominator = 1 - b * b;
  return denominator < 1e-4 ? null : 1e3 * (between_.dot(axis) - b * between_.dot(d)) / denominator; // point of the axis nearest to the ray
}

/** Start dragging the handle under the pointer, if any. */
function startDrag(event) {
  const { caster } = rayAt(event.clientX, event.clientY);
  const hits = handles.map((handle) => ({ handle, hit: caster.intersectObject(handle.object, true)[0] })).filter(({ hit }) => hit);
  if (!hits.length || event.button !== 0) return;
  event.stopPropagation(); // the camera does not turn
  event.preventDefault();
  const [{ handle }] = hits.sort((a, b) => a.hit.distance - b.hit.distance), start = handle.object.position.clone();
  const { input } = controls.get(handle.control), value = Number(input.value);
  let last = measure(handle, start, event.clientX, event.clientY), moved = 0;
  const follow = (e) => {
    const at = measure(handle, start, e.clientX, e.clientY);
    if (at === null || last === null) { last = at; return; }
    moved += handle.turns ? ((at - last + 540) % 360) - 180 : at - last;
    last = at;
    const wanted = value + moved;
    extendTrack(input, { name: handle.control, value: within(handle.control, wanted) });
    controls.get(handle.control).set(wanted);
    moveLive(handle.control, wanted);
  };
  const release = () => {
    window.removeEventListener("pointermove", follow);
    window.removeEventListener("pointerup", release);
  };
  window.addEventListener("pointermove", follow);
  window.addEventListener("pointerup", release);
}
