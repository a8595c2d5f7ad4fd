/* Poses and twists of stations, by contribution.
 *
 * A station is a point with a frame. At rest it has a pose; contribution k gives it a small twist [u; theta] in world axes
 * at its own point [m, rad]. With the shares s_k and the exaggeration e it stands at
 *
 *     position = p + e * sum_k s_k u_k,        rotation = exp(e * sum_k s_k theta_k) R,
 *
 * where e of a mode is multiplied by the sine of its phase.
 *
 * Poses and twists are stored once per frame of a path, and interpolated between frames; a single pose is one frame.
 */
const THREE = MeshCat.THREE;

const state = { exaggeration: 1, shares: new Map(), time: 0, playing: false, quantity: "deflection", compared: "ghost", mode: null };

const qa = new THREE.Quaternion(), qb = new THREE.Quaternion(), axis = new THREE.Vector3(), point = new THREE.Vector3();

/** Decode a base64 string of little-endian numbers, or a packed path. */
function decode(packed, Type) {
  if (typeof packed !== "string" && packed.length !== undefined) return Type.from(packed); // computed by the page
  return typeof packed === "string" ? new Type(bytesOf(packed).buffer) : unpackPath(packed);
}

/** Decode the arrays of a description or of its changes. */
function read(s) {
  if (s.stations) for (const key of ["pose", "twist"]) s.stations[key] = decode(s.stations[key], Float32Array);
  for (const m of s.meshes || []) {
    m.vertices = decode(m.vertices, Float32Array);
    m.faces = unpackIndices(m.faces);
    if (m.copies) {
      const points = m.vertices, copies = unpackIndices(m.copies);
      m.vertices = new Float32Array(3 * copies.length).map((_, k) => points[3 * copies[Math.floor(k / 3)] + k % 3]);
    }
    if (typeof m.station === "string") m.station = decode(m.station, Uint32Array);
    if (m.recovery) m.recovery = decode(m.recovery, Float32Array);
    if (m.per_vertex) m.colour = Float32Array.from(decode(m.colour, Uint8Array), (c) => c / 255);
  }
  for (const a of s.arrows || []) {
    a.vector = decode(a.vector, Float32Array);
    for (const key of ["positive", "outward"]) if (a[key]) a[key] = decode(a[key], Float32Array);
  }
  for (const card of Object.values(s.cards || {})) {
    for (const row of card.rows) row.values = decode(row.values, Float32Array);
    for (const name of Object.keys(card.lines)) card.lines[name] = decode(card.lines[name], Float32Array);
  }
  return s;
}

/** The present share of every contribution of a scene. */
function shares(scene) {
  return scene.contributions.map((name) => state.shares.get(name) ?? 1);
}

/** Set q to the rotation by a rotation vector. */
function exponential(q, x, y, z) {
  const angle = Math.hypot(x, y, z);
  if (angle < 1e-12) return q.set(x / 2, y / 2, z / 2, 1).normalize();
  return q.setFromAxisAngle(axis.set(x / angle, y / angle, z / angle), angle);
}

/** The frames before and after the present time, and the weight of the second. */
function between(scene) {
  const last = scene.stations.frames - 1, time = Math.min(state.time, last), i = Math.floor(time);
  return [i, Math.min(i + 1, last), time - i];
}

/** Numbers (width) of a path (frames, width) at the present time. */
function interpolated(scene, data, width) {
  const [i, j, w] = between(scene);
  return Array.from({ length: width }, (_, c) => (w > 0 ? (1 - w) * data[width * i + c] + w * data[width * j + c] : data[width * i + c]));
}

/** Poses at rest, deformed poses and summed true twists of all stations at the present time. */
function solve(scene) {
  const { count, pose, twist } = scene.stations, K = scene.contributions.length, e = state.exaggeration * swing(), part = shares(scene);
  const [i, j, w] = between(scene);
  const rest = new Float32Array(7 * count), deformed = new Float32Array(7 * count), sum = new Float32Array(6 * count);
  for (let s = 0; s < count; s++) {
    const a = 7 * (i * count + s), b = 7 * (j * count + s), o = 7 * s, t = 6 * s;
    for (let c = 0; c < 3; c++) rest[o + c] = (1 - w) * pose[a + c] + w * pose[b + c];
    qa.fromArray(pose, a + 3).slerp(qb.fromArray(pose, b + 3), w).toArray(rest, o + 3);
    for (let k = 0; k < K; k++) {
      const ta = 6 * (K * (i * count + s) + k), tb = 6 * (K * (j * count + s) + k);
      for (let c = 0; c < 6; c++) sum[t + c] += part[k] * ((1 - w) * twist[ta + c] + w * twist[tb + c]);
    }
    for (let c = 0; c < 3; c++) deformed[o + c] = rest[o + c] + e * sum[t + c];
    exponential(qb, e * sum[t + 3], e * sum[t + 4], e * sum[t + 5]).multiply(qa).toArray(deformed, o + 3);
  }
  return { rest, deformed, sum };
}

/** True displacements (3 n) of a mesh's vertices, world axes: its recovery (n, 3, 6 s) times the twists of its station and the next. */
function recovered({ rest, sum }, { recovery, station, vertices }) {
  const count = vertices.length, width = recovery.length / count, [first] = station, coordinates = new Float32Array(width);
  const axes = new THREE.Quaternion().fromArray(rest, 7 * first + 3), back = axes.clone().conjugate(), result = new Float32Array(count);
  for (let k = 0; k < width; k += 3) point.fromArray(sum, 6 * first + k).applyQuaternion(back).toArray(coordinates, k);
  for (let i = 0; i < count; i++) for (let k = 0; k < width; k++) result[i] += recovery[width * i + k] * coordinates[k];
  for (let i = 0; i < count; i += 3) point.fromArray(result, i).applyQuaternion(axes).toArray(result, i);
  return result;
}

/** Largest true displacement of all stations in all frames at the present shares [m]. */
function largest(scene) {
  const { count, frames, twist } = scene.stations, K = scene.contributions.length, part = shares(scene);
  let most = 0;
  for (let n = 0; n < count * frames; n++) {
    let x = 0, y = 0, z = 0;
    for (let k = 0; k < K; k++) {
      const o = 6 * (K * n + k);
      x += part[k] * twist[o]; y += part[k] * twist[o + 1]; z += part[k] * twist[o + 2];
    }
    most = Math.max(most, x * x + y * y + z * z);
  }
  return Math.sqrt(most);
}

/** Twist of the platform by contribution k, times its share; for null, by all contributions [m, rad]. */
function readout(scene, k) {
  const { count, twist } = scene.stations, K = scene.contributions.length, s = scene.readout, [i, j, w] = between(scene);
  const part = shares(scene), all = k === null ? part.map((_, n) => n) : [k];
  return [0, 1, 2, 3, 4, 5].map((c) => all.reduce((total, n) => {
    const a = twist[6 * (K * (i * count + s) + n) + c], b = twist[6 * (K * (j * count + s) + n) + c];
    return total + part[n] * ((1 - w) * a + w * b);
  }, 0));
}

/** The smallest round number not below x. */
function roundUp(x) {
  if (!(x > 0)) return 1e-6;
  const power = Math.pow(10, Math.floor(Math.log10(x)));
  return [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((f) => f * power >= x * (1 - 1e-6)) * power;
}
