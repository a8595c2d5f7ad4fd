/* Two results on one page: the second as a ghost over the first, or side by side with the same camera. */

const GHOST = new THREE.MeshPhongMaterial({ color: "#e07b00", transparent: true, opacity: 0.45, depthWrite: false, side: THREE.DoubleSide, shininess: 5 });
const PARTS = ["Rest", "Deformed", "Base", "Arrows", "Frames", "Labels", "Marks"];

const beside = () => state.compared === "beside";

/** The pictures on the stage: {robots, left, width} in pixels. */
function panes() {
  const width = stage.offsetWidth;
  if (!beside()) return [{ robots: page.robots, left: 0, width }];
  return page.robots.map((robot, k) => ({ robots: [robot], left: k * width / 2, width: width / 2 }));
}

const paneOf = (robot) => panes().find((pane) => pane.robots.includes(robot));

/** Whether a robot is a ghost, without labels, arrows and marks. */
const isGhost = (robot) => robot.root !== "" && !beside();

/** Whether two robots have the same base: two identical surfaces would flicker. */
function sameBase(a, b) {
  return [...a.solids].filter(([path]) => path.startsWith("Base/")).every(([path, { spec }]) => {
    const other = b.solids.get(path);
    return other && other.spec.vertices.length === spec.vertices.length && spec.vertices.every((x, k) => x === other.spec.vertices[k]);
  });
}

/** Set a common scale for the arrows of a group in both results. */
function shareScales(robots) {
  const scales = new Map(), all = robots.flatMap((robot) => [...robot.arrows.values()]), key = ({ spec }) => `${spec.path.split("/")[1]} ${spec.kind}`;
  for (const arrow of all) scales.set(key(arrow), Math.min(arrow.spec.metres_per_unit, scales.get(key(arrow)) ?? Infinity));
  for (const arrow of all) arrow.spec.metres_per_unit = scales.get(key(arrow));
}

function setCompared(how) {
  state.compared = document.querySelector("select[name=compare]").value = how;
  for (const robot of page.robots) robot.setGhost(isGhost(robot));
  viewer.set_3d_pane_size();
  fit();
}

function buildCompare(parent) {
  const row = make("label", parent, { className: "slider choice" });
  make("span", row, { textContent: "second result" });
  const choice = make("select", row, { name: "compare", onchange: () => setCompared(choice.value) });
  for (const [value, textContent] of [["ghost", "ghost (orange)"], ["beside", "side by side"]]) make("option", choice, { value, textContent });
}

/** Draw every picture with the same camera. */
function renderPanes() {
  const { renderer, camera, scene } = viewer, height = stage.offsetHeight;
  viewer.controls.update();
  renderer.setScissorTest(true);
  for (const { robots, left, width } of panes()) {
    const hidden = page.robots.filter((robot) => !robots.includes(robot)).flatMap((robot) => robot.nodes().filter((node) => node.visible));
    for (const node of hidden) node.visible = false;
    renderer.setViewport(left, 0, width, height);
    renderer.setScissor(left, 0, width, height);
    renderer.render(scene, camera);
    for (const node of hidden) node.visible = true;
  }
  renderer.setScissorTest(false);
  renderer.setViewport(0, 0, stage.offsetWidth, height);
  viewer.needs_render = false;
}

/** Twists of both results, and their difference. */
function comparison() {
  const [a, b] = page.robots.map((robot) => readout(robot.scene, null));
  return [["first", a], ["second", b], ["second \u2212 first", b.map((x, c) => x - a[c])]];
}
