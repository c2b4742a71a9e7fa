// The replay: bodies and the model's ghost at the cursor's time, in the drop's inertial frame.

const NO_WEBGL = "This browser offers no WebGL here, so the bodies are drawn on a plain canvas: the same poses, face by face.";
const NO_POSES = "This drop has no replay: without an attitude over time there is nothing to show.";
const MODEL_VIEWS = [["over", "over it"], ["beside", "beside it"], ["hidden", "hidden"]];
const SIDE_BY_SIDE = 0.45;

function createReplay() {
  const canvas = el("canvas", {
    class: "bodies",
    tabindex: "0",
    role: "img",
    "aria-label": "Replay of the bodies. Arrow keys turn the view, plus and minus zoom, zero resets it.",
  });
  const scene = createScene(canvas);
  const drawer = scene ?? createStill(canvas);
  const camera = createCamera(canvas);
  const triad = createTriad();
  const when = el("span", { class: "when" });
  const what = el("span", { class: "what said", dir: "auto" });
  const names = el("ul", { class: "bodies-key" });
  const note = el("p", { class: "note", hidden: true });
  const modelView = el("select", { "aria-label": "Model", on: { change: () => draw() } },
    ...MODEL_VIEWS.map(([value, text]) => el("option", { value }, text)));
  const modelChoice = el("label", {}, "Model ", modelView);
  const element = el(
    "figure",
    { class: "replay", "aria-label": "Replay in three dimensions" },
    el("div", { class: "stage" }, canvas, triad.canvas, el("p", { class: "caption" }, when, el("span", { class: "separator" }, "·"), what)),
    names,
    note,
  );
  let group = null;
  let replay = null;

  function draw() {
    if (!replay) return;
    const t = group.cursor.now;
    when.textContent = seconds(t);
    what.textContent = inWords(chosenDrop(), t);
    const shown = replay.model ? modelView.value : "hidden";
    const apart = shown === "beside" ? SIDE_BY_SIDE : 0;
    const measured = movedAside(posesAt(replay.t_s, replay.measured, t), -apart);
    const ghost = shown === "hidden" ? null : movedAside(posesAt(replay.t_s, replay.model, t), apart);
    drawer.draw(camera, measured, ghost);
    triad.draw(camera);
  }
  // To the right as the camera sees it, by a share of the room that the robot needs.
  function movedAside(matrices, share) {
    const far = share * camera.room.radius;
    const [x, y] = [-far * Math.sin(camera.yaw), far * Math.cos(camera.yaw)];
    return matrices.map((matrix) => matrix && [...matrix.slice(0, 12), matrix[12] + x, matrix[13] + y, matrix[14], 1]);
  }
  camera.on(draw);
  paletteChanged.on(draw);
  new ResizeObserver(draw).observe(canvas);
  return {
    element,
    modelChoice,
    camera,
    canvas,
    show(ofGroup) {
      group = ofGroup;
      replay = chosenDrop().replay;
      element.classList.toggle("empty", !replay);
      modelChoice.hidden = !replay?.model;
      note.hidden = Boolean(replay && scene);
      note.textContent = replay ? NO_WEBGL : NO_POSES;
      if (!replay) {
        names.replaceChildren();
        return () => {};
      }
      camera.room = roomOf(replay);
      drawer.load(replay, camera.room);
      names.replaceChildren(...keyOf(replay));
      draw();
      return group.cursor.on(draw);
    },
  };
}

function keyOf(replay) {
  const items = replay.bodies.map((body, i) =>
    el("li", {}, el("span", { class: `chip body-${i % 4}`, "aria-hidden": "true" }), said(body.name)));
  if (replay.model) items.push(el("li", {}, el("span", { class: "chip ghost", "aria-hidden": "true" }), "model's prediction"));
  return items;
}
