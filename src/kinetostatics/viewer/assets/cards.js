/* A click on a beam, joint, link or arrow shows its numbers on a card in the panel. */

const selection = { robot: null, path: null, object: null };

function watchClicks() {
  let down = null;
  stage.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
  stage.addEventListener("pointerup", (event) => {
    if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) select(pick(event.clientX, event.clientY));
    down = null;
  });
}

/** The object at a position of the window: {robot, path, object}, or null. A click up to 4 pixels beside an arrow selects it, too. */
function pick(x, y) {
  const box = stage.getBoundingClientRect(), ray = new THREE.Raycaster(), targets = [], thin = [];
  const pane = panes().find(({ left, width }) => x - box.left >= left && x - box.left < left + width) || panes()[0];
  for (const robot of pane.robots) {
    for (const [path, { mesh, spec }] of robot.solids) if (!path.startsWith("Rest/") && visible(mesh)) targets.push({ robot, path: spec.path, object: mesh });
    for (const [path, { object }] of robot.arrows) if (object.seen && visible(object)) thin.push({ robot, path, object });
  }
  const nearest = (list, dx, dy) => {
    ray.setFromCamera({ x: 2 * (x + dx - box.left - pane.left) / pane.width - 1, y: 1 - 2 * (y + dy - box.top) / box.height }, viewer.camera);
    let best = null;
    for (const item of list) {
      const [hit] = ray.intersectObject(item.object, true);
      if (hit && (!best || hit.distance < best.distance)) best = { ...item, distance: hit.distance };
    }
    return best;
  };
  const solid = nearest(targets, 0, 0);
  for (const [dx, dy] of [[0, 0], [4, 0], [-4, 0], [0, 4], [0, -4]]) {
    const arrow = nearest(thin, dx, dy);
    if (arrow && (!solid || arrow.distance < solid.distance)) return arrow;
  }
  return solid;
}

function highlight(object, on) {
  if (object) object.traverse((part) => { if (part.material && part.material.emissive && part.material !== GHOST) part.material.emissive.set(on ? 0x5a4a00 : 0); });
}

function select(found) {
  highlight(selection.object, false);
  Object.assign(selection, found || { robot: null, path: null, object: null });
  highlight(selection.object, true);
  if (found) document.body.classList.remove("without-panel");
  writeCard();
  viewer.set_dirty();
}

/** Select the solid or arrow at a path of the first robot. */
function selectPath(path) {
  const [robot] = page.robots, solid = robot.solids.get(`Deformed/${path}`) || robot.solids.get(`Base/${path}`), arrow = robot.arrows.get(path);
  if (solid || arrow) select({ robot, path, object: solid ? solid.mesh : arrow.object });
}

/** Write the card of the selected object, at the present time. */
function writeCard() {
  const card = element("robot-card"), { robot, path } = selection;
  card.hidden = !robot;
  if (!robot) return;
  const arrow = robot.arrows.get(path), details = robot.scene.cards[path];
  const content = arrow ? arrowCard(robot, arrow) : details ? bodyCard(robot, path, details) : linkCard(robot, path);
  const partly = !arrow && shares(robot.scene).some((share) => share !== 1);
  card.innerHTML = `${content}${partly ? `<p class="note">Forces and stresses of all contributions in full.</p>` : ""}<button class="close" title="close (key Esc)">×</button>`;
  card.querySelector(".close").addEventListener("click", () => select(null));
}

const heading = (name, kind) => `<h2>${escape(name)}</h2><p>${escape(kind)}</p>`;
const tableOf = (rows) => `<table>${rows.map(([words, text]) => `<tr><td>${escape(words)}</td><td>${escape(text)}</td></tr>`).join("")}</table>`;

/** A number in the format of the report. */
function written(x, { factor, decimals, noise = 0 }) {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "–" : x > 0 ? "∞" : "−∞";
  return Math.abs(x) <= noise ? "0" : fixed(x / factor, decimals);
}

function withUnit(values, scale) {
  const text = values.map((x) => written(x, scale)).join(", ");
  return `${values.length > 1 ? `(${text})` : text}${scale.unit === "°" ? "" : " "}${scale.unit}`;
}

