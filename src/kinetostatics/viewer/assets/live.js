/* Live pages: sliders and a gizmo on the platform ask the program for an analysis. */

let asking = false, stale = false, wake = () => {}; // stale: notes, cards and hidden arrows are older than the pose
const waiting = new Map(); // kind -> the newest question of it
const REST = 100; // ms without a question after which they are asked for, if nobody looks at them meanwhile
const pause = () => new Promise((done) => { wake = done; setTimeout(done, REST); });

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const HANDLE_COLOURS = { x: "#d62728", y: "#2ca02c", z: "#1f77b4" };

function buildLive() {
  const { live } = page.robots[0].scene, folds = { platform: "Move the platform", actuators: "Actuators", load: "Load at o" };
  for (const [kind, title] of Object.entries(folds)) {
    const mine = live.controls.filter((control) => control.kind === kind);
    if (!mine.length) continue;
    const parent = fold(title);
    if (kind === "platform") make("p", parent, { className: "hint", textContent: "Drag the arrows and rings at o, or the sliders." });
    for (const c of mine) {
      slider(parent, c.name, c.name.replace(/^[^:]*: /, ""), c.value, c.min, c.max, (x) => moveLive(c.name, x), (x) => fixed(x, c.step < 0.1 ? 2 : c.step < 1 ? 1 : 0));
    }
  }
}

/** A live slider or handle moved: ask for an analysis. One question at a time; of those of a kind that wait the newest wins. */
async function moveLive(name, value) {
  const { live } = page.robots[0].scene, moved = live.controls.find((c) => c.name === name), values = {};
  moved.value = value;
  for (const c of live.controls) if (c.kind === moved.kind) values[c.coordinate] = c.value;
  const told = selection.path !== null || state.quantity !== "deflection";
  const seen = [...page.robots[0].arrows].filter(([, { object }]) => visible(object)).map(([path]) => path.split("/")[1]);
  waiting.set(moved.kind, { kind: moved.kind, values, told, groups: told ? null : [...new Set(seen)] });
  wake();
  if (asking) return;
  asking = true;
  try {
    while (waiting.size || stale) {
      if (!waiting.size) await pause();
      const [asked] = waiting.size ? waiting.values() : [{ kind: "told" }], question = JSON.stringify(asked), start = performance.now();
      waiting.delete(asked.kind);
      stale = asked.kind !== "told" && !asked.told;
      const answer = await fetch(live.url, { method: "POST", headers: { "Content-Type": "application/json" }, body: question });
      const body = await answer.json();
      if (asked.kind !== "told") page.error = body.error || (body.rim ? `the rim of reach: ${body.rim}` : null);
      if (body.error) refresh(); else showAnswer(body);
      page.answerTime = performance.now() - start;
    }
  } catch (error) {
    page.error = `no answer: has the program ended? (${error.message})`;
    refresh();
  } finally {
    asking = false;
    page.answers += 1;
  }
}

/** Show a new scene, and the coordinates that follow from those that were moved, without asking again. */
function showAnswer(description) {
  const [robot] = page.robots;
  robot.load(description);
  for (const c of robot.scene.live.controls) {
    if (waiting.has(c.kind)) c.value = waiting.get(c.kind).values[c.coordinate]; // the answer is older than the sliders
    else controls.get(c.name).set(c.value);
  }
  refresh();
}

// ---------------------------------------------------------------- the gizmo


/** Handles at o for the free directions that have sliders: double arrows along x, y, z, rings about them for rx, ry, rz. */
function buildGizmo() {
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
  stage.addEventListener("pointerdown", grab, { capture: true });
}

function placeGizmo() {
  const { now, scene } = page.robots[0];
  for (const { object } of handles) object.position.fromArray(now.deformed, 7 * scene.readout);
}

/** The ray under a place of the window, in the axes of the robot. */
function rayAt(x, y) {
  const box = stage.getBoundingClientRect(), caster = new THREE.Raycaster(), turned = (v) => new THREE.Vector3(v.x, -v.z, v.y);
  caster.setFromCamera({ x: 2 * (x - box.left) / box.width - 1, y: 1 - 2 * (y - box.top) / box.height }, viewer.camera);
  return { caster, ray: new THREE.Ray(turned(caster.ray.origin), turned(caster.ray.direction)) };
}

/** How far along its axis, or by which angle about it, a place of the window is; null where that cannot be told. */
function measure({ turns, axis }, start, x, y) {
  const { ray } = rayAt(x, y);
  if (turns) {
    const hit = ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(axis, start), new THREE.Vector3());
    if (!hit) return null;
    const u = new THREE.Vector3(axis.y, axis.z, axis.x), v = axis.clone().cross(u), arm = hit.sub(start);
    return Math.atan2(arm.dot(v), arm.dot(u)) * 180 / Math.PI;
  }
  const between_ = ray.origin.clone().sub(start), d = ray.direction, b = d.dot(axis), denominator = 1 - b * b;
  return denominator < 1e-4 ? null : 1e3 * (between_.dot(axis) - b * between_.dot(d)) / denominator; // the point of the axis nearest to the ray
}

/** Begin to drag a handle, if there is one under the pointer. */
function grab(event) {
  const { caster } = rayAt(event.clientX, event.clientY);
  const hits = handles.map((handle) => ({ handle, hit: caster.intersectObject(handle.object, true)[0] })).filter(({ hit }) => hit);
  if (!hits.length || event.button !== 0) return;
  event.stopPropagation(); // it is not for the camera
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
    if (wanted < Number(input.min)) input.min = wanted;
    if (wanted > Number(input.max)) input.max = wanted;
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
