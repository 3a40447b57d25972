/** Meshes for the tests: planar hexagons on a paraboloid, as the upper envelope of its tangent planes. */

const HALF = Math.sqrt(3) / 2;
/** Corners of a hexagon round its centre, in units of half the width and a quarter of the height. */
const RING = [
  [0, -4],
  [1, -2],
  [1, 2],
  [0, 4],
  [-1, 2],
  [-1, -2],
];

/** `rows * columns` planar hexagons whose sides seen from above are 1; `bend` is the paraboloid's curvature. */
export function paraboloid(rows, columns, bend) {
  const numbers = new Map();
  const positions = [];
  const faces = [];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const [x, y] = [2 * column + (row % 2) - columns, 6 * row - 3 * rows];
      const seed = [x * HALF, y / 4];
      faces.push(
        RING.map(([dx, dy]) => {
          const key = `${x + dx},${y + dy}`;
          if (!numbers.has(key)) {
            numbers.set(key, positions.length);
            const p = [(x + dx) * HALF, (y + dy) / 4];
            // On the tangent plane at the seed; the three planes at a corner meet there.
            const height = bend * (seed[0] * p[0] + seed[1] * p[1] - (seed[0] ** 2 + seed[1] ** 2) / 2);
            positions.push([p[0], p[1], -height]);
          }
          return numbers.get(key);
        }),
      );
    }
  }
  return { positions, faces };
}

/** A mesh as the text of an OBJ file. */
export function obj({ positions, faces }) {
  const vertices = positions.map((p) => `v ${p.join(" ")}`);
  return [...vertices, ...faces.map((f) => `f ${f.map((v) => v + 1).join(" ")}`), ""].join("\n");
}

/** The same mesh with a corner of a face pulled across the opposite side, so that the face crosses itself. */
export function broken(mesh, face) {
  const positions = mesh.positions.map((p) => [...p]);
  const corners = mesh.faces[face];
  const [a, b] = [positions[corners[0]], positions[corners[3]]];
  positions[corners[0]] = a.map((x, k) => x + 1.35 * (b[k] - x));
  return { positions, faces: mesh.faces };
}

/** The same mesh with every second vertex lifted. */
export function lifted(mesh, height) {
  const positions = mesh.positions.map(([x, y, z], k) => [x, y, z + (k % 2) * height]);
  return { positions, faces: mesh.faces };
}
