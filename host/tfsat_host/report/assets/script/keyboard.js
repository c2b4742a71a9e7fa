// The keys. On a focused replay they turn it; elsewhere they move and zoom what is focused, or else time.

const KEYS_HELP = [
  ["← →", "move the cursor; with Shift, pan"],
  ["Home, End", "first and last moment"],
  ["+ −", "zoom about the cursor"],
  ["0", "show everything"],
  ["Space", "play, pause"],
  ["drag a plot", "zoom in; with Shift, pan; double click shows everything"],
  ["on the replay", "drag or arrow keys turn it, + − zoom, 0 turns it back"],
];

const TURN_RAD = 0.12;
const ALL_KEYS_ITS_OWN = "input:not([type=checkbox]), select, textarea, .scrolling";
const PRESSED_BY_SPACE = "input, button, a, summary";

const onPlots = {
  ArrowLeft: ({ cursor, view }, shift) => (shift ? view.pan(-0.1) : cursor.set(view.beside(cursor.now, -0.005))),
  ArrowRight: ({ cursor, view }, shift) => (shift ? view.pan(0.1) : cursor.set(view.beside(cursor.now, 0.005))),
  Home: ({ cursor }) => cursor.set(cursor.first),
  End: ({ cursor }) => cursor.set(cursor.last),
  "+": ({ cursor, view }) => view.zoom(0.5, cursor.now),
  "=": ({ cursor, view }) => view.zoom(0.5, cursor.now),
  "-": ({ cursor, view }) => view.zoom(2, cursor.now),
  0: ({ view }) => view.reset(),
};

const onReplay = {
  ArrowLeft: (camera) => camera.turn(-TURN_RAD, 0),
  ArrowRight: (camera) => camera.turn(TURN_RAD, 0),
  ArrowUp: (camera) => camera.turn(0, TURN_RAD),
  ArrowDown: (camera) => camera.turn(0, -TURN_RAD),
  "+": (camera) => camera.approach(1.15),
  "=": (camera) => camera.approach(1.15),
  "-": (camera) => camera.approach(1 / 1.15),
  0: (camera) => camera.reset(),
};

// `groupAt(element)` is the group of the plot that holds the element, or that of time.
function listenToKeys(groupAt, replay) {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isItsOwn(event)) return;
    if (event.key === " ") groupAt(null).player.toggle();
    else if (event.target === replay.canvas && onReplay[event.key]) onReplay[event.key](replay.camera);
    else if (onPlots[event.key]) moveByKey(groupAt(event.target), event);
    else return;
    event.preventDefault();
  });
}

// What has the focus keeps the keys that it needs itself: a button that was clicked does not need the arrows.
function isItsOwn({ key, target }) {
  return Boolean(target.closest?.(ALL_KEYS_ITS_OWN) || (key === " " && target.closest?.(PRESSED_BY_SPACE)));
}

function moveByKey(group, event) {
  group.player?.pause();
  onPlots[event.key](group, event.shiftKey);
  const { cursor, view } = group;
  const span = view.max - view.min;
  if (!event.shiftKey && (cursor.now < view.min || cursor.now > view.max)) view.pan((cursor.now - (view.min + view.max) / 2) / span);
}

const keysHelp = () =>
  el(
    "details",
    { class: "keys" },
    el("summary", {}, "Keys and mouse"),
    el("dl", {}, ...KEYS_HELP.flatMap(([key, does]) => [el("dt", {}, key), el("dd", {}, does)])),
  );
