/* Numbers, legend and sliders. */

/** Three significant digits. */
function number(x) {
  const a = Math.abs(x);
  if (a < 1e-5) return "0";
  const text = a >= 1e6 ? x.toExponential(2) : a >= 100 ? x.toFixed(0) : x.toPrecision(3);
  return text.replace("-", "\u2212");
}

/** A number with so many decimals, zero as 0. */
function fixed(x, decimals) {
  const text = x.toFixed(decimals);
  return Number(text) === 0 ? "0" : text.replace("-", "\u2212");
}

function escape(text) {
  return String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" }[c]));
}

function buildPanel() {
  for (const id of ["robot-labels", "robot-panel", "robot-legend"]) {
    viewer.dom_element.parentElement.appendChild(Object.assign(document.createElement("div"), { id }));
  }
}

/** Where on the path we are, in words. */
function place() {
  const [i, j, w] = between();
  return scene.path.map(({ name, unit, values }) => `${escape(name)} ${number((1 - w) * values[i] + w * values[j])} ${escape(unit)}`).join(", ");
}

function writePanel(scale) {
  const parts = scene.contributions.map((_, k) => readout(k)), sum = readout(null);
  const decimals = [0, 3].map((first) => { // as many for all displacements, and for all rotations
    const most = Math.max(...[...parts, sum].flatMap((values) => values.slice(first, first + 3).map(Math.abs)));
    return most > 0 ? Math.min(Math.max(3 - Math.floor(Math.log10(most)), 0), 8) : 0;
  });
  const cells = (values) => values.map((x, c) => `<td>${fixed(x, decimals[c < 3 ? 0 : 1])}</td>`).join("");
  const rows = scene.contributions.map((name, k) => `<tr class="part"><td>${escape(name)}</td>${cells(parts[k])}</tr>`).join("");
  const notes = [...scene.notes.slice(0, 3), ...(page.error ? [page.error] : [])];
  document.getElementById("robot-panel").innerHTML = `<h1>${escape(scene.title)}</h1>
    <p>twist of the platform at o, world axes</p>${scene.path.length ? `<p>${place()}</p>` : ""}
    <table><tr><th></th><th>x</th><th>y</th><th>z</th><th>rx</th><th>ry</th><th>rz</th></tr>
    <tr><th></th><th colspan="3">µm</th><th colspan="3">mdeg</th></tr>${rows}
    <tr class="total"><td>sum</td>${cells(sum)}</tr></table>
    ${notes.map((note) => `<p class="note">${escape(note)}</p>`).join("")}`;
  const [unit, factor] = scale >= 1e-3 ? ["mm", 1e3] : scale >= 1e-6 ? ["µm", 1e6] : ["nm", 1e9];
  const ticks = [0, 0.5, 1].map((part) => `<span>${number(part * scale * factor)}</span>`).join("");
  document.getElementById("robot-legend").innerHTML = `<div>deflection [${unit}], drawn × ${number(state.exaggeration)}</div>
    <div class="bar" style="background: linear-gradient(90deg, ${ramp.map((colour) => colour.getStyle()).join(",")})"></div><div class="ticks">${ticks}</div>
    <div class="hint">pale: unloaded. Every group of arrows has its own scale.</div>`;
}

// ---------------------------------------------------------------- controls

/** Move a control above meshcat's own folders. */
function lift(name) {
  const control = viewer.gui_controllers[name], list = control.__li.parentElement;
  list.insertBefore(control.__li, list.querySelector(":scope > li.folder"));
  return control;
}

/** A slider of meshcat; it evaluates the callback, and a function evaluates to itself. */
function slider(name, value, min, max, step, callback) {
  viewer.set_control(name, callback, value, min, max, step);
  return lift(name);
}

function buildControls() {
  const e = scene.exaggeration;
  const log = slider("exaggeration", Math.log10(e.value), Math.log10(e.min), Math.log10(e.max), 0.01, (x) => {
    state.exaggeration = Math.pow(10, x);
    log.name(`exaggeration × ${number(state.exaggeration)}`);
    refresh();
  });
  log.name(`exaggeration × ${number(e.value)}`);
  log.domElement.firstChild.style.display = "none"; // the box would show the logarithm
  log.domElement.lastChild.style.width = "100%";
  scene.contributions.forEach((name, k) => slider(`share: ${name}`, state.shares[k], 0, 1, 0.01, (x) => { state.shares[k] = x; refresh(); }));
  if (scene.stations.frames > 1) {
    slider("path", state.time, 0, scene.stations.frames - 1, 0.01, (x) => { state.time = x; refresh(); });
    viewer.set_control("play / pause", () => { state.playing = !state.playing; if (state.playing) play(performance.now()); });
    lift("play / pause");
  }
  for (const c of (scene.live ? scene.live.controls : [])) slider(c.name, c.value, c.min, c.max, c.step, (x) => moveLive(c.name, x));
  viewer.gui.width = window.innerWidth > 1200 ? 340 : 280;
  if (window.innerWidth > 700) viewer.gui.open(); else viewer.gui.close();
}

function play(before) {
  requestAnimationFrame((t) => {
    if (!state.playing) return;
    const last = scene.stations.frames - 1, next = state.time + Math.min(t - before, 100) / 1000 * last / scene.seconds;
    viewer.set_control_value("path", next > last ? 0 : next); // calls back
    play(t);
  });
}

// ---------------------------------------------------------------- live pages

let asking = false, waiting = null;

/** A live slider moved: ask for an analysis. One question at a time; of those that wait the last wins. */
async function moveLive(name, value) {
  const moved = scene.live.controls.find((c) => c.name === name);
  moved.value = value;
  const values = {};
  for (const c of scene.live.controls) if (c.kind === moved.kind) values[c.coordinate] = c.value;
  waiting = { kind: moved.kind, values };
  if (asking) return;
  asking = true;
  try {
    while (waiting) {
      const question = JSON.stringify(waiting);
      waiting = null;
      const answer = await fetch(scene.live.url, { method: "POST", headers: { "Content-Type": "application/json" }, body: question });
      const body = await answer.json();
      page.error = body.error || null;
      if (body.error || waiting) refresh(); else load(body);
    }
  } catch (error) {
    page.error = `no answer: has the program ended? (${error.message})`;
    refresh();
  } finally {
    asking = false;
    page.answers += 1;
  }
}

/** Show the coordinates that follow from those that were moved, without asking again. */
function showLive() {
  for (const c of scene.live.controls) viewer.set_control_value(c.name, c.value, false);
}
