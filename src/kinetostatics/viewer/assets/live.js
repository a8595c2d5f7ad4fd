/* A page that computes: sliders and handles move platform, actuators and loads; `machine` computes the scene (engine.js). */

const FOLDS = { parameters: "Parameters", platform: "Move the platform", actuators: "Actuators", load: "Load at o", gravity: "Turn gravity", payload: "Payload" };
const UNITS = { mm: 1e-3, "°": Math.PI / 180 };
const REST = 150; // time without a motion [ms] after which the ends of sliders are computed
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const HANDLE_COLOURS = { x: "#d62728", y: "#2ca02c", z: "#1f77b4" };

let machine = null, busy = false; // busy: a motion is to be shown
let wanted = []; // [slider, value] of motions not yet computed, in order
let resting = null; // the timer of the ends of sliders

function buildLive() {
  document.body.classList.add("live");
  machine = page.machine;
  window.kinetostatics = { analyze: (given) => machine.analyze(given) };
  const parents = new Map();
  page.controls = [...parameterSliders(), ...slidersOf("platform"), ...slidersOf("actuators"), ...loadSliders()];
  for (const c of page.controls) {
    if (!parents.has(c.kind)) {
      parents.set(c.kind, fold(FOLDS[c.kind], ["parameters", "platform", "actuators", "load"].includes(c.kind)));
      if (c.kind === "platform") make("p", parents.get(c.kind), { className: "hint", textContent: "Drag the arrows and rings at o, the load's arrow, or the sliders." });
    }
    const { input } = slider(parents.get(c.kind), c.name, c.name.replace(/^[^:]*: /, ""), c.value, c.min, c.max, (x) => moveLive(c.name, x), (x) => inDigits(c, x));
    if (c.texts) input.step = 1;
    else input.addEventListener("change", () => lengthen(c.name));
    if (c.reach) showReach(c.name, c);
  }
}

/** Sliders of numbers of the robot; their values are places in a list. */
const parameterSliders = () => machine.data.sliders.map(({ name, texts, at }) => ({ kind: "parameters", coordinate: name, name: `parameters: ${name}`, texts, value: at, min: 0, max: texts.length - 1 }));

/** Sliders of the coordinates of a kind, with the ranges that the robot reaches from the present pose. */
function slidersOf(kind) {
  const line = machine.lines[kind];
  if (!line) return [];
  const { size } = page.robots[0].scene, present = machine.present(kind);
  return line.names.map((coordinate, k) => {
    const unit = line.turns[k] ? "°" : "mm", factor = UNITS[unit], step = line.turns[k] ? 0.01 : 0.1;
    const c = { kind, coordinate, unit, factor, step, name: `${kind === "platform" ? "platform" : "actuator"}: ${coordinate} [${unit}]`, value: present[k] / factor };
    Object.assign(c, reachOf(c));
    const [low, high] = c.reach, beyond = high - low < 10 * step ? [1, 1].map(() => (line.turns[k] ? 30 : 0.15 * size / factor)) : c.ends.map((why) => (why ? 0.05 * (high - low) : 0));
    const tick = 10 ** (Math.floor(Math.log10(high - low + beyond[0] + beyond[1])) - 1);
    return { ...c, min: tick * Math.floor((low - beyond[0]) / tick + 1e-6), max: tick * Math.ceil((high + beyond[1]) / tick - 1e-6) };
  });
}

