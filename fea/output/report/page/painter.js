// Draws with WebGL 2: the surface in the bands of its legend, found anew at every pixel; and loads.

const SURFACE_VERTEX = `#version 300 es
in vec3 place; in vec3 move; in vec4 normal; in float value; in vec4 lines;
uniform mat4 camera; uniform float scale;
out float shown; out vec3 facing; out vec3 corner; out vec3 kinds;
void main() {
  gl_Position = camera * vec4(place + scale * move, 1.0);
  shown = value; facing = normal.xyz; kinds = lines.xyz;
  int k = gl_VertexID % 3;
  corner = vec3(k == 0, k == 1, k == 2);
}`;
const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
uniform float limits[16]; uniform vec3 colours[16]; uniform int bands;
uniform vec3 towards; uniform vec3 ink; uniform float pixel; uniform float mesh;
in float shown; in vec3 facing; in vec3 corner; in vec3 kinds;
out vec4 colour;
void main() {
  vec3 base = vec3(0.62);
  if (shown < 1e29) {
    base = colours[0];
    for (int i = 1; i < 16; i++) if (i < bands && shown >= limits[i]) base = colours[i];
  }
  float light = clamp(0.5 + 0.62 * dot(normalize(facing), towards), 0.0, 1.0);
  vec3 away = corner / max(fwidth(corner), vec3(1e-7)) / pixel;
  vec3 fine = (1.0 - smoothstep(0.1, 0.9, away)) * step(0.5, kinds) * 0.38 * mesh;
  colour = vec4(mix(base * light, ink, max(fine.x, max(fine.y, fine.z))), 1.0);
}`;
const EDGE_VERTEX = `#version 300 es
in vec3 place; in vec3 move;
uniform mat4 camera; uniform float scale;
void main() { gl_Position = camera * vec4(place + scale * move, 1.0); }`;
const EDGE_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 ink;
out vec4 colour;
void main() { colour = vec4(ink, 1.0); }`;
const LOAD_VERTEX = `#version 300 es
in vec3 place; in vec3 normal;
uniform mat4 camera;
out vec3 facing;
void main() { gl_Position = camera * vec4(place, 1.0); facing = normal; }`;
const LOAD_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 tint; uniform vec3 towards;
in vec3 facing;
out vec4 colour;
void main() {
  float light = dot(facing, facing) < 0.5 ? 1.0 : 0.6 + 0.4 * abs(dot(normalize(facing), towards));
  colour = vec4(tint.rgb * light * tint.a, tint.a);
}`;

class Painter {
  constructor(canvas, surface) {
    const options = { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true };
    this.gl = canvas.getContext("webgl2", options);
    if (!this.gl) throw new Error("no WebGL 2");
    this.canvas = canvas;
    this.surface = surface;
    this.prepare();
  }

  // Free what `prepare` made, before it is called for another surface.
  release() {
    const gl = this.gl;
    for (const program of [this.program, this.edgeProgram, this.loadProgram]) gl.deleteProgram(program);
    for (const array of [this.array, this.edgeArray, this.loadArray]) gl.deleteVertexArray(array);
  }

  prepare() {
    const gl = this.gl, { triangles, positions } = this.surface;
    this.places = spread(positions, triangles, 3);
    this.moves = new Float32Array(3 * triangles.length);
    this.shown = new Float32Array(triangles.length);
    this.program = linked(gl, SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    attribute(gl, this.program, "place", this.places, 3, gl.FLOAT);
    this.moveBuffer = attribute(gl, this.program, "move", this.moves, 3, gl.FLOAT);
    attribute(gl, this.program, "normal", this.surface.normals, 4, gl.BYTE, true);
    this.valueBuffer = attribute(gl, this.program, "value", this.shown, 1, gl.FLOAT);
    attribute(gl, this.program, "lines", this.surface.lines, 4, gl.UNSIGNED_BYTE);
    this.edgeProgram = linked(gl, EDGE_VERTEX, EDGE_FRAGMENT);
    this.edgeArray = gl.createVertexArray();
    gl.bindVertexArray(this.edgeArray);
    attribute(gl, this.edgeProgram, "place", spread(positions, this.surface.sharp, 3), 3, gl.FLOAT);
    this.edgeMoves = new Float32Array(3 * this.surface.sharp.length);
    this.edgeBuffer = attribute(gl, this.edgeProgram, "move", this.edgeMoves, 3, gl.FLOAT);
    this.loadProgram = linked(gl, LOAD_VERTEX, LOAD_FRAGMENT);
    this.loadArray = gl.createVertexArray();
    gl.bindVertexArray(this.loadArray);
    this.loadPlaces = attribute(gl, this.loadProgram, "place", new Float32Array(3), 3, gl.FLOAT);
    this.loadNormals = attribute(gl, this.loadProgram, "normal", new Float32Array(3), 3, gl.FLOAT);
    this.loads = [];
    gl.bindVertexArray(null);
  }

  move(displacement) {
    spread(displacement, this.surface.triangles, 3, this.moves);
    refill(this.gl, this.moveBuffer, this.moves);
    spread(displacement, this.surface.sharp, 3, this.edgeMoves);
    refill(this.gl, this.edgeBuffer, this.edgeMoves);
  }

  colour(values) {
    const { triangles } = this.surface;
    for (let i = 0; i < triangles.length; i++) {
      const value = values[triangles[i]];
      this.shown[i] = Number.isNaN(value) ? 1e30 : value;
    }
    refill(this.gl, this.valueBuffer, this.shown);
  }

  // Solids to be drawn over the rod: {places, normals, tint}.
  load(solids) {
    let start = 0;
    this.loads = solids.map(({ places, tint }) => {
      const own = { start, count: places.length / 3, tint };
      start += own.count;
      return own;
    });
    const joined = (name) => Float32Array.from(solids.flatMap((solid) => solid[name]));
    refill(this.gl, this.loadPlaces, joined("places"));
    refill(this.gl, this.loadNormals, joined("normals"));
  }

  draw(camera, { field, scale, mesh, ink }) {
    const gl = this.gl, { canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    const matrix = camera.matrix(), at = (program, name) => gl.getUniformLocation(program, name);
    gl.useProgram(this.program);
    const p = this.program, colours = field.colours.flatMap(rgb);
    gl.uniformMatrix4fv(at(p, "camera"), false, matrix);
    gl.uniform1f(at(p, "scale"), scale);
    gl.uniform1fv(at(p, "limits"), field.limits);
    gl.uniform3fv(at(p, "colours"), colours);
    gl.uniform1i(at(p, "bands"), field.colours.length);
    gl.uniform3fv(at(p, "towards"), camera.towards);
    gl.uniform3fv(at(p, "ink"), ink);
    gl.uniform1f(at(p, "pixel"), Math.max(1, canvas.width / Math.max(1, canvas.clientWidth)));
    gl.uniform1f(at(p, "mesh"), mesh ? 1 : 0);
    gl.bindVertexArray(this.array);
    // The surface behind its edges.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    gl.drawArrays(gl.TRIANGLES, 0, this.shown.length);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.useProgram(this.edgeProgram);
    gl.uniformMatrix4fv(at(this.edgeProgram, "camera"), false, matrix);
    gl.uniform1f(at(this.edgeProgram, "scale"), scale);
    gl.uniform3fv(at(this.edgeProgram, "ink"), ink);
    gl.bindVertexArray(this.edgeArray);
    gl.drawArrays(gl.LINES, 0, this.surface.sharp.length);
    if (this.loads.length) this.drawLoads(camera, matrix);
    gl.bindVertexArray(null);
  }

  drawLoads(camera, matrix) {
    const gl = this.gl, p = this.loadProgram;
    gl.useProgram(p);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.uniformMatrix4fv(gl.getUniformLocation(p, "camera"), false, matrix);
    gl.uniform3fv(gl.getUniformLocation(p, "towards"), camera.towards);
    gl.bindVertexArray(this.loadArray);
    for (const { start, count, tint } of this.loads) {
      gl.uniform4fv(gl.getUniformLocation(p, "tint"), tint);
      gl.drawArrays(gl.TRIANGLES, start, count);
    }
  }
}

const rgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);

function spread(values, nodes, width, out = new Float32Array(width * nodes.length)) {
  for (let i = 0; i < nodes.length; i++) {
    for (let k = 0; k < width; k++) out[width * i + k] = values[width * nodes[i] + k];
  }
  return out;
}

function attribute(gl, program, name, data, size, type, normalised = false) {
  const buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, size, type, normalised, 0, 0);
  return buffer;
}

function refill(gl, buffer, data) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
}

function linked(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}
