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

/** Modules of WebAssembly, from the streams of packing.py; sizes are written in five bytes. */
function unpackCode(bytes, modules) {
  let from = 0;
  const take = (count) => bytes.subarray(from, from += count);
  return modules.map(({ start, end, functions, instructions, operands }) => {
    const head = take(start), tail = take(end), kinds = take(instructions), next = {};
    for (const [kind, lag, count] of operands) {
      const numbers = fromPlanes(take(4 * count)).map((x) => (x >>> 1) ^ -(x & 1));
      for (let k = lag; k < count; k++) numbers[k] += numbers[k - lag];
      let k = 0;
      next[kind] = () => numbers[k++];
    }
    const code = new Uint8Array(start + end + 9 * instructions + 6 * functions + 8 * operands[0][2] + 11);
    let at = start;
    const put = (number) => { for (; number > 127; number >>>= 7) code[at++] = (number & 127) | 128; code[at++] = number; };
    const open = () => (at += 5), close = (first) => { for (let k = 0; k < 5; k++) code[first - 5 + k] = ((at - first) / 128 ** k & 127) | (k < 4 ? 128 : 0); };
    code.set(head);
    code[at++] = 10;
    const section = open();
    put(functions);
    let body = null;
    for (const kind of kinds) {
      if (body === null) {
        body = open();
        const groups = next[0]();
        put(groups);
        for (let k = 0; k < 2 * groups; k++) put(next[0]());
      }
      code[at++] = kind;
      if (kind === 0x2b || kind === 0x39) code[at++] = 3;
      if (kind === 0x44) at += 8;
      if (next[kind]) put(next[kind]());
      if (kind === 0x0b) { close(body); body = null; }
    }
    close(section);
    code.set(tail, at);
    return code.subarray(0, at + end);
  });
}
