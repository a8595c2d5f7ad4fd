/* Colours: the deflection of all parts, or stress, axial force and N/N_Euler along beams. */

const PLAIN = new THREE.Color(description.unknown); // of surfaces without the quantity

/** The quantity shown by colours: {key, words, unit, factor, low, high, ramp}, the same for all robots. */
function colourScale() {
  const scenes = page.robots.map((robot) => robot.scene), [{ units, ramp, signed_ramp }] = scenes;
  const found = scenes.flatMap((scene) => scene.quantities).filter((quantity) => quantity.key === state.quantity);
  const colours = (hexes) => hexes.map((hex) => new THREE.Color(hex));
  if (!found.length) {
    const most = Math.max(...page.robots.map((robot) => Math.max(largest(robot.scene), robot.largestDisplacement())));
    if (state.mode) return { key: "deflection", words: "displacement", unit: "% of the largest", factor: most / 100, low: 0, high: most, ramp: colours(ramp) };
    const rigid = most < 1e-12 * Math.max(...scenes.map(({ size }) => size)); // rounding errors
    return { key: "deflection", words: "deflection", ...units.displacement, low: 0, high: roundUp(rigid ? 0 : most), ramp: colours(ramp), rigid };
  }
  const [{ factor, signed }] = found, high = factor * roundUp(Math.max(...found.map((quantity) => quantity.largest)) / factor);
  return { ...found[0], low: signed ? -high : 0, high, ramp: colours(signed ? signed_ramp : ramp) };
}

/** Set colour `v` of an attribute by a value. */
function setColour(attribute, v, value, { low, high, ramp }) {
  if (!Number.isFinite(value)) { attribute.setXYZ(v, PLAIN.r, PLAIN.g, PLAIN.b); return; }
  const h = Math.min(Math.max((value - low) / (high - low), 0), 1) * (ramp.length - 1), i = Math.min(Math.floor(h), ramp.length - 2);
  const a = ramp[i], b = ramp[i + 1], f = h - i;
  attribute.setXYZ(v, a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b));
}

/** The function from a solid's vertex to its true displacement |u + theta × r|, or to the quantity along the beam. */
function valuesOf(robot, { spec, rigid }, key) {
  if (key === "deflection") {
    const { sum, rest } = robot.now, shift = spec.recovery && recovered(robot.now, spec);
    if (shift) return (v) => Math.hypot(shift[3 * v], shift[3 * v + 1], shift[3 * v + 2]);
    return (v) => {
      const s = rigid ? spec.station : spec.station[v], t = 6 * s;
      point.fromArray(spec.vertices, 3 * v).applyQuaternion(qa.fromArray(rest, 7 * s + 3));
      return Math.hypot(
        sum[t] + sum[t + 4] * point.z - sum[t + 5] * point.y,
        sum[t + 1] + sum[t + 5] * point.x - sum[t + 3] * point.z,
        sum[t + 2] + sum[t + 3] * point.y - sum[t + 4] * point.x,
      );
    };
  }
  const card = robot.scene.cards[spec.path], line = card && card.lines[key];
  if (!line) return () => NaN;
  const n = line.length / robot.scene.stations.frames, values = interpolated(robot.scene, line, n);
  return (v) => (n === 1 ? values[0] : values[spec.station[v] - card.first]);
}

function writeLegend(scale) {
  if (page.robots.every((robot) => robot.scene.unloaded) && !state.mode) {
    element("robot-legend").innerHTML = `<div class="what">without loads</div><div class="hint">${page.robots[0].scene.notes.map(escape).join("<br>")}</div>`;
    return;
  }
  if (scale.rigid) {
    element("robot-legend").innerHTML = `<div class="what">rigid: nothing deforms</div>`;
    return;
  }
  const ticks = [0, 0.25, 0.5, 0.75, 1].map((part) => `<span>${number((scale.low + part * (scale.high - scale.low)) / scale.factor)}</span>`).join("");
  element("robot-legend").innerHTML = `<div class="what">${scale.words} [${scale.unit}]</div>
    <div class="scale"><div class="bar" style="background: linear-gradient(90deg, ${scale.ramp.map((colour) => colour.getStyle()).join(",")})"></div>
    <div class="ticks">${ticks}</div></div>
    <div class="hint">${state.mode ? "pale: at rest" : scale.key === "deflection" ? "pale: at rest. Each group of arrows has its own scale." : "of all contributions in full; grey: not a beam, or of unknown outline."}</div>`;
}

function nextQuantity() {
  const choice = document.querySelector("select[name='colour by']");
  choice.selectedIndex = (choice.selectedIndex + 1) % choice.length;
  choice.dispatchEvent(new Event("change"));
}
