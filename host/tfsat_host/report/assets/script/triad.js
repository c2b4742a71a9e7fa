// The inertial axes as the camera sees them, in the replay's corner.

const TRIAD_PX = 92;

function createTriad() {
  const canvas = el("canvas", { class: "triad", "aria-hidden": "true" });
  const ctx = canvas.getContext("2d");
  return {
    canvas,
    draw(camera) {
      const ratio = Math.min(2, devicePixelRatio);
      canvas.width = canvas.height = TRIAD_PX * ratio;
      ctx.setTransform(ratio, 0, 0, ratio, TRIAD_PX * ratio / 2, TRIAD_PX * ratio / 2);
      ctx.font = `600 13px ${palette().font}`;
      ctx.textAlign = "center";
      ctx.textBaseline = "middle";
      ctx.lineWidth = 2;
      const view = camera.viewMatrix();
      const axes = [0, 1, 2].map((axis) => ({ axis, tip: [view[4 * axis], view[4 * axis + 1], view[4 * axis + 2]] }));
      axes.sort((a, b) => a.tip[2] - b.tip[2]);
      for (const { axis, tip } of axes) {
        const [x, y] = [28 * tip[0], -28 * tip[1]];
        ctx.strokeStyle = ctx.fillStyle = componentColor(axis);
        ctx.beginPath();
        ctx.moveTo(0, 0);
        ctx.lineTo(x, y);
        ctx.stroke();
        ctx.fillText("xyz"[axis], 1.35 * x, 1.35 * y);
      }
    },
  };
}
