// Where the bodies are at a time: positions on straight lines between samples, attitudes on the shorter arc.

// Of each body its 4x4 matrix, columns first, or null where the drop does not say.
function posesAt(t_s, poses, t) {
  let i = nearest(t_s, t);
  if (t_s[i] > t && i > 0) i -= 1;
  const next = Math.min(i + 1, t_s.length - 1);
  const share = next === i ? 0 : Math.min(1, Math.max(0, (t - t_s[i]) / (t_s[next] - t_s[i])));
  return poses[i].map((pose, body) => between(pose, poses[next][body], share));
}

function between(a, b, share) {
  if (a.includes(null) || b.includes(null)) return null;
  const same = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1;
  const mixed = a.map((value, i) => (1 - share) * value + share * (i > 2 ? same : 1) * b[i]);
  return matrixOf(mixed);
}

function matrixOf([px, py, pz, qx, qy, qz, qw]) {
  const length = Math.hypot(qx, qy, qz, qw) || 1;
  const [x, y, z, w] = [qx / length, qy / length, qz / length, qw / length];
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0,
    2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0,
    2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0,
    px, py, pz, 1,
  ];
}

const transformed = (m, [x, y, z]) => [0, 1, 2].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);

// Middle and radius of the room that the whole replay needs.
function roomOf(replay) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const step = Math.max(1, Math.floor(replay.t_s.length / 50));
  for (let i = 0; i < replay.t_s.length; i += step) {
    posesAt(replay.t_s, replay.measured, replay.t_s[i]).forEach((matrix, body) => {
      if (matrix === null) return;
      for (const corner of replay.bodies[body].boxes_m.flat().map((point) => transformed(matrix, point))) {
        corner.forEach((value, axis) => {
          low[axis] = Math.min(low[axis], value);
          high[axis] = Math.max(high[axis], value);
        });
      }
    });
  }
  if (!low.every(Number.isFinite)) return { middle: [0, 0, 0], radius: 0.3, low: -0.3 };
  const middle = low.map((value, axis) => (value + high[axis]) / 2);
  return { middle, radius: Math.hypot(...high.map((value, axis) => value - low[axis])) / 2 || 0.3, low: low[2] };
}
