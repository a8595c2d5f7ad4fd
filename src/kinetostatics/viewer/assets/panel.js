/* The panel beside the robot, the line of facts above it and the legend below. */

/** A number's text with a typographic minus sign. */
const typeset = (text) => String(text).replace("-", "\u2212");

/** Three significant digits. */
function number(x) {
  const a = Math.abs(x);
  return a < 1e-5 ? "0" : typeset(a >= 1e6 ? x.toExponential(2) : a >= 100 ? x.toFixed(0) : x.toPrecision(3));
}

/** A number with given decimals, zero as 0. */
function fixed(x, decimals) {
  const text = x.toFixed(decimals);
  return Number(text) === 0 ? "0" : typeset(text);
}

function escape(text) {
  return String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" }[c]));
}

const element = (id) => document.getElementById(id);

function make(tag, parent = null, attributes = {}) {
  const made = Object.assign(document.createElement(tag), attributes);
  if (parent) parent.appendChild(made);
  return made;
}

/** Add a foldable section to the panel; return the parent of its content. */
function fold(title, open = true) {
  const details = make("details", element("robot-controls"), { open });
  make("summary", details, { textContent: title });
  return make("div", details);
}

const controls = new Map(); // name -> {set, input}

/** Add a slider with its value as text by `written`. */
function slider(parent, name, label, value, min, max, changed, written) {
  const row = make("label", parent, { className: "slider" });
  make("span", row, { textContent: label, title: name });
  const input = make("input", row, { type: "range", name, min, max, step: "any" });
  const output = make("output", row);
  const show = (x) => { output.textContent = written(x); };
  const control = { input, set: (x) => { input.value = x; show(x); } };
  input.addEventListener("input", () => { show(Number(input.value)); changed(Number(input.value)); });
  control.set(value);
  controls.set(name, control);
  return control;
}

let switches = []; // {paths, box, set, isOn}

/** Add a check box that shows and hides paths of meshcat's tree. */
function treeSwitch(parent, label, paths, colour = null) {
  const row = make("label", parent, { className: "switch" }), box = make("input", row, { type: "checkbox", name: label });
  if (colour) make("i", row).style.setProperty("--colour", colour);
  make("span", row, { textContent: label });
  const all = () => page.robots.filter((robot) => !isGhost(robot)).flatMap((robot) => paths.map((path) => (robot.root + path).split("/")));
  const set = (on) => { for (const path of all()) viewer.set_property(path, "visible", on); };
  box.addEventListener("change", () => { set(box.checked); viewer.set_dirty(); });
  switches.push({ paths, box, set, isOn: () => viewer.scene_tree.find(all()[0]).object.visible });
}

/** Set the check boxes to the states of those in meshcat's tree. */
function updateSwitches() {
  for (const item of switches) item.box.checked = item.isOn();
}

function toggle(path) {
  const found = switches.find((item) => item.paths[0] === path);
  if (found) { found.set(!found.isOn()); viewer.set_dirty(); }
}

function buildPanel() {
  const { scene } = page.robots[0];
  buildTools();
  buildTwist();
  if (page.robots.length > 1) buildCompare(fold("Compare"));
  if (page.machine) buildLive();
  const deformation = fold("Picture");
  const row = make("label", deformation, { className: "slider choice", hidden: scene.modes.length > 0 });
  make("span", row, { textContent: "colour by" });
  const choice = make("select", row, { name: "colour by", onchange: () => { state.quantity = choice.value; refresh(); } });
  make("option", choice, { value: "deflection", textContent: "deflection" });
  const found = new Map(page.robots.flatMap((robot) => robot.scene.quantities).map((quantity) => [quantity.key, quantity.words]));
  for (const [key, words] of found) make("option", choice, { value: key, textContent: words });
  slider(deformation, "exaggeration", "drawn ×", 0, 0, 1, (x) => { state.exaggeration = Math.pow(10, x); refresh(); }, (x) => number(Math.pow(10, x)));
  setExaggeration(scene.exaggeration);
  if (page.robots.some((robot) => robot.scene.stations.frames > 1)) buildPath(fold("Path"));
  make("details", element("robot-controls"), { open: true, id: "robot-arrows" });
  buildArrows();
  const shown = fold("Show", false);
  for (const [label, path] of [["robot at rest (pale)", "Rest"], ["deformed robot", "Deformed"], ["base", "Base"], ["axes", "Frames"], ["names", "Labels"], ["largest value", "Marks"]]) {
    treeSwitch(shown, label, [path]);
  }
  viewer.gui.domElement.removeAttribute("style");
  viewer.gui.open();
  fold("Scene: meshcat's own tree", false).appendChild(viewer.gui.domElement);
}

