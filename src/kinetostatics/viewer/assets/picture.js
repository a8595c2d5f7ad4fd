/* Images of the page: heading, robot with labels, and legend. */

/** Show or hide the handles at the platform, which are no part of a picture. */
function showHandles(on) {
  for (const { object } of handles) object.visible = on;
}

/** Apply the options at the end of the page's address: #picture&colour=stress&view=top. */
function applyAddress() {
  const options = new URLSearchParams(location.hash.slice(1));
  if (options.has("picture")) { document.body.classList.add("as-picture"); showHandles(false); }
  if (options.has("beside")) state.compared = "beside";
  if (options.has("dark")) setDark(true);
  const choice = document.querySelector("select[name='colour by']"), colour = options.get("colour");
  if ([...choice.options].some((option) => option.value === colour)) {
    choice.value = colour;
    choice.dispatchEvent(new Event("change"));
  }
  viewer.set_3d_pane_size();
  showView(options.get("view") in VIEWS ? options.get("view") : "home");
}

/** The heading, in lines of a given width. */
function factLines(ink, width) {
  const lines = [];
  for (const robot of page.robots) {
    let line = robot.scene.title;
    for (const [name, text] of facts(robot)) {
      const longer = `${line}    ${name} ${text}`;
      if (ink.measureText(longer).width <= width) { line = longer; continue; }
      lines.push(line);
      line = `${name} ${text}`;
    }
    lines.push(line);
  }
  return lines;
}

/** Return a PNG image as a data address, with `fineness` pixels per pixel of the screen. */
function picture(fineness = 2) {
  const width = stage.offsetWidth, height = stage.offsetHeight, style = getComputedStyle(document.body), below = 46;
  const canvas = make("canvas"), ink = canvas.getContext("2d"), colour = (name) => style.getPropertyValue(name).trim();
  ink.font = `400 12px ${style.fontFamily}`;
  const lines = factLines(ink, width - 24), top = 18 * lines.length + 12;
  Object.assign(canvas, { width: fineness * width, height: fineness * (height + top + below) });
  ink.scale(fineness, fineness);
  ink.fillStyle = colour("--ground");
  ink.fillRect(0, 0, width, height + top + below);
  const ratio = viewer.renderer.getPixelRatio();
  viewer.renderer.setPixelRatio(fineness);
  showHandles(false);
  viewer.render();
  showHandles(!document.body.classList.contains("as-picture"));
  ink.drawImage(viewer.renderer.domElement, 0, top, width, height); // before the browser clears it
  viewer.renderer.setPixelRatio(ratio);
  viewer.set_dirty();
  const write = (text, x, y, size, weight, fill, align = "left") => {
    Object.assign(ink, { font: `${weight} ${size}px ${style.fontFamily}`, fillStyle: fill, textAlign: align, textBaseline: "middle" });
    ink.fillText(text, x, y);
    return ink.measureText(text).width;
  };
  lines.forEach((line, k) => write(line, 12, 16 + 18 * k, 12, 400, colour("--ink")));
  for (const { element: label, leader } of labels) {
    if (label.style.visibility !== "visible") continue;
    ink.globalAlpha = label.style.opacity;
    if (leader.style.visibility === "visible") {
      const [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map((name) => Number(leader.getAttribute(name)));
      ink.strokeStyle = getComputedStyle(label).color;
      ink.beginPath(); ink.moveTo(x1, top + y1); ink.lineTo(x2, top + y2); ink.stroke();
    }
    const box = label.getBoundingClientRect(), frame = stage.getBoundingClientRect(), x = box.left - frame.left, y = top + box.top - frame.top;
    ink.fillStyle = colour("--label");
    ink.fillRect(x, y, box.width, box.height);
    label.textContent.split("\n").forEach((line, k) => write(line, x + 4, y + 15 * k + 7.5, 12, 600, getComputedStyle(label).color));
  }
  ink.globalAlpha = 1;
  const scale = colourScale(), y = top + height + 14;
  if (scale.rigid) {
    write("rigid: nothing deforms", 12, y, 13, 600, colour("--ink"));
    return canvas.toDataURL("image/png");
  }
  const left = 24 + write(`${scale.words} [${scale.unit}]`, 12, y, 13, 600, colour("--ink"));
  const long = Math.max(Math.min(320, width - left - 30), 60), bar = ink.createLinearGradient(left, 0, left + long, 0);
  scale.ramp.forEach((c, k) => bar.addColorStop(k / (scale.ramp.length - 1), c.getStyle()));
  ink.fillStyle = bar;
  ink.fillRect(left, y - 6, long, 11);
  for (const part of [0, 0.5, 1]) write(number((scale.low + part * (scale.high - scale.low)) / scale.factor), left + part * long, y + 16, 12, 400, colour("--ink"), "center");
  return canvas.toDataURL("image/png");
}

function savePicture() {
  make("a", null, { href: picture(), download: `${page.robots[0].scene.title}.png` }).click();
}
