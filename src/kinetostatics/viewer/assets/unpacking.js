/* Decompression of meshcat's script and of the description of the scene. */

/** The bytes of a base64 string. */
function bytesOf(text) {
  const binary = atob(text), bytes = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; k++) bytes[k] = binary.charCodeAt(k);
  return bytes;
}

/** Start meshcat, then draw the scene. */
async function unpackPage() {
  const packed = document.getElementById("robot-packed");
  if (!window.DecompressionStream) {
    document.getElementById("robot-title").textContent = "This page needs a browser of 2023 or newer.";
    return;
  }
  const stream = new Blob([bytesOf(packed.textContent)]).stream().pipeThrough(new DecompressionStream("gzip"));
  const { meshcat, scene, engine } = JSON.parse(await new Response(stream).text());
  packed.remove();
  document.head.append(Object.assign(document.createElement("script"), { textContent: meshcat })); // runs at once
  window.viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
  const computed = await (engine ? Machine.load(engine) : Promise.resolve(null)).catch((error) => {
    scene.notes.unshift(`this browser does not compute the robot, and shows the given pose only: ${error.message}`);
    return null;
  });
  start(scene, computed);
}

/** The numbers of a path, (frames, …) in single precision, from the second differences of packing.py. */
function unpackPath({ frames, width, step, data }) {
  const bytes = bytesOf(data), columns = bytes.length / (4 * frames), whole = new Int32Array(frames * columns);
  const column = new Int32Array(frames);
  for (let c = 0; c < columns; c++) {
    column.fill(0);
    for (let plane = 0; plane < 4; plane++) {
      for (let f = 0; f < frames; f++) column[f] |= bytes[(plane * columns + c) * frames + f] << (8 * plane);
    }
    for (let f = 0; f < frames; f++) column[f] = (column[f] >>> 1) ^ -(column[f] & 1);
    for (let n = 0; n < 2; n++) for (let f = 1; f < frames; f++) column[f] += column[f - 1]; // wraps at 32 bits
    for (let f = 0; f < frames; f++) whole[f * columns + c] = column[f];
  }
  return step ? Float32Array.from(whole, (x, k) => x * step[(k % columns) % width]) : new Float32Array(whole.buffer);
}

/** Integers from their bytes, all lowest bytes first. */
function fromPlanes(bytes) {
  const n = bytes.length / 4;
  return new Int32Array(n).map((_, k) => bytes[k] | bytes[n + k] << 8 | bytes[2 * n + k] << 16 | bytes[3 * n + k] << 24);
}

/** Whole numbers, from their distances from the next new one, as packing.py writes them. */
function unpackIndices(data) {
  let next = 0;
  return Uint32Array.from(fromPlanes(bytesOf(data)), (distance) => {
    const index = next - distance;
    next = Math.max(next, index + 1);
    return index;
  });
}

/** Modules of WebAssembly, from the streams of packing.py. */
function unpackCode(bytes, modules) {
  let from = 0;
  const take = (count) => bytes.subarray(from, from += count);
  return modules.map(({ size, start, instructions, operands }) => {
    const code = new Uint8Array(size), next = {};
    let at = start, head = true;
    code.set(take(start));
    const kinds = take(instructions);
    for (const [kind, lag, count] of operands) {
      const numbers = fromPlanes(take(4 * count)).map((x) => (x >>> 1) ^ -(x & 1));
      for (let k = lag; k < count; k++) numbers[k] += numbers[k - lag];
      let k = 0;
      next[kind] = () => numbers[k++];
    }
    const put = (number) => { for (let x = number; ; x >>>= 7) { code[at++] = x > 127 ? x & 127 | 128 : x; if (x < 128) return number; } };
    for (const kind of kinds) {
      if (head) {
        put(next[0]());
        for (let k = 2 * put(next[0]()); k > 0; k--) put(next[0]());
      }
      code[at++] = kind;
      if (kind === 0x2b || kind === 0x39) code[at++] = 3;
      if (kind === 0x44) at += 8;
      if (next[kind]) put(next[kind]());
      head = kind === 0x0b;
    }
    code.set(take(size - at), at);
    return code;
  });
}
