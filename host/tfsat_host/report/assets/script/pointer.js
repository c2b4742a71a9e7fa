// The pointer over a chart: moving reads, dragging zooms in, Shift and dragging pans, a double click shows all.
// A finger reads; up and down it scrolls the page as anywhere.

const DRAG_PX = 6;

function followPointer(chart, group) {
  const over = chart.over;
  const selection = el("div", { class: "selection", hidden: true });
  over.append(selection);
  let drag = null;

  const leftOf = (event) => event.clientX - over.getBoundingClientRect().left;
  const read = (event) => group.cursor.set(chart.posToVal(leftOf(event), "x"));

  over.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    group.player?.pause();
    read(event);
    if (event.pointerType !== "mouse") return;
    over.setPointerCapture(event.pointerId);
    drag = { from: leftOf(event), last: leftOf(event), pans: event.shiftKey };
    over.classList.add(drag.pans ? "pans" : "selects");
  });
  over.addEventListener("pointermove", (event) => {
    if (drag === null) {
      if (!group.player?.playing) read(event);
      return;
    }
    const left = leftOf(event);
    if (drag.pans) group.view.pan((drag.last - left) / over.clientWidth);
    else {
      showSelection(drag.from, left);
      read(event);
    }
    drag.last = left;
  });
  over.addEventListener("pointerup", () => {
    if (drag !== null && !drag.pans && Math.abs(drag.last - drag.from) >= DRAG_PX) {
      const [from, to] = [drag.from, drag.last].sort((a, b) => a - b).map((left) => chart.posToVal(left, "x"));
      group.view.set(from, to);
    }
    forget();
  });
  over.addEventListener("pointercancel", forget);
  over.addEventListener("dblclick", () => group.view.reset());

  function showSelection(from, to) {
    selection.hidden = Math.abs(to - from) < DRAG_PX;
    selection.style.left = `${Math.min(from, to)}px`;
    selection.style.width = `${Math.abs(to - from)}px`;
  }
  function forget() {
    drag = null;
    over.classList.remove("pans", "selects");
    selection.hidden = true;
  }
}
