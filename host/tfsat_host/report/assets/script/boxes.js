// Boxes as triangles with normals, and as edges.

// Each face: its outward normal, and its corners (0 low, 1 high in x, y, z) around it.
const FACES = [
  { normal: [1, 0, 0], corners: [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]] },
  { normal: [-1, 0, 0], corners: [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]] },
  { normal: [0, 1, 0], corners: [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]] },
  { normal: [0, -1, 0], corners: [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]] },
  { normal: [0, 0, 1], corners: [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]] },
  { normal: [0, 0, -1], corners: [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]] },
];

const facesOf = (boxes) =>
  boxes.flatMap((box) =>
    FACES.map(({ normal, corners }) => ({
      normal,
      corners: corners.map((corner) => corner.map((side, axis) => box[side][axis])),
    })),
  );

function trianglesOf(boxes) {
  const position = [];
  const normals = [];
  for (const { normal, corners } of facesOf(boxes)) {
    for (const i of [0, 1, 2, 0, 2, 3]) {
      position.push(...corners[i]);
      normals.push(...normal);
    }
  }
  return { position: { numComponents: 3, data: position }, normal: { numComponents: 3, data: normals } };
}

// Every edge belongs to two faces: drawn twice, which nobody sees.
function edgesOf(boxes) {
  const position = [];
  for (const { corners } of facesOf(boxes)) {
    corners.forEach((corner, i) => position.push(...corner, ...corners[(i + 1) % 4]));
  }
  return { position: { numComponents: 3, data: position } };
}

// A ring below the robot with a tick every ten degrees, to read its heading by; the one on x is longest.
function ringOf({ middle, radius: room, low }) {
  const radius = 0.62 * room;
  const position = [];
  const at = (r, angle) => [middle[0] + r * Math.cos(angle), middle[1] + r * Math.sin(angle), low];
  for (let degrees = 0; degrees < 360; degrees += 5) {
    const angle = (degrees * Math.PI) / 180;
    position.push(...at(radius, angle), ...at(radius, angle + Math.PI / 36));
    if (degrees % 10 === 0) {
      const inner = degrees === 0 ? 0.72 : degrees % 90 === 0 ? 0.86 : 0.94;
      position.push(...at(inner * radius, angle), ...at(radius, angle));
    }
  }
  return { position: { numComponents: 3, data: position } };
}
