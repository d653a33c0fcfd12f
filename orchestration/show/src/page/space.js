// ---- space, by WebGL --------------------------------------------------------------------------
// Grains are squares that face the camera, and each of their pixels looks for its sphere. What is behind
// the plane shines through it: where the stencil says that something is drawn, the plane is not opaque.
const FIELD_OF_VIEW = 24;
/// Wall time of a picture that plays well [ms], and as few grains as say what a cloud does.
const WELL = 33, GRAINS_LEAST = 4000;
const world = { middle: [0, 0, 0], size: 1 };
const PLACE = `uniform mat4 modelViewMatrix, projectionMatrix; uniform vec3 middle; uniform float size;
vec4 seen(vec3 place) { return modelViewMatrix * vec4((place - middle) * size, 1.0); }`;
const SHADERS = {
  sphere: [`precision highp float; ${PLACE}
in vec2 corner; in vec3 place; in float radius; in float share; uniform float least;
out vec3 ray; flat out vec4 ball; flat out float shade;
void main() {
  vec4 c = seen(place);
  float r = max(radius * size, -c.z * least);
  ball = vec4(c.xyz, r); shade = share;
  // Before the sphere, as wide as its tangents are there.
  ray = c.xyz + vec3(corner * r * 1.1, r);
  gl_Position = projectionMatrix * vec4(ray, 1.0);
}`, `precision highp float; uniform mat4 projectionMatrix; uniform sampler2D map; uniform vec3 ink; uniform float coloured;
in vec3 ray; flat in vec4 ball; flat in float shade; out vec4 colour;
void main() {
  float a = dot(ray, ray), b = dot(ray, ball.xyz), free = b * b - a * (dot(ball.xyz, ball.xyz) - ball.w * ball.w);
  if (free < 0.0) discard;
  vec3 hit = ray * ((b - sqrt(free)) / a), normal = (hit - ball.xyz) / ball.w, light = vec3(-0.43, 0.62, 0.656);
  vec4 place = projectionMatrix * vec4(hit, 1.0);
  gl_FragDepth = 0.5 + 0.5 * place.z / place.w;
  vec3 own = coloured > 0.5 ? texture(map, vec2(shade, 0.5)).rgb : ink;
  vec3 lit = min(own * (0.46 + 0.66 * max(dot(normal, light), 0.0)), 1.0);
  float shine = 0.28 * pow(max(dot(normal, normalize(light + vec3(0.0, 0.0, 1.0))), 0.0), 24.0);
  colour = vec4(mix(lit, vec3(1.0), shine), 1.0);
}`],
  plane: [`precision highp float; ${PLACE}
in vec3 position; in float value; uniform vec2 range; out float share;
void main() { share = (value - range.x) / max(range.y - range.x, 1e-30); gl_Position = projectionMatrix * seen(position); }`,
  `precision highp float; uniform sampler2D map; uniform float opacity; in float share; out vec4 colour;
void main() { colour = vec4(texture(map, vec2(clamp(share, 0.002, 0.998), 0.5)).rgb, opacity); }`],
  line: [`precision highp float; ${PLACE} in vec3 position; void main() { gl_Position = projectionMatrix * seen(position); }`,
    `precision highp float; uniform vec3 ink; out vec4 colour; void main() { colour = vec4(ink, 1.0); }`],
};
function material(name, uniforms, more = {}) {
  const [vertexShader, fragmentShader] = SHADERS[name];
  uniforms = { middle: { value: new THREE.Vector3(...world.middle) }, size: { value: world.size }, ...uniforms };
  return new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader, fragmentShader, uniforms, side: THREE.DoubleSide, ...more });
}
function lookup() {
  const map = new THREE.DataTexture(new Uint8Array(1024), 256, 1);
  map.magFilter = map.minFilter = THREE.LinearFilter;
  return map;
}
function fillLookup(map, name) {
  const colours = table(name);
  for (let i = 0; i < 256; i++) map.image.data.set([colours[3 * i], colours[3 * i + 1], colours[3 * i + 2], 255], 4 * i);
  map.needsUpdate = true;
}
/// Everything that stays during a run.
function build() {
  world.stage = film.stage; world.mesh = world.values = world.placed = world.every = null;
  const [low, high] = film.stage.window, extent = high.map((h, axis) => h - low[axis]);
  world.size = 2 / Math.hypot(...extent); world.middle = high.map((h, axis) => (h + low[axis]) / 2);
  world.half = extent.map(e => e * world.size / 2);
  world.scene = new THREE.Scene();
  // What lies behind the plane is drawn before it, and marked.
  const marks = { stencilWrite: true, stencilRef: 1, stencilZPass: THREE.ReplaceStencilOp };
  world.grains = new THREE.Mesh(new THREE.InstancedBufferGeometry(), material('sphere', { least: { value: 0 }, map: { value: lookup() }, coloured: { value: 0 }, ink: { value: new THREE.Color() } }, marks));
  world.grains.geometry.setAttribute('corner', new THREE.BufferAttribute(new Float32Array([-1, -1, 1, -1, 1, 1, -1, 1]), 2));
  world.grains.geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const outline = new THREE.BufferGeometry();
  outline.setAttribute('position', new THREE.BufferAttribute(film.stage.outline, 3));
  world.outline = new THREE.LineSegments(outline, material('line', { ink: { value: new THREE.Color() } }, marks));
  world.map = lookup(); world.range = { value: [0, 1] };
  world.surface = new THREE.BufferGeometry();
  world.planes = [[1, 0], [0.7, 1]].map(([opacity, stencilRef]) => {
    const own = { map: { value: world.map }, range: world.range, opacity: { value: opacity } };
    return new THREE.Mesh(world.surface, material('plane', own, { transparent: true, stencilWrite: true, stencilRef, stencilFunc: THREE.EqualStencilFunc, stencilZPass: THREE.KeepStencilOp }));
  });
  [world.outline, world.grains, ...world.planes].forEach((part, order) => { part.frustumCulled = false; part.renderOrder = order; world.scene.add(part); });
  if (!world.camera) open();
  world.labels.forEach((label, axis) => label.textContent = `${'xyz'[axis]} ${quantity(extent[axis], 'm', 3)}`);
}
/// Camera, canvas and what turns them.
function open() {
  world.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  world.labels = [0, 1, 2].map(() => node('b', { class: 'edge' }));
  canvas.after(...world.labels);
  try {
    world.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, stencil: true, alpha: true, preserveDrawingBuffer: true });
    world.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  } catch (error) { $('counter').before(node('p', { class: 'muted', id: 'no-space' }, 'This browser has no WebGL 2, so the animation is not drawn; the numbers below are.')); return; }
  world.controls = new THREE.OrbitControls(world.camera, canvas);
  world.controls.enableDamping = false;
  world.controls.addEventListener('change', draw);
  canvas.setAttribute('aria-label', 'Grains and a plane of the fluid field in space. Drag turns, space plays, arrow keys step, plus and minus zoom, w a s d turn, 0 shows all.');
}
function fit() {
  if (world.stage !== film.stage) build();
  if (!world.renderer) return;
  const height = Math.max(Math.min(canvas.parentElement.clientWidth, innerHeight * 0.72, 760), 260);
  canvas.style.height = height + 'px';
  world.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
  world.renderer.setSize(canvas.parentElement.clientWidth, height, false);
  world.camera.aspect = canvas.parentElement.clientWidth / height;
  world.camera.updateProjectionMatrix();
  if (!film.view || film.view.home) look();
}
/// From in front, right and slightly above, as far away as the box needs.
function look() {
  const toward = new THREE.Vector3(Math.sin(.5) * Math.cos(.33), Math.sin(.33), Math.cos(.5) * Math.cos(.33));
  const right = new THREE.Vector3(Math.cos(.5), 0, -Math.sin(.5)), up = new THREE.Vector3().crossVectors(toward, right);
  const tall = 0.94 * Math.tan(FIELD_OF_VIEW / 360 * Math.PI), wide = tall * world.camera.aspect;
  let distance = 0;
  for (let corner = 0; corner < 8; corner++) {
    const at = new THREE.Vector3(...world.half.map((half, axis) => corner >> axis & 1 ? half : -half));
    distance = Math.max(distance, at.dot(toward) + Math.max(Math.abs(at.dot(right)) / wide, Math.abs(at.dot(up)) / tall));
  }
  world.camera.position.copy(toward.multiplyScalar(distance));
  world.controls.target.set(0, 0, 0);
  film.view = { home: true };
  world.controls.update();
}
const attribute = (geometry, name, values, width, Kind) => geometry.setAttribute(name, new Kind(values, width));
function placeGrains(shown) {
  const count = shown.position.length / 3, every = world.every || 1, drawn = Math.floor(count / every);
  const place = every > 1 ? new Float32Array(3 * drawn) : shown.position, radius = new Float32Array(drawn), share = new Float32Array(drawn);
  const most = grainRange()[1];
  for (let k = 0; k < drawn; k++) {
    const i = k * every;
    if (every > 1) place.set(shown.position.subarray(3 * i, 3 * i + 3), 3 * k);
    radius[k] = film.stage.radius[shown.id ? shown.id[i] : i];
    share[k] = shown.speed ? Math.min(.998, Math.max(.002, shown.speed[i] / most)) : 0;
  }
  const geometry = world.grains.geometry;
  for (const [name, values, width] of [['place', place, 3], ['radius', radius, 1], ['share', share, 1]]) {
    const old = geometry.getAttribute(name);
    if (old && old.array.length === values.length) { old.array.set(values); old.needsUpdate = true; }
    else { geometry.dispose(); attribute(geometry, name, values.slice(), width, THREE.InstancedBufferAttribute); }
  }
  geometry.instanceCount = drawn;
  shown.thinned = every > 1 ? ` · every ${every}${['', 'st', 'nd', 'rd'][every] || 'th'} grain is drawn, so that it plays on this machine` : '';
}
/// Grains are left out until a picture is made in time: once, with the first of them.
function settle(shown) {
  const gl = world.renderer.getContext(), pixel = new Uint8Array(4);
  const made = () => { const begun = performance.now(); world.renderer.render(world.scene, world.camera); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); return performance.now() - begun; };
  world.every = 1;
  // The first picture compiles the shaders.
  made();
  while (Math.min(made(), made()) > WELL && shown.position.length / 3 / world.every >= 2 * GRAINS_LEAST) { world.every *= 2; placeGrains(shown); }
}
function draw() {
  const shown = film.shown;
  if (!shown || !film.view || !world.renderer) return;
  const values = film.field && shown.fields[film.field], mesh = shown.mesh || film.stage.mesh;
  world.planes.forEach(plane => plane.visible = !!(values && mesh));
  if (values && mesh) {
    if (world.mesh !== mesh) {
      world.mesh = mesh; world.surface.dispose();
      attribute(world.surface, 'position', mesh.points, 3, THREE.BufferAttribute);
      world.surface.deleteAttribute('value');
      world.surface.setIndex(new THREE.BufferAttribute(mesh.triangles, 1));
    }
    if (world.values !== values) { world.values = values; attribute(world.surface, 'value', values, 1, THREE.BufferAttribute); }
    world.range.value = fieldRange(film.field);
    fillLookup(world.map, FIELDS[film.field].map());
  }
  world.grains.visible = !!shown.position && shown.position.length > 0 && $('grains').checked;
  if (world.grains.visible) {
    if (world.placed !== shown) { placeGrains(shown); world.placed = shown; }
    if (!world.every) settle(shown);
    const own = world.grains.material.uniforms;
    own.coloured.value = film.field ? 0 : 1;
    if (!film.field) fillLookup(own.map.value, 'dry');
    paint(own.ink.value, dark.matches ? 'ff9a52' : 'cf4f0c');
    own.least.value = 1.2 * Math.tan(FIELD_OF_VIEW / 360 * Math.PI) / canvas.clientHeight;
    if (shown.thinned && !$('counter').textContent.endsWith(shown.thinned)) $('counter').textContent += shown.thinned;
  }
  paint(world.outline.material.uniforms.ink.value, dark.matches ? 'b4bec7' : '3a424a');
  world.renderer.render(world.scene, world.camera);
  placeLabels(); drawScale(); drawLegend();
}
/// A colour as it is on the page, without a change of space.
const paint = (colour, hex) => colour.setRGB(...[0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255));
/// The lengths of the box, each beside the middle of an edge.
function placeLabels() {
  const [x, y, z] = world.half;
  [[0, -y, z], [-x, 0, z], [x, -y, 0]].forEach((at, axis) => {
    const seen = new THREE.Vector3(...at).project(world.camera), label = world.labels[axis];
    label.hidden = Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1 || seen.z > 1;
    label.style.left = 50 * (1 + seen.x) + '%'; label.style.top = (1 - seen.y) / 2 * canvas.clientHeight + 'px';
  });
}
/// A round length as it is seen in the middle of the view.
function drawScale() {
  const away = world.camera.position.distanceTo(world.controls.target);
  const pixels = world.size * canvas.clientHeight / (2 * Math.tan(FIELD_OF_VIEW / 360 * Math.PI) * away);
  const most = 0.2 * canvas.clientWidth / pixels, decade = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map(s => s * decade).find(s => s <= most);
  $('scale').firstElementChild.style.width = length * pixels + 'px';
  $('scale').lastElementChild.textContent = quantity(length, 'm');
}
function zoom(factor) {
  if (!world.renderer) return;
  film.view.home = false;
  const { camera, controls } = world, from = camera.position.clone().sub(controls.target);
  from.setLength(Math.min(Math.max(from.length() / factor, 0.02), 60));
  camera.position.copy(controls.target).add(from);
  controls.update(); draw();
}
/// Turn about the target, by keys.
function move(right, up) {
  if (!world.renderer) return;
  film.view.home = false;
  const { camera, controls } = world, from = camera.position.clone().sub(controls.target), away = from.length();
  const around = Math.atan2(from.x, from.z) + 0.12 * right, above = Math.min(Math.max(Math.asin(from.y / away) + 0.12 * up, -1.5), 1.5);
  camera.position.copy(controls.target).add(new THREE.Vector3(Math.sin(around) * Math.cos(above), Math.sin(above), Math.cos(around) * Math.cos(above)).multiplyScalar(away));
  controls.update(); draw();
}
const home = () => { if (world.renderer) { look(); draw(); } };
function handle() {
  // Over the picture the wheel scrolls the page until the picture has the focus.
  canvas.parentElement.addEventListener('wheel', event => { if (!event.ctrlKey && document.activeElement !== canvas) event.stopPropagation(); }, { capture: true });
  canvas.addEventListener('pointerdown', () => { canvas.focus(); if (film.view) film.view.home = false; });
}
begin();