/** Add the platform's twist and its contributions; without loads, the free motions or modes. */
function buildTwist() {
  const twist = element("robot-twist");
  twist.replaceChildren();
  const { unloaded, modes } = page.robots[0].scene;
  twist.classList.toggle("unloaded", unloaded);
  if (unloaded) { (modes.length ? buildModes : buildFreeMotions)(twist); return; }
  make("h2", twist, { textContent: "Twist of the platform at o, world axes" });
  make("table", twist, { id: "robot-total" });
  const parts = make("details", twist);
  make("summary", parts, { textContent: "Contributions and their shares" });
  make("table", parts, { id: "robot-parts" });
  buildShares(element("robot-parts"));
}

/** Add the check boxes of the groups of arrows. */
function buildArrows() {
  const { scene } = page.robots[0], parent = element("robot-arrows"), groups = new Map(scene.arrows.map((spec) => [spec.path.split("/")[1], spec.colour]));
  switches = switches.filter(({ box }) => !parent.contains(box));
  parent.replaceChildren();
  parent.hidden = !groups.size;
  make("summary", parent, { textContent: scene.unloaded ? "Free motions" : "Forces and moments" });
  const content = make("div", parent);
  treeSwitch(content, "all of these", ["Arrows"]);
  for (const [group, colour] of groups) treeSwitch(content, group, [`Arrows/${group}`], colour);
}

/** Set the exaggeration and the range of its slider. */
function setExaggeration({ value, min, max }) {
  const { input, set } = controls.get("exaggeration"), log = Math.log10;
  state.exaggeration = value;
  Object.assign(input, { min: log(min), max: log(max) });
  set(log(value));
}

/** Add two rows for each contribution: the slider of its share, and its twist. */
function buildShares(table) {
  make("thead", table, { innerHTML: columns() });
  for (const name of page.robots[0].scene.contributions) {
    const cell = make("td", make("tr", table), { colSpan: 6 });
    slider(cell, `share: ${name}`, name, 1, 0, 1, (x) => { state.shares.set(name, x); refresh(); }, (x) => fixed(x, 2));
    make("tr", table, { className: "part" });
  }
}

/** Add a slider for each free motion; the first motion is shown. */
function buildFreeMotions(parent) {
  const { contributions, shares: first } = page.robots[0].scene;
  if (contributions.length) make("h2", parent, { textContent: "Free motions, actuators locked" });
  contributions.forEach((name, k) => {
    state.shares.set(name, first[k]);
    slider(parent, `share: ${name}`, name, first[k], -1, 1, (x) => { state.shares.set(name, x); refresh(); }, (x) => fixed(x, 2));
  });
}

function columns() {
  const { displacement, rotation } = page.robots[0].scene.units;
  return `<tr><th>x</th><th>y</th><th>z</th><th>rx</th><th>ry</th><th>rz</th></tr>
    <tr><th colspan="3">${displacement.unit}</th><th colspan="3">${rotation.unit}</th></tr>`;
}

function buildPath(parent) {
  const frames = Math.max(...page.robots.map((robot) => robot.scene.stations.frames)), last = state.mode ? 1 : frames - 1;
  const [label, written] = state.mode ? ["phase", (x) => `${fixed(360 * x, 0)}°`] : ["pose", (x) => fixed(1 + x, last < 100 ? 1 : 0)];
  slider(parent, "path", label, state.time, 0, last, (x) => { state.time = x; refresh(); }, written);
  make("button", parent, { id: "robot-play", textContent: "play", onclick: playOrPause });
}

function playOrPause() {
  state.playing = !state.playing;
  element("robot-play").textContent = state.playing ? "pause" : "play";
  if (state.playing) play(performance.now(), Number(controls.get("path").input.max));
}

