/* Labels with names and numbers. A line leads from a label to its anchor. A label without free place near its anchor is omitted
 * unless the pointer is on its arrow. Labels of anchors behind the robot are dimmed. */

const labels = []; // {robot, anchor, text, colour, shown, rank, path, behind, element, leader}: of all robots
const RANKS = { arrow: 0, mark: 1, frame: 2, name: 3 }; // order in which labels are placed
const SIDES = [[1, -1], [-1, -1], [1, 1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]];
const RINGS = 4, AWAY = 6, BESIDE = 4; // number of distances; smallest distance [px]; distance without a line [px]
const NARROW = 600; // width of the stage [px] below which a label has two lines
let pointed = null; // the label of the arrow under the pointer

function addLabel(robot, anchor, text, colour, kind, shown = () => true, path = "") {
  const layer = document.getElementById("robot-labels"), svg = "http://www.w3.org/2000/svg";
  const lines = layer.querySelector("svg") || layer.appendChild(document.createElementNS(svg, "svg"));
  const element = make("div", layer, { className: "robot-label" }), leader = lines.appendChild(document.createElementNS(svg, "line"));
  for (const item of [element, leader]) item.style.setProperty("--colour", colour);
  labels.push({ robot, anchor, text, colour, shown, rank: RANKS[kind], path, behind: false, element, leader });
}

const visible = (object) => !object || (object.visible && visible(object.parent));

/** Place the labels beside their anchors on the screen, without overlaps. */
function placeLabels() {
  const height = stage.offsetHeight, taken = [], wanted = [];
  for (const label of labels) {
    const { left, width } = paneOf(label.robot);
    label.anchor.getWorldPosition(point).project(viewer.camera);
    if (label.shown() && visible(label.anchor) && Math.abs(point.z) < 1) wanted.push({ label, left, width, depth: point.z, x: left + (0.5 + 0.5 * point.x) * width, y: (0.5 - 0.5 * point.y) * height });
    else label.element.style.visibility = label.leader.style.visibility = "hidden";
  }
  const middle = ["x", "y"].map((axis) => wanted.reduce((sum, item) => sum + item[axis], 0) / Math.max(wanted.length, 1));
  wanted.sort((a, b) => (b.label === pointed) - (a.label === pointed) || a.label.rank - b.label.rank || a.depth - b.depth);
  findHidden(wanted);
  for (const { label, left, width, x, y } of wanted) {
    const { element, leader, behind } = label, text = label.text(), words = stage.offsetWidth < NARROW ? text : text.replace("\n", " ");
    if (element.textContent !== words) element.textContent = words;
    const free = (r) => r.left >= left && r.top >= 0 && r.right <= left + width && r.bottom <= height &&
      !taken.some((t) => r.left < t.right && r.right > t.left && r.top < t.bottom && r.bottom > t.top);
    const outwards = [...SIDES].sort((a, b) => (b[0] - a[0]) * (x - middle[0]) + (b[1] - a[1]) * (y - middle[1]));
    const chosen = placeNear(x, y, outwards, element.offsetWidth, element.offsetHeight, label === pointed ? 3 * RINGS : RINGS, free);
    element.style.visibility = chosen ? "visible" : "hidden";
    const end = chosen && [Math.min(Math.max(x, chosen.left), chosen.right), Math.min(Math.max(y, chosen.top), chosen.bottom)];
    leader.style.visibility = chosen && Math.hypot(end[0] - x, end[1] - y) > BESIDE ? "visible" : "hidden";
    if (!chosen) continue;
    taken.push(chosen);
    for (const item of [element, leader]) item.style.opacity = behind && label !== pointed ? 0.45 : 1;
    element.style.transform = `translate(${Math.round(chosen.left)}px, ${Math.round(chosen.top)}px)`;
    Object.entries({ x1: x, y1: y, x2: end[0], y2: end[1] }).forEach(([name, value]) => leader.setAttribute(name, value.toFixed(1)));
  }
}

/** The nearest free rectangle of w × h pixels at (x, y), by the order of `sides`, at up to `rings` distances; or null. */
function placeNear(x, y, sides, w, h, rings, free) {
  for (let ring = 0; ring < rings; ring++) {
    const d = AWAY + 12 * ring;
    for (const [sx, sy] of sides) {
      const left = x + sx * d - (sx < 0 ? w : sx === 0 ? w / 2 : 0), top = y + sy * d - (sy < 0 ? h : sy === 0 ? h / 2 : 0);
      const r = { left, top, right: left + w, bottom: top + h };
      if (free(r)) return r;
    }
  }
  return null;
}

/** Find the anchors behind the robot, at most five times per second; bodies around an anchor are ignored. */
function findHidden(wanted) {
  const wait = 200 - (performance.now() - findHidden.time);
  if (wait > 0) {
    if (!findHidden.later) findHidden.later = setTimeout(() => { findHidden.later = null; viewer.set_dirty(); }, wait);
    return;
  }
  const ray = new THREE.Raycaster(), start = viewer.camera.position;
  for (const { label } of wanted) {
    const end = label.anchor.getWorldPosition(new THREE.Vector3()), far = end.distanceTo(start);
    ray.set(start, end.sub(start).normalize());
    ray.far = far - 0.06 * label.robot.scene.size;
    label.behind = [...label.robot.solids].some(([path, { mesh }]) => !path.startsWith("Rest/") && visible(mesh) && ray.intersectObject(mesh).length > 0);
  }
  findHidden.time = performance.now();
}
findHidden.time = -Infinity;

/** Show the label of the arrow under the pointer. */
function watchPointer() {
  stage.addEventListener("pointermove", (event) => {
    if (event.buttons) return;
    const found = pick(event.clientX, event.clientY), label = labels.find(({ robot, path }) => found && path && robot === found.robot && path === found.path);
    if (pointed === (label || null)) return;
    pointed = label || null;
    viewer.set_dirty();
  });
}
