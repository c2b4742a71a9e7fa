// How the replay is looked at: around its middle, by mouse, fingers or keys.

const START = { yaw: 0.7, pitch: 0.42, closeness: 1.12 };
const FIELD_OF_VIEW = 0.5;
const STEEPEST = 1.5;

function createCamera(canvas) {
  const moved = createSignal();
  const camera = {
    ...START,
    room: { middle: [0, 0, 0], radius: 0.3, low: 0 },
    on: moved.on,
    turn(yaw, pitch) {
      camera.yaw += yaw;
      camera.pitch = Math.max(-STEEPEST, Math.min(STEEPEST, camera.pitch + pitch));
      moved.tell();
    },
    approach(factor) {
      camera.closeness = Math.max(0.4, Math.min(4, camera.closeness * factor));
      moved.tell();
    },
    reset() {
      Object.assign(camera, START);
      moved.tell();
    },
    eye() {
      const distance = (1.12 * camera.room.radius) / Math.sin(FIELD_OF_VIEW / 2) / camera.closeness;
      const flat = Math.cos(camera.pitch);
      return [flat * Math.cos(camera.yaw), flat * Math.sin(camera.yaw), Math.sin(camera.pitch)].map(
        (part, axis) => camera.room.middle[axis] + distance * part,
      );
    },
    // World to view, and view to screen.
    viewMatrix: () => twgl.m4.inverse(twgl.m4.lookAt(camera.eye(), camera.room.middle, [0, 0, 1])),
    projection(aspect) {
      const upright = aspect >= 1 ? FIELD_OF_VIEW : 2 * Math.atan(Math.tan(FIELD_OF_VIEW / 2) / aspect);
      return twgl.m4.perspective(upright, aspect, 0.05, 20);
    },
  };
  orbitByPointer(canvas, camera);
  return camera;
}

function orbitByPointer(canvas, camera) {
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) camera.turn(-0.008 * event.movementX, 0.008 * event.movementY);
  });
  canvas.addEventListener("dblclick", () => camera.reset());
  // Only where the reader has chosen the replay: elsewhere the wheel scrolls the page.
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      camera.approach(Math.exp(-0.0015 * event.deltaY));
    },
    { passive: false },
  );
}