/** Sliders of the load, of gravity's direction, and of a payload. */
function loadSliders() {
  const { load, gravity, payload } = machine.loads, { mass } = machine.data, { size } = page.robots[0].scene;
  const force = Math.max(2 * largestOf(load.slice(0, 3)), 9.81 * mass, 100), rows = [];
  const add = (kind, coordinate, unit, factor, value, most, least = -most) => {
    const step = 10 ** (Math.floor(Math.log10(most)) - 2), end = (x) => Math.sign(x) * Math.ceil(Math.abs(x) / step - 1e-9) * step;
    rows.push({ kind, coordinate, unit, factor, step, name: `${kind}: ${coordinate} [${unit}]`, value, min: end(least), max: end(most) });
  };
  ["Fx", "Fy", "Fz", "Mx", "My", "Mz"].forEach((name, k) => {
    if (k < 3) add("load", name, "N", 1, load[k], force);
    else add("load", name, "N·m", 1, load[k], Math.max(2 * largestOf(load.slice(3)), 0.25 * force * size));
  });
  machine.upright = gravity;
  for (const name of ["about x", "about y"]) if (largestOf(gravity) > 0) add("gravity", name, "°", UNITS["°"], 0, 180);
  add("payload", "mass", "kg", 1, payload[0], Math.max(2 * payload[0], mass, 10), 0);
  ["x", "y", "z"].forEach((name, k) => add("payload", name, "mm", 1e-3, 1e3 * payload[1 + k], 1e3 * Math.max(size, 2 * Math.abs(payload[1 + k]))));
  return rows;
}

/** A value of a slider, with significant digits. */
const inDigits = (c, x) => (c.texts ? c.texts[x] : fixed(x, c.step < 0.1 ? 2 : c.step < 1 ? 1 : 0));