function bodyCard(robot, path, details) {
  const rows = details.rows.map((row) => [row.words, withUnit(interpolated(robot.scene, row.values, row.width), row)]);
  const moving = path.startsWith("joints/") ? motionRows(robot, path) : [];
  return heading(path.replace(/^[^/]*\//, ""), details.kind) + tableOf([...rows, ...moving]) + (details.lines.M_y ? diagrams(robot, details) : "")
    + (details.note ? `<p>${escape(details.note)}</p>` : "");
}

/** Displacement and rotation of a station, at the present shares. */
function motionRows(robot, path) {
  const solid = robot.solids.get(`Deformed/${path}`), { displacement, rotation } = robot.scene.units;
  if (!solid) return [["displacement", "0"]];
  const s = 6 * solid.spec.station, twist = Array.from(robot.now.sum.slice(s, s + 6)), u = twist.slice(0, 3), turn = twist.slice(3);
  return [
    ["displacement", withUnit([Math.hypot(...u)], displacement)], ["displacement: x, y, z", withUnit(u, displacement)],
    ...(path.startsWith("joints/") ? [] : [["rotation: x, y, z", withUnit(turn, rotation)]]),
  ];
}

function linkCard(robot, path) {
  const name = path.replace(/^links\//, ""), solid = robot.solids.get(`Deformed/${path}`);
  if (solid && !solid.rigid) return heading(name, "elastic link");
  return heading(name, `${robot.solids.has(`Base/${path}`) ? "link of the base" : "rigid link"}, at its origin, world axes`) + tableOf(motionRows(robot, path));
}

function arrowCard(robot, { spec, value }) {
  const [, group, name] = spec.path.match(/^Arrows\/([^/]*)\/(.*)$/), K = robot.scene.contributions.length, part = shares(robot.scene);
  const total = robot.blend(spec.vector, K + 1, (k) => (k < K ? part[k] : 1), new THREE.Vector3());
  const components = total.toArray(), size = total.length();
  const along = size > 0 ? total.clone().multiplyScalar((value < 0 ? -1 : 1) / size) : total;
  const rows = [[spec.kind === "force" ? "force" : "couple", `${number(value)} ${spec.unit}`], ["x, y, z", `(${components.map(number).join(", ")}) ${spec.unit}`]];
  for (let k = 0; k <= K; k++) {
    const own = robot.blend(spec.vector, K + 1, (n) => (n === k ? (k < K ? part[k] : 1) : 0), new THREE.Vector3()).dot(along);
    if (Math.abs(own) > 1e-6 * size) rows.push([`by ${k < K ? robot.scene.contributions[k] : "parts at the base"}`, `${number(own)} ${spec.unit}`]);
  }
  return heading(name, group) + tableOf(rows) + `<p>${escape(robot.scene.groups[group] || "")}</p>`;
}

// ---------------------------------------------------------------- diagrams

const LINE_COLOURS = { T: "#8a8f98", M_y: "#d95f02", M_z: "#1b7fbd", stress: "#7e3fa0" };

function diagrams(robot, { lines }) {
  const { frames } = robot.scene.stations, stress = robot.scene.quantities.find((quantity) => quantity.key === "stress");
  const at = (name) => interpolated(robot.scene, lines[name], lines[name].length / frames);
  const known = stress && at("stress").every(Number.isFinite);
  return diagram("Moments [N·m], base end to platform end", ["M_y", "M_z", "T"].map((name) => [name, at(name)]), 1)
    + (known ? diagram(`von Mises stress [${stress.unit}]`, [["stress", at("stress")]], stress.factor) : "");
}

/** Lines along a beam, with the largest value of each beside its name. */
function diagram(title, lines, factor) {
  const W = 300, H = 72, all = lines.flatMap(([, values]) => values.map((x) => x / factor));
  const low = Math.min(0, ...all), high = Math.max(0, ...all), span = high - low || 1;
  const y = (value) => (4 + (H - 8) * (high - value) / span).toFixed(1);
  const paths = lines.map(([name, values]) => `<polyline fill="none" stroke="${LINE_COLOURS[name]}" stroke-width="1.8" points="${
    values.map((x, k) => `${(2 + (W - 4) * k / (values.length - 1)).toFixed(1)},${y(x / factor)}`).join(" ")}"/>`).join("");
  const most = lines.map(([name, values]) => {
    const value = values.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0) / factor;
    return `<span style="--colour: ${LINE_COLOURS[name]}">${name} ${Math.abs(value) <= 1e-6 * span ? "0" : number(value)}</span>`;
  }).join("");
  return `<figure><figcaption>${title}</figcaption><svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${escape(title)}">
    <line x1="2" x2="${W - 2}" y1="${y(0)}" y2="${y(0)}" stroke="currentColor" stroke-opacity=".4"/>${paths}</svg><div>largest: ${most}</div></figure>`;
}
