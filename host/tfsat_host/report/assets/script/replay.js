// The replay: the measured bodies beside the nominal model's, or those of 59/70 one joint at a time, at the cursor's time, in the drop's inertial frame.

const NO_WEBGL = "This browser has no WebGL: the bodies are drawn on a plain canvas, with the same poses.";
const MODEL_VIEWS = [["beside", "beside"], ["over", "overlaid"], ["hidden", "hidden"]];
const REFERENCE_VIEW = ["reference", "59/70 beside"];
const REFERENCE = "59/70 simulated";
const MODEL = "nominal model";
const SIDE_BY_SIDE = 0.55;

function createReplay() {
  const canvas = el("canvas", {
    class: "bodies",
    tabindex: "0",
    role: "application",
    "aria-label": "Replay of the drop in three dimensions. Arrow keys turn the view, plus and minus zoom, zero resets it.",
  });
  const scene = createScene(canvas);
  const drawer = scene ?? createStill(canvas);
  const camera = createCamera(canvas);
  const triad = createTriad();
  const when = el("span", { class: "when" });
  const what = el("span", { class: "what said", dir: "auto" });
  const names = el("ul", { class: "bodies-key" });
  const note = el("p", { class: "note said", dir: "auto", hidden: true });
  const modelView = el("select", { "aria-label": "Model", on: { change: () => draw() } });
  const modelChoice = el("label", {}, el("span", { class: "word" }, "Model "), modelView);
  const sides = el("p", { class: "sides", "aria-hidden": "true" }, el("span", {}, "measured"), el("span", { class: "other" }));
  const element = el(
    "figure",
    { class: "replay", "aria-label": "Replay in three dimensions" },
    el("div", { class: "stage" }, el("p", { class: "caption" }, when, el("span", {}, "·"), what), canvas, triad.canvas, sides),
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
    const ofReference = shown === "reference";
    const isBeside = shown === "beside" || ofReference;
    for (const each of element.querySelectorAll(".other")) each.textContent = ofReference ? REFERENCE : MODEL;
    const apart = isBeside ? SIDE_BY_SIDE : 0;
    sides.style.visibility = isBeside ? "" : "hidden";
    names.classList.toggle("beside", isBeside);
    const measured = movedAside(posesAt(replay.t_s, replay.measured, t), -apart);
    const ghost = shown === "hidden" ? null : movedAside(posesAt(replay.t_s, ofReference ? replay.reference : replay.model, t), apart);
    const floors = movedAside([twgl.m4.identity()], -apart);
    drawer.draw(camera, measured, ghost, isBeside ? [...floors, ...movedAside([twgl.m4.identity()], apart)] : floors);
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
      const chosen = modelView.value || MODEL_VIEWS[0][0];
      const views = replay?.reference ? [...MODEL_VIEWS, REFERENCE_VIEW] : MODEL_VIEWS;
      modelView.replaceChildren(...views.map(([value, text]) => el("option", { value }, text)));
      modelView.value = views.some(([value]) => value === chosen) ? chosen : MODEL_VIEWS[0][0];
      note.hidden = Boolean(replay && scene);
      note.textContent = replay ? NO_WEBGL : chosenDrop().no_replay;
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
  if (replay.model) items.push(el("li", { class: "outlined" }, el("span", { class: "chip ghost", "aria-hidden": "true" }), el("span", { class: "other" })));
  return items;
}
