// Bodies without WebGL: faces on a plain canvas, the farthest first.

function createStill(canvas) {
  const ctx = canvas.getContext("2d");
  let bodies = [];
  return {
    load(replay) {
      bodies = replay.bodies.map(({ boxes_m }) => facesOf(boxes_m));
    },
    draw(camera, measured, ghost) {
      twgl.resizeCanvasToDisplaySize(canvas, Math.min(2, devicePixelRatio));
      ctx.clearRect(0, 0, canvas.width, canvas.height);
      const view = camera.viewMatrix();
      const projection = camera.projection(canvas.width / canvas.height);
      const faces = measured.flatMap((matrix, i) =>
        matrix ? bodies[i].map((face) => ({ ...seen(face, matrix, view), color: bodyColor(i) })) : [],
      );
      faces.sort((a, b) => a.depth - b.depth);
      for (const face of faces) paintFace(ctx, projection, face, false);
      ghost?.forEach((matrix, i) => {
        for (const face of matrix ? bodies[i] : []) paintFace(ctx, projection, seen(face, matrix, view), true);
      });
    },
  };
}

// A face in the camera's frame, which looks along -z.
function seen({ normal, corners }, matrix, view) {
  const placed = corners.map((corner) => twgl.m4.transformPoint(view, transformed(matrix, corner)));
  const turned = twgl.m4.transformDirection(matrix, normal);
  return {
    corners: placed,
    depth: placed.reduce((sum, corner) => sum + corner[2], 0) / 4,
    lit: 0.62 + 0.38 * twgl.v3.dot(turned, LIGHT),
  };
}

function paintFace(ctx, projection, { corners, lit, color }, isGhost) {
  const { width, height } = ctx.canvas;
  ctx.beginPath();
  for (const corner of corners) {
    const [x, y] = twgl.m4.transformPoint(projection, corner);
    ctx.lineTo(((x + 1) / 2) * width, ((1 - y) / 2) * height);
  }
  ctx.closePath();
  if (!isGhost) {
    const [red, green, blue] = channels(color).map((part) => Math.round(255 * part * lit));
    ctx.fillStyle = `rgb(${red} ${green} ${blue})`;
    ctx.fill();
  }
  ctx.strokeStyle = palette().ink;
  ctx.setLineDash(isGhost ? [6, 4] : []);
  ctx.lineWidth = devicePixelRatio;
  ctx.stroke();
}
