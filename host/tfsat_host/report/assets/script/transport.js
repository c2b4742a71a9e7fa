// Play, speed and scrub: the cursor of the time plots by hand.

const SPEEDS = [1, 0.5, 0.25, 0.1];

function createTransport(group, modelChoice) {
  const { cursor, player } = group;
  const play = el("button", { type: "button", class: "play", on: { click: player.toggle } });
  const scrub = el("input", {
    type: "range",
    min: cursor.first,
    max: cursor.last,
    step: "any",
    "aria-label": "Time after release",
    on: {
      input() {
        player.pause();
        cursor.set(Number(scrub.value));
      },
    },
  });
  const speed = el(
    "select",
    { "aria-label": "Speed", on: { change: () => (player.speed = Number(speed.value)) } },
    ...SPEEDS.map((value) => el("option", { value, selected: value === player.speed }, `${value}×`)),
  );
  const showTime = () => {
    scrub.value = cursor.now;
    scrub.setAttribute("aria-valuetext", seconds(cursor.now));
  };
  const showState = () => {
    play.textContent = player.playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", player.playing ? "Pause" : "Play");
  };
  const stops = [cursor.on(showTime), player.on(showState)];
  showTime();
  showState();
  return {
    element: el(
      "div",
      { class: "transport", role: "group", "aria-label": "Replay controls" },
      play,
      scrub,
      el("label", {}, el("span", { class: "word" }, "Speed "), speed),
      modelChoice,
    ),
    destroy() {
      player.pause();
      for (const stop of stops) stop();
    },
  };
}
