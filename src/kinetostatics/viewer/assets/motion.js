/* The numbers: stations, their poses at rest, and what each contribution does to them.
 *
 * A station is a point with a frame. At rest it has a pose; contribution k gives it a small twist [u; theta] in world axes
 * at its own point [m, rad]. With the shares s_k and the exaggeration e it stands at
 *
 *     position = p + e * sum_k s_k u_k,        rotation = exp(e * sum_k s_k theta_k) R.
 *
 * Poses and twists are stored once per frame of a path, and interpolated between frames; a single pose is one frame.
 */
const THREE = MeshCat.THREE;

let scene; // the description, its arrays decoded
let now; // the stations at the present time: {rest, deformed, sum}
const state = { exaggeration: 1, shares: [], time: 0, playing: false };

const qa = new THREE.Quaternion(), qb = new THREE.Quaternion(), axis = new THREE.Vector3(), point = new THREE.Vector3();

/** Decode a base64 string of little-endian numbers. */
function decode(text, Type) {
  return new Type(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
}

/** Decode the arrays of a description. */
function read(s) {
  for (const key of ["pose", "twist"]) s.stations[key] = decode(s.stations[key], Float32Array);
  for (const m of s.meshes) {
    m.vertices = decode(m.vertices, Float32Array);
    m.faces = decode(m.faces, Uint32Array);
    if (typeof m.station === "string") m.station = decode(m.station, Uint32Array);
    if (m.per_vertex) m.colour = Float32Array.from(decode(m.colour, Uint8Array), (c) => c / 255);
  }
  for (const a of s.arrows) {
    a.vector = decode(a.vector, Float32Array);
    for (const key of ["positive", "outward"]) if (a[key]) a[key] = decode(a[key], Float32Array);
  }
  return s;
}

/** Set q to the rotation by a rotation vector. */
function exponential(q, x, y, z) {
  const angle = Math.hypot(x, y, z);
  if (angle < 1e-12) return q.set(x / 2, y / 2, z / 2, 1).normalize();
  return q.setFromAxisAngle(axis.set(x / angle, y / angle, z / angle), angle);
}

/** The frames before and after the present time, and the weight of the second. */
function between() {
  const last = scene.stations.frames - 1, i = Math.min(Math.floor(state.time), last);
  return [i, Math.min(i + 1, last), state.time - i];
}

/** Poses at rest, deformed poses and summed true twists of all stations at the present time. */
function solve() {
  const { count, pose, twist } = scene.stations, K = scene.contributions.length, e = state.exaggeration;
  const [i, j, w] = between();
  const rest = new Float32Array(7 * count), deformed = new Float32Array(7 * count), sum = new Float32Array(6 * count);
  for (let s = 0; s < count; s++) {
    const a = 7 * (i * count + s), b = 7 * (j * count + s), o = 7 * s, t = 6 * s;
    for (let c = 0; c < 3; c++) rest[o + c] = (1 - w) * pose[a + c] + w * pose[b + c];
    qa.fromArray(pose, a + 3).slerp(qb.fromArray(pose, b + 3), w).toArray(rest, o + 3);
    for (let k = 0; k < K; k++) {
      const share = state.shares[k], ta = 6 * (K * (i * count + s) + k), tb = 6 * (K * (j * count + s) + k);
      for (let c = 0; c < 6; c++) sum[t + c] += share * ((1 - w) * twist[ta + c] + w * twist[tb + c]);
    }
    for (let c = 0; c < 3; c++) deformed[o + c] = rest[o + c] + e * sum[t + c];
    exponential(qb, e * sum[t + 3], e * sum[t + 4], e * sum[t + 5]).multiply(qa).toArray(deformed, o + 3);
  }
  return { rest, deformed, sum };
}

/** Largest true motion of any station in any frame at the present shares [m]. */
function largest() {
  const { count, frames, twist } = scene.stations, K = scene.contributions.length;
  let most = 0;
  for (let n = 0; n < count * frames; n++) {
    let x = 0, y = 0, z = 0;
    for (let k = 0; k < K; k++) {
      const o = 6 * (K * n + k), share = state.shares[k];
      x += share * twist[o]; y += share * twist[o + 1]; z += share * twist[o + 2];
    }
    most = Math.max(most, x * x + y * y + z * z);
  }
  return Math.sqrt(most);
}

/** Twist of the platform by contribution k, or their sum with the shares for null: [µm ×3, mdeg ×3]. */
function readout(k) {
  const { count, twist } = scene.stations, K = scene.contributions.length, s = scene.readout, [i, j, w] = between();
  const part = (n, c) => {
    const a = twist[6 * (K * (i * count + s) + n) + c], b = twist[6 * (K * (j * count + s) + n) + c];
    return state.shares[n] * ((1 - w) * a + w * b);
  };
  const all = k === null ? scene.contributions.map((_, n) => n) : [k];
  return [0, 1, 2, 3, 4, 5].map((c) => all.reduce((total, n) => total + part(n, c), 0) * (c < 3 ? 1e6 : 180e3 / Math.PI));
}

/** The smallest round number that is not below x. */
function roundUp(x) {
  if (!(x > 0)) return 1e-6;
  const power = Math.pow(10, Math.floor(Math.log10(x)));
  return [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((f) => f * power >= x * (1 - 1e-6)) * power;
}