function play(before, last) {
  requestAnimationFrame((t) => {
    if (!state.playing) return;
    const next = state.time + Math.min(Math.max(t - before, 0), 100) / 1000 * last / page.robots[0].scene.seconds;
    state.time = next > last ? 0 : next;
    controls.get("path").set(state.time);
    refresh();
    play(t, last);
  });
}

function scaleBy(factor) {
  const { input, set } = controls.get("exaggeration");
  set(Number(input.value) + Math.log10(factor));
  input.dispatchEvent(new Event("input"));
}

function buildTools() {
  const tools = element("robot-tools");
  const tool = (key, words, title = null) => {
    const [, does, run] = KEYS.find(([k]) => k === key);
    make("button", tools, { textContent: words, title: `${title || does} (key ${KEY_NAMES[key] || key})`, onclick: run });
  };
  for (const [key, words] of [["f", "fit"], ["0", "home"], ["3", "top"], ["1", "front"], ["2", "side"], ["i", "image"], ["d", "◐"], ["p", "panel"], ["?", "?"]]) tool(key, words);
  const rows = KEYS.map(([key, does]) => `<tr><td><kbd>${KEY_NAMES[key] || key}</kbd></td><td>${escape(does)}</td></tr>`).join("");
  element("robot-help").innerHTML = `<h2>Keys</h2><table>${rows}</table>
    <p>Drag to turn, right-drag or two fingers to shift, wheel to zoom.</p>`;
  element("robot-help").addEventListener("click", closeAll);
}

function showHelp() {
  element("robot-help").hidden = !element("robot-help").hidden;
}

function closeAll() {
  if (element("robot-help").hidden) select(null);
  element("robot-help").hidden = true;
}

// ---------------------------------------------------------------- changing contents

/** Names and texts of pose, gravity, loads and scale of a robot at the nearest pose of the path. */
function facts(robot) {
  const { scene } = robot, [i, j, w] = between(scene), lines = scene.facts[w < 0.5 ? i : j];
  const [status] = lines.slice(-1), drawn = scene.unloaded ? [] : [["drawn", `× ${number(state.exaggeration)}`]];
  const mode = state.mode ? [[`${state.mode.name}:`, state.mode.frequency]] : [];
  return [...mode, ...lines.slice(0, -1), ...drawn, ...(scene.unloaded || (status[1] === "OK" && !page.machine) ? [] : [status])];
}

function writePanel(scale) {
  const { scene } = page.robots[0], { displacement, rotation } = scene.units;
  if (!scene.unloaded) writeTwist(scene, displacement, rotation);
  if (page.machine) writeMessage(scene);
  else element("robot-notes").innerHTML = scene.notes.slice(0, 3).map((note) => `<p>${escape(note)}</p>`).join("");
  element("robot-facts").innerHTML = page.robots.map((robot) => `<span class="title"><b>${escape(robot.scene.title)}</b></span>` + facts(robot)
    .map(([name, text]) => `<span><b>${escape(name)}</b> ${escape(text)}</span>`).join("")).join("<br>");
  writeLegend(scale);
  writeCard();
}

/** Write the twist of the platform at o, and its contributions. */
function writeTwist(scene, displacement, rotation) {
  const parts = scene.contributions.map((_, k) => readout(scene, k)), sum = readout(scene, null);
  const cells = (values) => values.map((x, c) => {
    const { factor, decimals } = c < 3 ? displacement : rotation;
    return `<td>${fixed(x / factor, decimals)}</td>`;
  }).join("");
  const rows = page.robots.length > 1 ? comparison() : [["", sum]];
  element("robot-total").innerHTML = columns() + rows.map(([name, values]) => `${name && `<tr><td colspan="6">${name}</td></tr>`}<tr class="total">${cells(values)}</tr>`).join("");
  element("robot-parts").tHead.innerHTML = columns();
  [...element("robot-parts").querySelectorAll("tr.part")].forEach((row, k) => {
    row.innerHTML = cells(parts[k]);
    row.hidden = row.previousElementSibling.hidden = page.machine !== null && scene.contributions[k] === "payload" && parts[k].every((x) => x === 0);
  });
}
