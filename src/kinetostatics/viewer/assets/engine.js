/* The robot itself: loops by Newton's method along straight lines of coordinates, and equilibrium, by the modules of computing.py.
 * A pose is {x, c}: coordinates of the tree of joints and of the platform's orientation. Nothing here refers to the page. */

const FINE = 1 / 65536; // accuracy of the ends of lines, as a part of the line
const NEARLY = 0.999; // part of the way to a singular pose, or to the end of the workspace, at which a robot stops
const FULL_TURN = 2 * Math.PI;
const WORDS = {
  loops: "beyond that the robot cannot be assembled",
  singular: "singular there: with the actuators locked the platform could move",
  uncovered: "a rank or a basis is in doubt there, so that Python decides, not the page",
};

class Machine {
  /** The machine of the data of a page; it rejects if the browser refuses WebAssembly. */
  static async load(data) {
    const stream = new Blob([bytesOf(data.code.zipped)]).stream().pipeThrough(new DecompressionStream("gzip"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer()), modules = [];
    for (const code of unpackCode(bytes, data.code.modules)) modules.push((await WebAssembly.instantiate(code, { math: Math })).instance.exports);
    return new Machine(data, modules);
  }

  constructor(data, modules) {
    this.data = data;
    this.modules = modules;
    this.use(data.robot);
    this.pose = { x: data.x, c: data.c };
    this.loads = { load: [...data.load], gravity: [...data.gravity], payload: [...data.payload] };
  }

  /** Use the numbers of one of the robots of the page. */
  use(number) {
    const { robots, lines } = this.data, robot = robots[number], numbers = (text) => new Float64Array(bytesOf(text).buffer);
    this.number = number;
    this.robot = robot;
    this.values = Object.fromEntries(Object.entries(robot.values).map(([kind, text]) => [kind, numbers(text)]));
    this.sections = Object.fromEntries(Object.entries(robot.sections).map(([name, { forms, rings }]) => [name, { forms: numbers(forms), rings }]));
    this.lines = Object.fromEntries(Object.entries(lines).map(([kind, line]) => [kind, { ...line, ...robot.lines[kind] }]));
  }

  /** Take another robot of the page, at the platform's present coordinates; false if they cannot be reached. */
  vary(number) {
    if (!this.data.robots[number]) return false;
    const before = this.number, kind = this.lines.platform ? "platform" : "actuators", target = this.present(kind);
    this.use(number);
    const pose = this.corrected(this.lines[kind], this.pose, target, false) || this.fromZero(kind, target);
    const reached = pose !== null && !["SINGULAR", "NOT_COVERED"].includes(this.solved(pose).status);
    if (reached) this.pose = pose;
    else this.use(before);
    return reached;
  }

  /** The pose at the end of the line from the zero pose to coordinates; null if it is not reached. */
  fromZero(kind, target) {
    const start = this.begin(this.lines[kind], this.robot.zero, target, false);
    return start && this.follow(this.lines[kind], start, target);
  }

  /** The outputs of a program. They are valid until its next call. */
  call({ module, kind, inputs, outputs }, ...arrays) {
    const { memory, run } = this.modules[module], numbers = new Float64Array(memory.buffer);
    let at = 0;
    for (const array of [...arrays, this.values[kind]]) { numbers.set(array, at); at += array.length; }
    run();
    return numbers.subarray(inputs, inputs + outputs);
  }

  // -------------------------------------------------------------- loops

  /** Newton's method from a pose to coordinates nearby; null unless every correction is smaller than the one before. */
  corrected({ newton, impose, angles }, pose, target, passing) {
    const x = Array.from(pose.x), c = Array.from(pose.c), n = x.length, { most_corrections, shrinking } = this.data;
    for (const { at, of, times, plus, turns } of impose) {
      const value = times * target[of] + plus;
      if (turns) [x[at], x[at + 1]] = [Math.cos(value), Math.sin(value)];
      else x[at] = value;
    }
    for (const [k, row] of angles) c[k] = target[row];
    let state = [...x, ...c, Infinity, shrinking, 1, 0, 1];
    const given = [...target, passing ? 1 : 0];
    for (let k = 0; k < most_corrections && state[n + 5]; k++) state = this.call(newton, state, given).slice(0, n + 8);
    return state[n + 6] && state[n + 7] ? { x: state.slice(0, n), c: state.slice(n, n + 3) } : null;
  }

  /** Whether it is certain that no singular pose, with the coordinates of a line given, lies between two poses. */
  onOneSide({ side }, first, second) {
    return !side || this.call(side, first.x, first.c, second.x, second.c)[0] !== 0;
  }

  /** The coordinates at the start of a line from a pose, {at, pose}; angles turn the shorter way, unless `shorter` is false. */
  begin({ start, names }, pose, target, shorter = true) {
    const n = names.length, out = this.call(start, pose.x, pose.c, target, [shorter ? 1 : 0]);
    return out[n + 3] ? { at: Array.from(out.slice(0, n)), pose: { x: pose.x, c: Array.from(out.slice(n, n + 3)) } } : null;
  }

  /** The pose at the end of a straight line from coordinates `at` of a pose to a target; null if it is not reached. */
  follow(line, { at, pose }, target) {
    const strides = target.map((value, k) => Math.abs(value - at[k]) / line.longest[k]), far = Math.max(0, ...strides);
    if (!Number.isFinite(far)) return null;
    const longest = 1 / Math.max(1, far);
    let gone = 0, stride = longest, steady = true;
    for (let steps = 0; steps < 200; steps++) {
      const trial = Math.min(gone + stride, 1), goal = trial === 1 ? target : at.map((value, k) => value + trial * (target[k] - value));
      const moved = this.corrected(line, pose, goal, trial < 1);
      if (moved && this.onOneSide(line, pose, moved)) {
        pose = moved;
        gone = trial;
        if (gone === 1) return this.closed(pose).rough > this.robot.rough ? this.corrected(line, pose, target, false) || pose : pose;
        if (steady) stride = Math.min(2 * stride, longest);
        steady = true;
      } else {
        stride /= 2;
        steady = false;
        if (stride <= 1e-3 * longest) return null;
      }
    }
    return null;
  }

  /** Error of the loops, coordinates of actuators and platform, and joints beyond their limits. */
  closed({ x }) {
    const { closed } = this.data, { places, limits, names } = closed, out = this.call(closed, x);
    const values = ([first, count]) => Array.from(out.subarray(first, first + count));
    const named = (kind) => Object.fromEntries(names[kind].map((name, k) => [name, out[places[kind][0] + k]]));
    const beyond = limits.filter(({ within }) => !out[within[0]]).map((joint) => {
      const [lower, upper] = this.robot.limits[joint.name];
      return { ...joint, lower, upper, value: values(joint.value)[0] };
    });
    return { rough: out[places.rough[0]], opening: out[places.opening[0]], holds: out[places.holds[0]] !== 0, actuators: named("actuators"), platform: named("platform"), beyond };
  }

  /** Why a pose reached from another one is not admissible: {reason, joint, limit}; null if it is. Limits exceeded already are ignored. */
  objection(from, to, ignored) {
    const { actuators } = this.lines, joint = this.closed(to).beyond.find(({ name }) => !ignored.has(name));
    if (joint) return { reason: "limit", joint, limit: joint.lower !== null && joint.value < joint.lower ? joint.lower : joint.upper };
    if (actuators && this.onOneSide(actuators, from, from) && !this.onOneSide(actuators, from, to)) return { reason: "singular" };
    return null;
  }

  /** The last admissible pose on the straight line from a pose to coordinates: {pose, part, reason, joint, limit}; no reason at its end.
   * The line is searched in `parts` steps. */
  lastOnLine(kind, from, target, parts = 1) {
    const line = this.lines[kind], ignored = new Set(this.closed(from).beyond.map(({ name }) => name));
    const start = this.begin(line, from, target);
    if (!start) return { pose: from, part: 0, reason: "loops" };
    const point = (part) => (part === 1 ? target : start.at.map((value, k) => value + part * (target[k] - value)));
    let low = 0, high = 0, pose = start.pose, end = null;
    const attempt = (part, begin = pose, first = low) => {
      const reached = this.follow(line, { at: point(first), pose: begin }, point(part));
      const objection = reached ? this.objection(begin, reached, ignored) : { reason: "loops" };
      if (objection) { end = objection; return false; }
      pose = reached;
      low = part;
      return true;
    };
    for (let k = 1; k <= parts; k++) if (!attempt(k / parts)) { high = k / parts; break; }
    if (!end) return { pose, part: 1, reason: "" };
    while (high - low > FINE) { const middle = (low + high) / 2; if (!attempt(middle)) high = middle; }
    const why = end;
    if (why.reason !== "limit") attempt(NEARLY * low, start.pose, 0);
    return { pose, part: low, ...why };
  }

  /** Coordinates of a kind at a pose, in the order of its line. */
  present(kind, pose = this.pose) {
    const values = this.closed(pose)[kind];
    return this.lines[kind].names.map((name) => values[name]);
  }

  /** Move as far as possible on the straight line to coordinates {name: value} [m, rad]; return the end of the line.
   * Where the pose there has no results, the robot stays. */
  move(kind, values) {
    const here = this.closed(this.pose)[kind], { names } = this.lines[kind];
    const end = this.lastOnLine(kind, this.pose, names.map((name) => values[name] ?? here[name]));
    const { status } = this.solved(end.pose);
    if (status === "SINGULAR" || status === "NOT_COVERED") return { ...end, reason: status === "SINGULAR" ? "singular" : "uncovered" };
    this.pose = end.pose;
    return end;
  }

  // -------------------------------------------------------------- equilibrium

  /** Outputs of the equilibrium, and status of a pose under loads. */
  solved(pose = this.pose, { load, gravity, payload } = this.loads) {
    const { statics } = this.data, out = this.call(statics, pose.x, load, gravity, payload), closed = this.closed(pose);
    const flag = (name) => out[statics.places[name][0]] !== 0;
    let status = closed.beyond.length ? "LIMIT_EXCEEDED" : "OK";
    if (flag("basis_degenerate")) status = "BASIS_DEGENERATE";
    if (flag("indeterminate")) status = "INDETERMINATE";
    if (flag("singular")) status = "SINGULAR";
    if (!closed.holds || !flag("holds") || flag("doubtful")) status = "NOT_COVERED";
    return { out, status, closed, values: (name) => Array.from(out.subarray(statics.places[name][0], statics.places[name][0] + statics.places[name][1])) };
  }

  /** Sentences about a solution: of the robot, of limits, of large motions. */
  warnings({ status, closed, values }) {
    const { warnings, length, efforts } = this.robot, { statics, closed: { names } } = this.data, twist = values("twist"), texts = [...warnings];
    if (status === "NOT_COVERED") return [...texts, "a rank or a basis is in doubt at this pose: Python decides, not the page"];
    if (status === "SINGULAR") return [...texts, "with the actuators locked the platform or a limb can still move: no results"];
    if (!values("regular")[0]) texts.push("the pose is nearly singular: the platform is almost free in a motion, which a report of Python names");
    const [bound] = statics.places.bound ? values("bound") : [0];
    if (!(bound < 0.05)) texts.push(`the forces may be up to ${Number((100 * bound).toPrecision(2))} % of a buckling load, by an upper bound: Python computes N/N_Euler`);
    const [shift, turn] = [twist.slice(0, 3), twist.slice(3)].map((part) => Math.hypot(...part));
    if (shift >= 0.1 * length || turn >= 0.1) texts.push(`the platform moves by ${shift.toPrecision(3)} m and ${turn.toPrecision(3)} rad, too much for linear theory: check the units of moduli, diameters and masses`);
    for (const { name, lower, upper, slides, value } of closed.beyond) {
      const [factor, unit] = slides ? [1e-3, " mm"] : [Math.PI / 180, "\u00b0"], text = (x) => (x === null ? "\u221e" : String(Number((x / factor).toPrecision(6))));
      texts.push(`${name} is beyond its limits of ${text(lower)} to ${text(upper)}${unit}: ${text(value)}${unit}`);
    }
    const digits = (x) => String(Number(x.toPrecision(5)));
    for (const [name, limit, unit] of efforts) {
      const force = Math.abs(values("actuator_forces")[names.actuators.indexOf(name)]);
      if (force > limit) texts.push(`the force of ${name} is beyond the limit of effort of ${digits(limit)} ${unit}: ${digits(force)} ${unit}`);
    }
    return texts;
  }

  /** Coordinates, forces and stiffness at given coordinates {name: value} of platform or actuators, under given loads, in SI units.
   * Loads that are not given are those of the page, coordinates those of its pose; the robot moves there from its zero pose. */
  analyze({ platform, actuators, load, gravity, payload } = {}) {
    const kind = platform ? "platform" : "actuators", given = platform || actuators, { lines, data: { closed: { names } } } = this;
    let { pose } = this;
    if (given) {
      const line = lines[kind], wrong = line ? Object.keys(given).filter((name) => !line.names.includes(name)) : [];
      if (!line || wrong.length || line.names.some((name) => !(name in given) && !line.idle.includes(name))) throw new Error(`give ${kind} coordinates ${line ? line.names.join(", ") : "of another kind"}`);
      pose = this.fromZero(kind, line.names.map((name) => Number(given[name] ?? 0)));
    }
    if (!pose) return { status: "UNREACHABLE", platform: null, actuators: null, twist: null, actuator_forces: null, stiffness: null, warnings: [] };
    const solution = this.solved(pose, { load: load || this.loads.load, gravity: gravity || this.loads.gravity, payload: payload || this.loads.payload });
    const { status, closed, values } = solution, valid = !["SINGULAR", "NOT_COVERED"].includes(status), forces = values("actuator_forces"), K = values("stiffness");
    return {
      status, platform: closed.platform, actuators: closed.actuators, twist: valid ? values("twist") : null,
      actuator_forces: valid ? Object.fromEntries(names.actuators.map((name, k) => [name, forces[k]])) : null,
      stiffness: valid ? [0, 1, 2, 3, 4, 5].map((k) => K.slice(6 * k, 6 * k + 6)) : null, warnings: this.warnings(solution),
    };
  }
}

// ---------------------------------------------------------------- what a page shows

/** A template of computing.py with the numbers of a program's outputs. */
function filled(template, out) {
  if (Array.isArray(template)) return template.map((part) => filled(part, out));
  if (template === null || typeof template !== "object") return template;
  if (template.take) return Float64Array.from(out.subarray(template.take[0], template.take[0] + template.take[1]));
  return Object.fromEntries(Object.entries(template).map(([key, part]) => [key, filled(part, out)]));
}

const largestOf = (values) => values.reduce((most, value) => (Math.abs(value) > most ? Math.abs(value) : most), 0); // finite ones

/** Unit and decimals for values, as numbers.py chooses them; a format without choice of units is kept. */
function formatOf(values, { units, digits, noise: least = 0 }) {
  if (!units.length) return {};
  const most = largestOf(values), noise = Math.max(least, 1e-9 * most);
  if (!(most > noise)) { const [unit, factor] = units[Math.min(1, units.length - 1)]; return { unit, factor, decimals: 0, noise }; }
  const [unit, factor] = units.filter(([, size]) => most >= 0.9999995 * size).at(-1) || units[0];
  const before = Math.floor(Math.log10(most / factor * (1 + 1e-12))) + 1;
  return { unit, factor, decimals: Math.min(Math.max(digits - before, 0), 9), noise };
}

/** The entries of a scene of a given size that depend on pose and loads. */
function sceneOf(machine, size) {
  const solution = machine.solved(), { out, closed, status } = solution, scene = filled(machine.data.statics.template, out);
  addStations(scene, machine.data.statics.beams);
  scaleArrows(scene.arrows, size);
  for (const card of Object.values(scene.cards)) {
    if (card.section) addStress(card, machine.sections[card.section]);
    card.rows = card.rows.filter((row) => row.values.every(Number.isFinite));
    for (const row of card.rows) Object.assign(row, formatOf(row.values, row));
  }
  const lines = (key) => Object.values(scene.cards).flatMap((card) => Array.from(card.lines[key] || []).filter(Number.isFinite));
  scene.quantities = scene.quantities.map((quantity) => ({ ...quantity, ...formatOf(lines(quantity.key), quantity), largest: largestOf(lines(quantity.key)) }))
    .filter(({ key }) => lines(key).length);
  const K = scene.contributions.length, { twist, count } = scene.stations, sums = [];
  for (let s = 0; s < count; s++) sums.push([0, 1, 2, 3, 4, 5].map((c) => { let sum = 0; for (let k = 0; k < K; k++) sum += twist[6 * (K * s + k) + c]; return sum; }));
  const turns = Array.from(twist.subarray(6 * K * scene.readout, 6 * K * (scene.readout + 1))).filter((_, k) => k % 6 > 2);
  scene.units = {
    displacement: formatOf(sums.map((sum) => Math.hypot(...sum.slice(0, 3))), scene.units.displacement),
    rotation: formatOf([...turns, ...sums[scene.readout].slice(3)], scene.units.rotation),
  };
  scene.notes = machine.warnings(solution);
  scene.facts = [factsOf(machine, closed, status, scene.on_links)];
  return scene;
}

/** Weights of five equidistant values of a polynomial of degree four in its values at 21 equidistant places. */
const WEIGHTS = Array.from({ length: 21 }, (_, n) => [0, 1, 2, 3, 4].map((j) => [0, 1, 2, 3, 4].reduce((w, k) => (k === j ? w : w * (n / 5 - k) / (j - k)), 1)));

/** Add stations between the five of each beam, whose first ones are `beams`, in ascending order. */
function addStations(scene, beams) {
  const { stations } = scene, rows = [], place = [], K = scene.contributions.length; // rows: first of the stations with weights, and these
  for (let s = 0; s < stations.count;) {
    if (beams.includes(s)) {
      for (let j = 0; j < 5; j++) place[s + j] = rows.length + 5 * j;
      for (const weights of WEIGHTS) rows.push([s, weights]);
      s += 5;
    } else { place[s] = rows.length; rows.push([s++, [1]]); }
  }
  for (const [key, width] of [["pose", 7], ["twist", 6 * K]]) {
    const data = stations[key], all = new Float64Array(width * rows.length);
    rows.forEach(([s, weights], n) => weights.forEach((weight, j) => { for (let c = 0; c < width; c++) all[width * n + c] += weight * data[width * (s + j) + c]; }));
    stations[key] = all;
  }
  stations.count = rows.length;
  scene.readout = place[scene.readout];
  for (const arrow of scene.arrows) arrow.station = place[arrow.station];
  for (const card of Object.values(scene.cards)) card.first = place[card.first];
}

/** Give all forces of a group one scale, and all its couples; the longest arrow is a fixed part of the robot's size. */
function scaleArrows(arrows, size) {
  const lengths = new Map(), key = ({ path, kind }) => `${path.split("/")[1]} ${kind}`;
  const length = ({ vector }) => Math.hypot(...[0, 1, 2].map((c) => vector.reduce((sum, x, k) => (k % 3 === c ? sum + x : sum), 0)));
  for (const arrow of arrows) lengths.set(key(arrow), Math.max(lengths.get(key(arrow)) || 0, length(arrow)));
  for (const arrow of arrows) {
    const most = lengths.get(key(arrow));
    arrow.metres_per_unit = most > 0 ? (arrow.kind === "force" ? 0.26 : 0.2) * size / most : 0;
  }
}

const FIVE = (x) => (Math.abs(x) < 5e-6 ? "0" : String(Number(x.toPrecision(5))).replace("-", "\u2212"));
const vectorText = (values) => `(${values.map(FIVE).join(", ")})`;
const wrenchText = (values) => `${vectorText(values.slice(0, 3))} N${values.slice(3).some((x) => x !== 0) ? `, ${vectorText(values.slice(3))} N\u00b7m` : ""}`;

/** Lines of the heading: pose, gravity, load, loads on links, payload, status. */
function factsOf({ data, robot, loads: { load, gravity, payload } }, { platform }, status, onLinks) {
  const pose = Object.entries(platform).map(([name, value]) => {
    const [factor, unit, noise] = "xyz".includes(name) ? [1e-3, " mm", 1e-9 * robot.length] : [Math.PI / 180, "\u00b0", 1e-9];
    const shown = Math.abs(value) <= noise ? 0 : Math.round(100 * value / factor) / 100 + 0;
    return `${name} ${String(shown).replace("-", "\u2212")}${unit}`;
  });
  const lines = [["pose", pose.join(", ")], ["gravity", `${vectorText(gravity)} m/s\u00b2`], ["load at o", wrenchText(load)], ...Object.entries(onLinks).map(([name, wrench]) => [name, wrenchText(Array.from(wrench))])];
  if (payload[0]) lines.push(["payload", `${FIVE(payload[0])} kg at ${vectorText(payload.slice(1).map((x) => 1e3 * x))} mm in the frame of ${data.carrier || "o"}`]);
  return [...lines, ["status", status.replace("_", " ")]];
}

const FIRST = [0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 4, 4, 5], SECOND = [0, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5, 2, 3, 4, 5, 3, 4, 5, 4, 5, 5];
const wavesAt = (angle) => [1, Math.cos(angle), Math.sin(angle), Math.cos(2 * angle), Math.sin(2 * angle)];
const EIGHT = Array.from({ length: 8 }, (_, k) => wavesAt(k * FULL_TURN / 8)), STARTS = Array.from({ length: 24 }, (_, k) => wavesAt(k * FULL_TURN / 24));

/** The largest von Mises stress of a section under a wrench, from the forms of stresses.py at points, or on rings at eight angles. */
function stressOf({ forms, rings }, wrench) {
  const products = FIRST.map((i, k) => wrench[i] * wrench[SECOND[k]]), squares = new Float64Array(forms.length / 21);
  for (let p = 0; p < squares.length; p++) for (let k = 0; k < 21; k++) squares[p] += forms[21 * p + k] * products[k];
  let most = 0;
  for (const square of squares) most = Math.max(most, square);
  const all = Array.from({ length: rings }, (_, ring) => { // a + b cos + c sin + d cos 2 + e sin 2 of the angle
    const coefficients = [0, 0, 0, 0, 0];
    for (let k = 0; k < 8; k++) for (let w = 0; w < 5; w++) coefficients[w] += EIGHT[k][w] * squares[8 * ring + k] * (w ? 2 : 1) / 8;
    return coefficients;
  });
  const value = (z, waves) => z[0] * waves[0] + z[1] * waves[1] + z[2] * waves[2] + z[3] * waves[3] + z[4] * waves[4];
  for (const z of all) {
    const values = STARTS.map((waves) => value(z, waves)), [, b, c, d, e] = z;
    values.forEach((at, k) => {
      if (!(at > values[(k + 23) % 24]) || at < values[(k + 1) % 24] || at < 0.96 * most) return;
      let angle = k * FULL_TURN / 24;
      for (let n = 0; n < 4; n++) { // Newton's method for the largest value
        const [, cos, sin, cos2, sin2] = wavesAt(angle), slope = -b * sin + c * cos - 2 * d * sin2 + 2 * e * cos2;
        const bend = -b * cos - c * sin - 4 * d * cos2 - 4 * e * sin2;
        if (bend < 0) angle -= Math.min(Math.max(slope / bend, -FULL_TURN / 24), FULL_TURN / 24);
      }
      most = Math.max(most, at, value(z, wavesAt(angle)));
    });
  }
  return Math.sqrt(most);
}

/** Compute the stress along a beam of known outline. */
function addStress(card, section) {
  const { axial, V_y, V_z, T, M_y, M_z } = card.lines;
  card.lines.stress = Float64Array.from(axial, (_, k) => stressOf(section, [axial[k], V_y[k], V_z[k], T[k], M_y[k], M_z[k]]));
  card.rows[card.stress_row].values = [largestOf(card.lines.stress)];
}
