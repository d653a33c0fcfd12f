// ---- the plane, on a canvas -------------------------------------------------------------------
const pen = canvas.getContext('2d');
/// The part of the world that is shown, with the canvas' own proportions.
function fit() {
  const [[x0, y0], [x1, y1]] = film.stage.window, w = x1 - x0 || 1e-3, h = y1 - y0 || 1e-3;
  const room = canvas.parentElement.clientWidth;
  const tall = Math.min(innerHeight * 0.72, 760);
  let height = Math.max(Math.min(room * h / w, tall), 200);
  canvas.style.height = height + 'px';
  const ratio = Math.min(devicePixelRatio || 1, 2);
  canvas.width = Math.round(canvas.clientWidth * ratio); canvas.height = Math.round(height * ratio);
  const scale = Math.min(canvas.width / w, canvas.height / h) * 0.97;
  film.full = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale };
  if (!film.view || film.view.home) film.view = { ...film.full, home: true };
}
const toX = x => (x - film.view.x) * film.view.scale + canvas.width / 2;
const toY = y => canvas.height / 2 - (y - film.view.y) * film.view.scale;
/// Triangles with linear colours, into the pixels of the canvas.
function paint({ points, triangles }, values, range, colours) {
  const W = canvas.width, H = canvas.height;
  const image = pen.getImageData(0, 0, W, H), out = new Uint32Array(image.data.buffer);
  const lookup = new Uint32Array(256);
  for (let i = 0; i < 256; i++) lookup[i] = 0xff000000 | colours[3 * i + 2] << 16 | colours[3 * i + 1] << 8 | colours[3 * i];
  const factor = range[1] > range[0] ? 255 / (range[1] - range[0]) : 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    const ax = toX(points[2 * a]), ay = toY(points[2 * a + 1]), bx = toX(points[2 * b]), by = toY(points[2 * b + 1]), cx = toX(points[2 * c]), cy = toY(points[2 * c + 1]);
    const x0 = Math.max(0, Math.floor(Math.min(ax, bx, cx) - .5)), x1 = Math.min(W - 1, Math.ceil(Math.max(ax, bx, cx)));
    const y0 = Math.max(0, Math.floor(Math.min(ay, by, cy) - .5)), y1 = Math.min(H - 1, Math.ceil(Math.max(ay, by, cy)));
    if (x0 > x1 || y0 > y1) continue;
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (area === 0) continue;
    const va = (values[a] - range[0]) * factor, vb = (values[b] - range[0]) * factor, vc = (values[c] - range[0]) * factor;
    // Shares of b and c are linear in the pixel; the slack closes seams between triangles.
    const slack = -0.002, dbx = (cy - ay) / area, dby = -(cx - ax) / area, dcx = -(by - ay) / area, dcy = (bx - ax) / area;
    for (let y = y0; y <= y1; y++) {
      let wb = (x0 + .5 - ax) * dbx + (y + .5 - ay) * dby, wc = (x0 + .5 - ax) * dcx + (y + .5 - ay) * dcy;
      for (let x = x0, k = y * W + x0; x <= x1; x++, k++, wb += dbx, wc += dcx) {
        if (wb < slack || wc < slack || wb + wc > 1 - slack) continue;
        const v = va + (vb - va) * wb + (vc - va) * wc;
        out[k] = lookup[v < 0 ? 0 : v > 255 ? 255 : v | 0];
      }
    }
  }
  pen.putImageData(image, 0, 0);
}
function paintGrains(shown) {
  const position = shown.position, radius = film.stage.radius, count = position.length / 2;
  const dry = !film.field, range = grainRange(), colours = table('dry');
  const ratio = canvas.width / canvas.clientWidth, least = 0.75 * ratio;
  const style = dark.matches ? '#ff9a52' : '#cf4f0c';
  pen.fillStyle = style;
  for (let i = 0; i < count; i++) {
    const x = toX(position[2 * i]), y = toY(position[2 * i + 1]), r = Math.max(radius[shown.id ? shown.id[i] : i] * film.view.scale, least);
    if (x < -r || y < -r || x > canvas.width + r || y > canvas.height + r) continue;
    if (dry && shown.speed) {
      const k = 3 * Math.min(255, Math.floor(255 * shown.speed[i] / range[1]));
      pen.fillStyle = `rgb(${colours[k]},${colours[k + 1]},${colours[k + 2]})`;
    }
    if (r < 1.3 * ratio) { pen.fillRect(x - r, y - r, 2 * r, 2 * r); continue; }
    pen.beginPath(); pen.arc(x, y, r, 0, 7); pen.fill();
    if (r > 5) { pen.strokeStyle = dark.matches ? '#0008' : '#fff9'; pen.lineWidth = ratio * .7; pen.stroke(); }
  }
}
function draw() {
  const shown = film.shown, view = film.view;
  if (!shown || !view) return;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  const values = film.field && shown.fields[film.field];
  const mesh = shown.mesh || film.stage.mesh;
  if (values && mesh) paint(mesh, values, fieldRange(film.field), table(FIELDS[film.field].map()));
  if (shown.position && $('grains').checked) paintGrains(shown);
  const o = film.stage.outline;
  pen.strokeStyle = getComputedStyle(document.body).color;
  pen.lineWidth = 1.2 * canvas.width / canvas.clientWidth;
  pen.beginPath();
  for (let i = 0; i < o.length; i += 4) { pen.moveTo(toX(o[i]), toY(o[i + 1])); pen.lineTo(toX(o[i + 2]), toY(o[i + 3])); }
  pen.stroke();
  drawScale(); drawLegend();
}
function drawScale() {
  const ratio = canvas.width / canvas.clientWidth, most = 0.25 * canvas.width / film.view.scale;
  const decade = 10 ** Math.floor(Math.log10(most)), length = [5, 2, 1].map(s => s * decade).find(s => s <= most);
  $('scale').firstElementChild.style.width = length * film.view.scale / ratio + 'px';
  $('scale').lastElementChild.textContent = quantity(length, 'm');
}
function zoom(factor, x = canvas.width / 2, y = canvas.height / 2) {
  const view = film.view, scale = Math.min(Math.max(view.scale * factor, film.full.scale * 0.5), film.full.scale * 2000);
  const wx = view.x + (x - canvas.width / 2) / view.scale, wy = view.y - (y - canvas.height / 2) / view.scale;
  film.view = { scale, x: wx - (x - canvas.width / 2) / scale, y: wy + (y - canvas.height / 2) / scale };
  draw();
}
const home = () => { film.view = { ...film.full, home: true }; draw(); };
const move = (right, up) => { film.view.x += 40 * right / film.view.scale; film.view.y += 40 * up / film.view.scale; draw(); };
function handle() {
  canvas.addEventListener('wheel', event => {
    if (!event.ctrlKey && document.activeElement !== canvas) return;
    event.preventDefault();
    const ratio = canvas.width / canvas.clientWidth;
    zoom(Math.exp(-event.deltaY * .0015), event.offsetX * ratio, event.offsetY * ratio);
  }, { passive: false });
  canvas.addEventListener('dblclick', event => { const ratio = canvas.width / canvas.clientWidth; zoom(2, event.offsetX * ratio, event.offsetY * ratio); });
  let held = null;
  canvas.addEventListener('pointerdown', event => { if (event.pointerType !== 'touch' || !film.view.home) { held = event; canvas.setPointerCapture(event.pointerId); } canvas.focus(); });
  canvas.addEventListener('pointerup', () => held = null);
  canvas.addEventListener('pointerleave', () => $('probe').hidden = true);
  canvas.addEventListener('pointermove', event => {
    const ratio = canvas.width / canvas.clientWidth;
    if (held) {
      film.view = { ...film.view, home: false };
      film.view.x -= (event.clientX - held.clientX) * ratio / film.view.scale;
      film.view.y += (event.clientY - held.clientY) * ratio / film.view.scale;
      held = event; draw();
    } else probe(event.offsetX * ratio, event.offsetY * ratio);
  });
}
/// Value at the node nearest to a pixel.
function probe(px, py) {
  const values = film.field && film.shown && film.shown.fields[film.field];
  const mesh = film.stage && (film.shown && film.shown.mesh || film.stage.mesh), points = mesh && mesh.points;
  if (!values || !points) return;
  const x = film.view.x + (px - canvas.width / 2) / film.view.scale, y = film.view.y - (py - canvas.height / 2) / film.view.scale;
  let best = -1, least = Infinity;
  for (let i = 0; i < values.length; i++) { const d = (points[2 * i] - x) ** 2 + (points[2 * i + 1] - y) ** 2; if (d < least) { least = d; best = i; } }
  $('probe').hidden = false;
  $('probe').textContent = `x ${quantity(x, 'm', 3)}, y ${quantity(y, 'm', 3)}: ${quantity(values[best], FIELDS[film.field].unit, 3)}`;
}
begin();
