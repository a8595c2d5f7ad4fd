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

/** Whole numbers, from their distances from the next new one, as packing.py writes them. */
function unpackIndices(data) {
  const bytes = bytesOf(data), n = bytes.length / 4;
  let next = 0;
  return new Uint32Array(n).map((_, k) => {
    const index = next - (bytes[k] | bytes[n + k] << 8 | bytes[2 * n + k] << 16 | bytes[3 * n + k] << 24);
    next = Math.max(next, index + 1);
    return index;
  });
}
