// Bodies by WebGL: what was measured solid, what the model predicts as a veil with its edges drawn.

const VERTEX = `
attribute vec4 position;
attribute vec3 normal;
uniform mat4 view, projection, model;
varying vec3 v_normal;
void main() {
  gl_Position = projection * view * model * position;
  v_normal = mat3(model) * normal;
}`;

const FRAGMENT = `
precision mediump float;
uniform vec4 color;
uniform vec3 light;
uniform float shading;
varying vec3 v_normal;
void main() {
  float lit = 0.62 + 0.38 * dot(normalize(v_normal), light);
  gl_FragColor = vec4(color.rgb * mix(1.0, lit, shading) * color.a, color.a);
}`;

const darker = ([red, green, blue]) => [0.45 * red, 0.45 * green, 0.45 * blue, 1];

const LIGHT = twgl.v3.normalize([0.9, 0.1, 0.75]);

// Null where the browser has no WebGL.
function createScene(canvas) {
  const gl = canvas.getContext("webgl", { alpha: true, antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = twgl.createProgramInfo(gl, [VERTEX, FRAGMENT]);
  let bodies = [];
  let ring = null;

  function draw(buffers, mode, uniforms) {
    twgl.setBuffersAndAttributes(gl, program, buffers);
    twgl.setUniforms(program, uniforms);
    twgl.drawBufferInfo(gl, buffers, mode);
  }
  function drawBody(body, matrix, color, edges) {
    gl.enable(gl.POLYGON_OFFSET_FILL);
    draw(body.faces, gl.TRIANGLES, { model: matrix, color, shading: 1 });
    gl.disable(gl.POLYGON_OFFSET_FILL);
    draw(body.edges, gl.LINES, { model: matrix, color: edges, shading: 0 });
  }
  return {
    load(replay, room) {
      bodies = replay.bodies.map(({ boxes_m }) => ({
        faces: twgl.createBufferInfoFromArrays(gl, trianglesOf(boxes_m)),
        edges: twgl.createBufferInfoFromArrays(gl, edgesOf(boxes_m)),
      }));
      ring = twgl.createBufferInfoFromArrays(gl, ringOf(room));
    },
    // `floors`: where the rings lie, one below each robot.
    draw(camera, measured, ghost, floors) {
      twgl.resizeCanvasToDisplaySize(canvas, Math.min(2, devicePixelRatio));
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.useProgram(program.program);
      twgl.setUniforms(program, {
        view: camera.viewMatrix(),
        projection: camera.projection(canvas.width / canvas.height),
        light: LIGHT,
      });
      gl.depthMask(true);
      for (const model of floors) draw(ring, gl.LINES, { model, color: channels(palette().quiet, 0.7), shading: 0 });
      gl.polygonOffset(1, 1);
      measured.forEach((matrix, i) => {
        if (matrix) drawBody(bodies[i], matrix, channels(bodyColor(i)), darker(channels(bodyColor(i))));
      });
      // Drawn after, and pulled forward, so that the solid faces beneath do not flicker through.
      gl.depthMask(false);
      gl.polygonOffset(-1, -1);
      ghost?.forEach((matrix, i) => {
        const veil = floors.length > 1 ? channels(bodyColor(i), 0.35) : channels(palette().ink, 0.05);
        if (matrix) drawBody(bodies[i], matrix, veil, channels(palette().ink));
      });
      gl.depthMask(true);
    },
  };
}