/** Show the error and the warnings over the picture, where they do not shift the sliders: of several warnings the first, until opened. */
function writeMessage({ notes }) {
  const place = element("robot-message"), [words, warnings] = place.children;
  words.textContent = page.stop || page.error || "";
  warnings.hidden = !notes.length;
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

const controlOf = (name) => page.controls.find((c) => c.name === name);

/** The words for the end of a line. */
function wordsOf({ reason, joint, limit }) {
  if (reason !== "limit") return WORDS[reason] || "";
  const [factor, unit] = joint.slides ? [1e-3, "\u00a0mm"] : [Math.PI / 180, "°"];
  return `limit of ${joint.name}, ${typeset(Number((Math.round(10 * limit / factor) / 10 + 0).toPrecision(6)))}${unit}`;
}

/** The ends of a slider of a coordinate, {reach, ends}: the robot moves from the present pose, and only this coordinate changes. */
function reachOf({ kind, coordinate, factor, unit }) {
  const { names } = machine.lines[kind], here = machine.present(kind), k = names.indexOf(coordinate);
  const span = unit === "mm" ? machine.robot.size : Math.PI;
  const both = [-span, span].map((way) => {
    const end = machine.lastOnLine(kind, machine.pose, here.map((value, n) => (n === k ? value + way : value)), 32);
    return { value: end.joint && end.joint.name === coordinate ? end.limit : here[k] + end.part * way, why: wordsOf(end) };
  });
  return { reach: both.map(({ value }) => value / factor), ends: both.map(({ why }) => why) };
}

/** Colour the track of a slider outside its reachable range; its tooltip gives the reasons. */
function showReach(name, { reach, ends }) {
  const { input } = controls.get(name), c = controlOf(name), least = Number(input.min), span = Number(input.max) - least;
  reaches.set(name, { reach, ends });
  known.add(name);
  reach.forEach((value, k) => input.style.setProperty(k ? "--high" : "--low", ends[k] ? Math.min(Math.max((value - least) / span, 0), 1) : k ? 2 : -1));
  input.title = ends.map((why, k) => why && `${k ? "up" : "down"} to ${inDigits(c, reach[k])}: ${why}`).filter(Boolean).reverse().join("\n");
}

/** The reachable value nearest to a requested one; `page.stop` is the reason for a difference. */
function within(name, value) {
  const { reach, ends } = (known.has(name) && reaches.get(name)) || { reach: [-Infinity, Infinity], ends: ["", ""] };
  const end = value < reach[0] ? 0 : value > reach[1] ? 1 : null;
  page.stop = null;
  if (end === null || !ends[end]) return value;
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

/** Compute the ends of all sliders at the present pose, one after the other, until the robot moves. */
function findReach(left = [...reaches.keys()]) {
  clearTimeout(resting);
  if (!left.length) { page.rested += 1; return; }
  resting = setTimeout(() => {
    showReach(left[0], reachOf(controlOf(left[0])));
    findReach(left.slice(1));
  }, left.length === reaches.size ? REST : 0);
}

// ---------------------------------------------------------------- motions

/** Move a slider or handle; the picture follows with the next frame. */
function moveLive(name, value) {
  const held = within(name, value);
  if (held !== value) controls.get(name).set(held);
  if (held === controlOf(name).value && page.stop) { refresh(); return; }
  wanted = [...wanted.filter(([other]) => other !== name), [name, held]];
  if (busy) return;
  busy = true;
  requestAnimationFrame(() => { try { showMotions(); } finally { busy = false; } });
}

/** Compute the motions that are wanted, and show the pose. */
function showMotions() {
  const motions = wanted;
  wanted = [];
  page.error = null;
  for (const [name, value] of motions) {
    const c = controlOf(name);
    if (c.kind === "parameters") { varyTo(c, value); continue; }
    c.value = value;
    if (c.kind in machine.lines) {
      known.clear();
      known.add(name);
      const end = machine.move(c.kind, { [c.coordinate]: value * c.factor });
      if (end.reason) page.error = `${c.coordinate} stops at ${inDigits(c, machine.present(c.kind)[machine.lines[c.kind].names.indexOf(c.coordinate)] / c.factor)}${c.unit === "°" ? "" : "\u00a0"}${c.unit}: ${wordsOf(end)}`;
    } else setLoads();
  }
  showAnswer();
  page.answers += 1;
  findReach();
}

/** Vary a number of the robot, place by place; at a place that it cannot have at this pose it keeps the one before. */
function varyTo(c, value) {
  while (c.value !== value) {
    const way = Math.sign(value - c.value), sliders = page.controls.filter(({ kind }) => kind === "parameters");
    let place = c.value + way;
    const number = () => sliders.reduce((all, other) => all * other.texts.length + (other === c ? place : other.value), 0);
    while (place !== value && !machine.vary(number())) place += way;
    if (place === value && !machine.vary(number())) {
      page.error = `${c.name.replace(/^[^:]*: /, "")} cannot be ${c.texts[value]} here: the robot cannot be assembled at this pose, or other formulas apply`;
      break;
    }
    c.value = place;
  }
  known.clear();
  page.robots[0].load({ meshes: machine.data.meshes.map((mesh, k) => ({ ...mesh, ...machine.data.shapes[machine.robot.shapes[k]] })) });
}

/** Set the machine's loads to those of the sliders. */
function setLoads() {
  const of = (kind) => page.controls.filter((c) => c.kind === kind).map((c) => c.value * c.factor), [a = 0, b = 0] = of("gravity"), [x, y, z] = machine.upright;
  const turned = [x, y * Math.cos(a) - z * Math.sin(a), y * Math.sin(a) + z * Math.cos(a)];
  const gravity = a || b ? [turned[0] * Math.cos(b) + turned[2] * Math.sin(b), turned[1], turned[2] * Math.cos(b) - turned[0] * Math.sin(b)] : machine.upright;
  machine.loads = { load: of("load"), gravity, payload: of("payload") };
}

/** Show the scene of the present pose and loads, and the values of all sliders. */
function showAnswer() {
  const scene = sceneOf(machine, page.robots[0].scene.size);
  if (page.held) for (const arrow of scene.arrows) if (arrow.path === page.held.path) arrow.metres_per_unit = page.held.metres_per_unit;
  page.robots[0].load(scene);
  for (const kind of Object.keys(machine.lines)) machine.present(kind).forEach((value, k) => {
    const c = page.controls.find((other) => other.kind === kind && other.coordinate === machine.lines[kind].names[k]);
    c.value = value / c.factor;
  });
  for (const c of page.controls) {
    extendTrack(controls.get(c.name).input, c);
    controls.get(c.name).set(c.value);
  }
  refresh();
  if (stillFits() && !page.held && !isInPicture()) fit();
}

/** Extend a track to a value. */
function extendTrack(input, { name, value }) {
  if (value < Number(input.min)) input.min = value;
  if (value > Number(input.max)) input.max = value;
  if (reaches.has(name) && known.has(name)) showReach(name, reaches.get(name));
}

// ---------------------------------------------------------------- handles at the platform

/** Add handles at o for coordinates with sliders: double arrows along x, y, z, and rings for rx, ry, rz. */
function buildHandles() {
  const { scene } = page.robots[0], reach = 0.2 * scene.size;
  for (const control of page.controls) {
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

/** Start dragging the handle or the load's arrow under the pointer, if any. */
function startDrag(event) {
  const { caster } = rayAt(event.clientX, event.clientY), hit = ({ object }) => caster.intersectObject(object, true)[0];
  if (event.button !== 0) return;
  const hits = handles.map((handle) => ({ handle, at: hit(handle) })).filter(({ at }) => at).sort((a, b) => a.at.distance - b.at.distance);
  const arrow = hits.length ? null : page.robots[0].arrows.get("Arrows/external load/load force");
  const follow = hits.length ? turnOrShift(hits[0].handle, event) : arrow && arrow.object.seen && visible(arrow.object) && hit(arrow) ? pullLoad(arrow) : null;
  if (!follow) return;
  event.stopPropagation(); // the camera does not turn
  event.preventDefault();
  const release = () => {
    window.removeEventListener("pointermove", follow);
    window.removeEventListener("pointerup", release);
    if (page.held) { page.held = null; showAnswer(); }
  };
  window.addEventListener("pointermove", follow);
  window.addEventListener("pointerup", release);
}

/** The function that moves a handle with the pointer. */
function turnOrShift(handle, event) {
  const start = handle.object.position.clone(), value = Number(controls.get(handle.control).input.value);
  let last = measure(handle, start, event.clientX, event.clientY), moved = 0;
  return (e) => {
    const at = measure(handle, start, e.clientX, e.clientY);
    if (at === null || last === null) { last = at; return; }
    moved += handle.turns ? ((at - last + 540) % 360) - 180 : at - last;
    last = at;
    extendTrack(controls.get(handle.control).input, { name: handle.control, value: within(handle.control, value + moved) });
    controls.get(handle.control).set(value + moved);
    moveLive(handle.control, value + moved);
  };
}

/** The function that moves the tail of the load's arrow with the pointer, in the plane of the picture; meanwhile its scale is kept. */
function pullLoad({ spec }) {
  const { now, scene } = page.robots[0], o = new THREE.Vector3().fromArray(now.deformed, 7 * scene.readout);
  const tail = new THREE.Vector3(...machine.loads.load.slice(0, 3)).multiplyScalar(-spec.metres_per_unit).add(o);
  page.held = { path: spec.path, metres_per_unit: spec.metres_per_unit };
  return (e) => {
    const { ray } = rayAt(e.clientX, e.clientY), plane = new THREE.Plane().setFromNormalAndCoplanarPoint(viewDirection(), tail);
    const at = ray.intersectPlane(plane, new THREE.Vector3());
    if (!at) return;
    o.clone().sub(at).divideScalar(page.held.metres_per_unit).toArray().forEach((force, k) => {
      const { name } = page.controls.find((c) => c.kind === "load" && c.coordinate === ["Fx", "Fy", "Fz"][k]);
      moveLive(name, force);
    });
  };
}

/** The direction in which the camera looks, world axes. */
function viewDirection() {
  const d = viewer.camera.getWorldDirection(new THREE.Vector3());
  return new THREE.Vector3(d.x, -d.z, d.y);
}
