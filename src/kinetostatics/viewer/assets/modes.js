/* Modes of vibration: choice, motion and data. One period is the time 0 … 1. */

/** Factor of the displacements at the present time: the sine of a mode's phase, else 1. */
function swing() {
  return state.mode ? Math.sin(2 * Math.PI * state.time) : 1;
}

/** Add the choice of the mode, its phase and its data. */
function buildModes(parent) {
  const { modes, shares } = page.robots[0].scene, row = make("label", parent, { className: "slider choice" });
  make("span", row, { textContent: "mode" });
  const choice = make("select", row, { name: "mode", onchange: () => { chooseMode(choice.selectedIndex); refresh(); } });
  modes.forEach(({ frequency }, k) => make("option", choice, { textContent: `${k + 1}: ${frequency}` }));
  state.time = 0.25; // the largest displacements
  make("div", parent, { id: "robot-mode" });
  choice.selectedIndex = shares.indexOf(1);
  chooseMode(choice.selectedIndex);
  buildPath(parent);
  parent.append(element("robot-mode"));
}

function chooseMode(chosen) {
  const { modes, contributions } = page.robots[0].scene, { masses, strain, kinetic } = modes[chosen];
  contributions.forEach((name, k) => state.shares.set(name, k === chosen ? 1 : 0));
  state.mode = modes[chosen];
  const cells = (values) => values.map((text) => `<td>${escape(text)}</td>`).join("");
  const parts = (words, rows) => `<h2>${words}</h2><table class="parts">${rows.map((row) => `<tr>${cells(row)}</tr>`).join("")}</table>`;
  element("robot-mode").innerHTML = `<h2>Effective mass [%], about o</h2><table><tr>${["x", "y", "z", "rx", "ry", "rz"].map((name) => `<th>${name}</th>`).join("")}</tr>
    <tr>${cells(masses)}</tr></table>${parts("Strain energy [%]: what to stiffen", strain)}${parts("Kinetic energy [%]: what to make lighter", kinetic)}`;
}
