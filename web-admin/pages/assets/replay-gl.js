// The little of WebGL2 that the scene needs: one program for lit triangles and lines, a buffer for each mesh that is filled
// when the mesh was made anew, and the camera's matrices.

const VERTEX = `#version 300 es
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
uniform mat4 camera;
out vec3 vPlace;
out vec3 vNormal;
out vec4 vColour;
void main() {
  vPlace = place;
  vNormal = normal;
  vColour = colour;
  gl_Position = camera * vec4(place, 1.0);
}`;

// The normal of cut faces and lines, which are drawn in their plain colour.
export const PLAIN = [0, 0, 0];

// A normal of length zero is not lit. Where a drape is asked for, it lies around a window in it: middle of the window, and a direction along it.
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 vPlace;
in vec3 vNormal;
in vec4 vColour;
uniform vec3 light;
uniform float opacity;
uniform vec4 drape;
out vec4 colour;
const vec3 CLOTH = vec3(0.25, 0.51, 0.57);
// How far a place lies beyond the window, in mm: its sides are those of the simulator's own picture.
float beyond(vec2 off) {
  float across = abs(dot(off, drape.zw)) - 88.0;
  float away = dot(off, vec2(-drape.w, drape.z));
  return max(across, max(away - 95.0, -away - 66.5));
}
vec3 draped(vec3 skin) {
  float far = beyond(vPlace.xy - drape.xy);
  if (dot(drape.zw, drape.zw) < 0.5 || vNormal.z < 0.0 || far < 0.0 || far > 62.0) return skin;
  return CLOTH * mix(0.78, 1.0, smoothstep(2.5, 4.0, min(far, 62.0 - far)));
}
void main() {
  float lit = 1.0;
  if (dot(vNormal, vNormal) > 0.01) {
    lit = 0.62 + 0.38 * abs(dot(normalize(vNormal), light));
  }
  float alpha = vColour.a * opacity;
  colour = vec4(draped(vColour.rgb) * lit * alpha, alpha);
}`;

const FLOATS = 10;

function shader(gl, kind, text) {
  const made = gl.createShader(kind);
  gl.shaderSource(made, text);
  gl.compileShader(made);
  if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
  return made;
}

// Vertices in the making, and whether the painter has to take them over.
export class Mesh {
  constructor() {
    this.numbers = new Float32Array(FLOATS * 1024);
    this.clear();
  }

  clear() {
    this.length = 0;
    this.stale = true;
  }

  vertex(place, normal, colour, alpha = 1) {
    if (this.length + FLOATS > this.numbers.length) {
      const larger = new Float32Array(this.numbers.length * 2);
      larger.set(this.numbers);
      this.numbers = larger;
    }
    this.stale = true;
    this.put(place);
    this.put(normal);
    this.put(colour);
    this.numbers[this.length] = alpha;
    this.length += 1;
  }

  // Without an array in between: thousands of vertices are written for each picture.
  put(three) {
    this.numbers[this.length] = three[0];
    this.numbers[this.length + 1] = three[1];
    this.numbers[this.length + 2] = three[2];
    this.length += 3;
  }

  triangle(a, b, c, normal, colour, alpha = 1) {
    this.vertex(a, normal, colour, alpha);
    this.vertex(b, normal, colour, alpha);
    this.vertex(c, normal, colour, alpha);
  }

  // Corners in turn.
  quad(a, b, c, d, normal, colour, alpha = 1) {
    this.triangle(a, b, c, normal, colour, alpha);
    this.triangle(a, c, d, normal, colour, alpha);
  }

  line(a, b, colour, alpha = 1) {
    this.vertex(a, PLAIN, colour, alpha);
    this.vertex(b, PLAIN, colour, alpha);
  }

  get vertices() {
    return this.length / FLOATS;
  }
}

export class Painter {
  constructor(canvas) {
    const gl = canvas.getContext('webgl2', { antialias: true, premultipliedAlpha: true });
    if (!gl) throw new Error('this browser draws no WebGL2');
    this.gl = gl;
    this.program = gl.createProgram();
    gl.attachShader(this.program, shader(gl, gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(this.program, shader(gl, gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(this.program);
    this.camera = gl.getUniformLocation(this.program, 'camera');
    this.light = gl.getUniformLocation(this.program, 'light');
    this.opacity = gl.getUniformLocation(this.program, 'opacity');
    this.drape = gl.getUniformLocation(this.program, 'drape');
  }

  begin(camera, ground) {
    const gl = this.gl;
    gl.viewport(0, 0, gl.canvas.width, gl.canvas.height);
    gl.clearColor(...ground, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(this.camera, false, camera);
    gl.uniform3f(this.light, 0.36, -0.48, 0.8);
    gl.uniform1f(this.opacity, 1);
    gl.uniform4f(this.drape, 0, 0, 0, 0);
  }

  // The nearest of a mesh's surfaces over what is drawn already, which shows through, under a drape with a window around a place.
  drawDraped(mesh, opacity, [x, y], along) {
    const gl = this.gl;
    gl.uniform4f(this.drape, x, y, along[0], along[1]);
    gl.colorMask(false, false, false, false);
    this.draw(mesh);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    gl.uniform1f(this.opacity, opacity);
    this.draw(mesh);
    gl.uniform1f(this.opacity, 1);
    gl.uniform4f(this.drape, 0, 0, 0, 0);
    gl.depthFunc(gl.LESS);
  }

  draw(mesh, mode = 'TRIANGLES', writesDepth = true) {
    if (mesh.length === 0) return;
    const gl = this.gl;
    gl.depthMask(writesDepth);
    mesh.buffer ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
    if (mesh.stale) gl.bufferData(gl.ARRAY_BUFFER, mesh.numbers.subarray(0, mesh.length), gl.DYNAMIC_DRAW);
    mesh.stale = false;
    [[0, 3, 0], [1, 3, 12], [2, 4, 24]].forEach(([place, size, offset]) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, FLOATS * 4, offset);
    });
    gl.drawArrays(gl[mode], 0, mesh.vertices);
    gl.depthMask(true);
  }
}

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const scale = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// A triangle's normal, as long as twice its area.
export const normalOf = (a, b, c) => cross(add(b, scale(a, -1)), add(c, scale(a, -1)));

// The directions in which a surface faces at its corners: of the triangles about each, the larger the more.
export function facing(corners, triangles) {
  const sums = corners.map(() => [0, 0, 0]);
  for (let i = 0; i + 2 < triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => corners[triangles[i + k]]);
    const normal = normalOf(a, b, c);
    [0, 1, 2].forEach((k) => { sums[triangles[i + k]] = add(sums[triangles[i + k]], normal); });
  }
  return sums.map(unit);
}

export const unit = (a) => scale(a, 1 / (Math.sqrt(dot(a, a)) || 1));

// World to clip, by columns: the eye looks at a point, +z up.
export function lookAt(eye, at, { aspect, angle = 0.5, near = 1, far = 2000 }) {
  const back = unit(add(eye, scale(at, -1)));
  const right = unit(cross([0, 0, 1], back));
  const up = cross(back, right);
  const f = 1 / Math.tan(angle / 2);
  const view = [
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ];
  const depth = near - far;
  const lens = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0];
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 4; row += 1) {
      for (let k = 0; k < 4; k += 1) out[column * 4 + row] += lens[k * 4 + row] * view[column * 4 + k];
    }
  }
  return out;
}

// Where a place lies on a canvas of a size; none behind the eye.
export function project(camera, place, width, height) {
  const clip = [0, 1, 2, 3].map((row) => camera[row] * place[0] + camera[4 + row] * place[1]
    + camera[8 + row] * place[2] + camera[12 + row]);
  if (clip[3] <= 0) return null;
  return [(clip[0] / clip[3] * 0.5 + 0.5) * width, (0.5 - clip[1] / clip[3] * 0.5) * height];
}
