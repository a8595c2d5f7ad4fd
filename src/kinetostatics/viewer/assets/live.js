/* Live pages: sliders of drives and platform ask the program for an analysis. */

let asking = false, waiting = null;

function buildLive(parent) {
  for (const c of page.robots[0].scene.live.controls) {
    slider(parent, c.name, c.name, c.value, c.min, c.max, (x) => moveLive(c.name, x), (x) => fixed(x, c.step < 0.1 ? 2 : 1));
  }
}

/** A live slider moved: ask for an analysis. One question at a time; of those that wait the last wins. */
async function moveLive(name, value) {
  const { live } = page.robots[0].scene, moved = live.controls.find((c) => c.name === name), values = {};
  moved.value = value;
  for (const c of live.controls) if (c.kind === moved.kind) values[c.coordinate] = c.value;
  waiting = { kind: moved.kind, values };
  if (asking) return;
  asking = true;
  try {
    while (waiting) {
      const question = JSON.stringify(waiting);
      waiting = null;
      const answer = await fetch(live.url, { method: "POST", headers: { "Content-Type": "application/json" }, body: question });
      const body = await answer.json();
      page.error = body.error || null;
      if (body.error || waiting) refresh(); else showAnswer(body);
    }
  } catch (error) {
    page.error = `no answer: has the program ended? (${error.message})`;
    refresh();
  } finally {
    asking = false;
    page.answers += 1;
  }
}

/** Show a new scene, and the coordinates that follow from those that were moved, without asking again. */
function showAnswer(description) {
  const [robot] = page.robots;
  robot.load(description);
  for (const c of robot.scene.live.controls) controls.get(c.name).set(c.value);
  refresh();
}
