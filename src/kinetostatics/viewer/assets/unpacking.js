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
  const { meshcat, scene } = JSON.parse(await new Response(stream).text());
  packed.remove();
  document.head.append(Object.assign(document.createElement("script"), { textContent: meshcat })); // runs at once
  window.viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
  start(scene);
}

/** The numbers of a path, (frames, …) in single precision, from the differences of packing.py. */
function unpackPath({ frames, width, step, planes, data }) {
  const bytes = bytesOf(data), columns = bytes.length / (1 + frames * planes), whole = new Int32Array(frames * columns);
  const column = new Int32Array(frames);
  for (let c = 0; c < columns; c++) {
    column.fill(0);
    for (let plane = 0, o = columns + c * frames; plane < planes; plane++, o += columns * frames) {
      for (let f = 0; f < frames; f++) column[f] |= bytes[o + f] << (8 * plane);
    }
    const prediction = bytes[c], before = Math.min(Math.floor(prediction / 3), Math.floor(c / width)); // previous items used
    for (let f = 0; f < frames; f++) column[f] = (column[f] >>> 1) ^ -(column[f] & 1);
    for (let n = prediction % 3; n > 0; n--) for (let f = 1; f < frames; f++) column[f] += column[f - 1];
    for (let f = 0, o = c; f < frames; f++, o += columns) {
      const guess = before === 0 ? 0 : before === 1 ? whole[o - width] : 2 * whole[o - width] - whole[o - 2 * width];
      whole[o] = column[f] + guess; // wraps around at 32 bits
    }
  }
  return step ? Float32Array.from(whole, (x, k) => x * step[(k % columns) % width]) : new Float32Array(whole.buffer);
}
