// Where a group of plots is looked at: for time, also the moment that the replay shows.

function createCursor(first, last) {
  const moved = createSignal();
  return {
    now: first,
    first,
    last,
    // Where it stood when the page was opened, which is no place to play from.
    opened: null,
    on: moved.on,
    open(value) {
      this.set(value);
      this.opened = this.now;
    },
    set(value) {
      this.now = Math.min(this.last, Math.max(this.first, value));
      moved.tell();
    },
  };
}

// Runs a cursor through time at a chosen speed; it stops at the end and starts over from there.
function createPlayer(cursor) {
  const changed = createSignal();
  let before = null;
  const player = {
    playing: false,
    speed: 0.5,
    on: changed.on,
    play() {
      if (player.playing) return;
      if (cursor.now >= cursor.last || cursor.now === cursor.opened) cursor.set(cursor.first);
      player.playing = true;
      before = null;
      changed.tell();
      requestAnimationFrame(step);
    },
    pause() {
      player.playing = false;
      changed.tell();
    },
    toggle() {
      if (player.playing) player.pause();
      else player.play();
    },
  };
  function step(now_ms) {
    if (!player.playing) return;
    if (before !== null) cursor.set(cursor.now + (player.speed * (now_ms - before)) / 1000);
    before = now_ms;
    if (cursor.now >= cursor.last) player.pause();
    else requestAnimationFrame(step);
  }
  return player;
}
