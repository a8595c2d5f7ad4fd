/* Start of the page, with meshcat's `viewer` and the `description` of the scene. */

/** Draw the robots and write the panel for the present state. */
function refresh() {
  const scale = colourScale();
  for (const robot of page.robots) robot.draw(scale);
  placeHandles();
  writePanel(scale);
  viewer.set_dirty();
}

/** Set the light, and hide grid, axes and hidden groups of arrows. */
function setStage() {
  for (const name of ["Grid", "Axes"]) viewer.set_property([name], "visible", false);
  for (const name of ["PointLightNegativeX", "PointLightPositiveX"]) viewer.set_property(["Lights", name], "visible", false);
  const { light } = page.robots[0].scene, key = new THREE.DirectionalLight(0xffffff, light.intensity);
  key.position.set(...light.from);
  viewer.set_object(["Lights", "Key"], key);
  for (const robot of page.robots) hideGroups(robot);
}

/** Hide the groups of arrows that are initially hidden. */
function hideGroups({ root, scene }) {
  for (const path of scene.hidden) viewer.set_property((root + path).split("/"), "visible", false);
}

/** State of the page, and its functions for other scripts. */
const page = window.robot_page = {
  state, labels, robots: [], machine: computed, controls: [], answers: 0, rested: 0, error: null, stop: null, ready: false, dark: false,
  look, pick, selectPath, picture, unpackIndices, sceneOf, handles, facts: () => page.robots.map(facts), readout: (k) => readout(page.robots[0].scene, k),
  get busy() { return busy; },
  get solids() { return page.robots[0].solids; }, get arrows() { return page.robots[0].arrows; },
  get stations() { return page.robots[0].now; }, get scene() { return page.robots[0].scene; },
};
{
  page.robots.push(new Robot(description));
  if (description.compare) {
    const { exaggeration } = description;
    exaggeration.value = Math.min(exaggeration.value, description.compare.exaggeration.value);
    page.robots.push(new Robot(description.compare, "Compared/"));
    shareScales(page.robots);
    document.body.classList.add("comparing");
  }
  if (page.machine) { // the contributions of loads that the page can add
    const { notes, cards, quantities } = description;
    page.robots[0].load({ ...sceneOf(page.machine, description.size), notes, cards, quantities });
  }
  setStage();
  buildPanel();
  if (page.machine) buildHandles();
  refresh();
  setDark(prefersDark.matches);
  prefersDark.addEventListener("change", () => setDark(prefersDark.matches));
  watchSize();
  watchKeys();
  watchClicks();
  watchPointer();
  applyAddress();
  if (description.compare) setCompared(beside() ? "beside" : "ghost");
  viewer.render = () => { renderPanes(); placeLabels(); updateSwitches(); };
  viewer.set_dirty();
  if (state.mode && !document.body.classList.contains("as-picture") && !matchMedia("(prefers-reduced-motion: reduce)").matches) playOrPause();
  page.ready = true;
  if (parent !== window) parent.postMessage("robot-page ready", "*"); // for a page that contains this one in a frame
}
