// The span that a group of plots shows. On logarithmic axes it moves and shrinks in decades.

const SMALLEST_SHARE = 1e-3;

function createView(first, last, isLog) {
  const into = isLog ? Math.log10 : (value) => value;
  const back = isLog ? (value) => 10 ** value : (value) => value;
  const changed = createSignal();
  const view = {
    min: first,
    max: last,
    on: changed.on,
    set(min, max) {
      const [low, high] = [into(first), into(last)];
      const span = Math.min(high - low, Math.max((high - low) * SMALLEST_SHARE, into(max) - into(min)));
      const start = Math.min(high - span, Math.max(low, into(min)));
      view.min = back(start);
      view.max = back(start + span);
      changed.tell();
    },
    zoom(factor, about) {
      const [low, high] = [into(view.min), into(view.max)];
      const middle = Math.min(high, Math.max(low, into(about)));
      view.set(back(middle - (middle - low) * factor), back(middle + (high - middle) * factor));
    },
    pan(share) {
      const [low, high] = [into(view.min), into(view.max)];
      view.set(back(low + share * (high - low)), back(high + share * (high - low)));
    },
    reset() {
      [view.min, view.max] = [first, last];
      changed.tell();
    },
    // The value so many shares of the visible span away, for the arrow keys.
    beside(value, share) {
      return back(into(value) + share * (into(view.max) - into(view.min)));
    },
  };
  return view;
}

const createGroup = (first, last, isLog = false) => ({
  cursor: createCursor(first, last),
  view: createView(first, last, isLog),
});
