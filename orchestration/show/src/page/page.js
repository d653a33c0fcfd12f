'use strict';
const $ = id => document.getElementById(id);
let data = JSON.parse($('data').textContent);
const inSpace = () => data.dimension === 3;

// ---- numbers and units ------------------------------------------------------------------------
const PREFIX = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
const minus = text => text.replace('-', '−');
/// A unit for values up to `size`, and what it is in the base unit.
function unitFor(size, base) {
  if (base === '' || !(size > 0)) return { factor: 1, name: base };
  const list = ['m', 'm/s', 's'].includes(base) ? PREFIX.filter(p => p[0] <= 1) : PREFIX;
  const found = list.find(p => size >= p[0] * 0.5) || list[list.length - 1];
  if (base === '1/s') return { factor: 1, name: '1/s' };
  return { factor: found[0], name: found[1] + base };
}
function number(value, digits = 4) {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [m, e] = value.toExponential(Math.min(digits - 1, 2)).split('e');
    return minus(m.replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '')) + '·10' + high(+e);
  }
  return minus(String(+value.toPrecision(digits)));
}
const high = power => String(power).split('').map(c => '⁰¹²³⁴⁵⁶⁷⁸⁹'['0123456789'.indexOf(c)] || '⁻').join('');
const ten = power => Math.abs(power) < 3 ? number(10 ** power) : '10' + high(power);
function quantity(value, base, digits) {
  const unit = unitFor(Math.abs(value), base);
  return number(value / unit.factor, digits) + (unit.name ? ' ' + unit.name : '');
}
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1), decade = 10 ** Math.floor(Math.log10(rough));
  if (!(rough > 0)) return [low];
  const step = [1, 2, 5, 10].map(s => s * decade).find(s => s >= rough * (1 - 1e-9));
  const out = [];
  for (let i = Math.ceil(low / step - 1e-9); i <= high / step + 1e-9; i++) out.push(i * step);
  return out;
}
const node = (name, attributes = {}, ...children) => {
  const it = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) it.setAttribute(key, value);
  it.append(...children);
  return it;
};

// ---- packed arrays ----------------------------------------------------------------------------
async function bytes(text) {
  const raw = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
async function unpack(text, width, Kind) {
  const planes = await bytes(text), count = planes.length / width, out = new Uint8Array(planes.length);
  for (let p = 0; p < width; p++) for (let i = 0; i < count; i++) out[i * width + p] = planes[p * count + i];
  return new Kind(out.buffer);
}
async function shares(field) {
  const words = await unpack(field.data, 2, Uint16Array), out = new Float32Array(words.length);
  const step = (field.high - field.low) / 65535;
  for (let i = 0; i < words.length; i++) out[i] = field.low + step * words[i];
  return out;
}

// ---- colours ----------------------------------------------------------------------------------
const dark = matchMedia('(prefers-color-scheme: dark)');
const MAPS = {
  light: ['f8fbfd', 'd4e7f2', 'a0cde2', '62aace', '3080b4', '165491', '0a2a5c'],
  dark: ['10171d', '12304d', '15507f', '2a78ab', '5aa5cc', '9fd0e6', 'eef8fc'],
  dry: ['2e2a54', '345c8d', '27898d', '53b26c', 'b5d03e', 'f7d648'],
  twoLight: ['1a4f8f', '5b97c4', 'b7d4e6', 'f7f7f5', 'f1c3ac', 'd9805f', '9c2f1f'],
  twoDark: ['8fc6ff', '3f86c6', '1f4263', '14191d', '5c2f22', 'c25c3c', 'ffb598'],
};
const tables = {};
function table(name) {
  if (tables[name]) return tables[name];
  const anchors = MAPS[name].map(hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16)));
  const out = new Uint8Array(768);
  for (let i = 0; i < 256; i++) {
    const at = i / 255 * (anchors.length - 1), k = Math.min(Math.floor(at), anchors.length - 2), w = at - k;
    for (let c = 0; c < 3; c++) out[3 * i + c] = Math.round(anchors[k][c] * (1 - w) + anchors[k + 1][c] * w);
  }
  return tables[name] = out;
}
const FIELDS = {
  speed: { label: 'speed', long: 'fluid speed', unit: 'm/s', map: () => dark.matches ? 'dark' : 'light', range: (lo, hi) => [0, hi] },
  pressure: { label: 'pressure', long: 'pressure without ρgy', unit: 'Pa', map: () => dark.matches ? 'twoDark' : 'twoLight', range: both },
  porosity: { label: 'porosity', long: 'porosity', unit: '', map: () => dark.matches ? 'light' : 'dark', range: (lo, hi) => [lo, Math.min(Math.max(hi, lo + 1e-3), 1)] },
  vorticity: { label: 'vorticity', long: inSpace() ? 'vorticity across the plane' : 'vorticity', unit: '1/s', map: () => dark.matches ? 'twoDark' : 'twoLight', range: both },
};
function both(lo, hi) { const size = Math.max(-lo, hi); return [-size, size]; }

// ---- where states come from -------------------------------------------------------------------
const cache = new Map();
async function state(index) {
  if (cache.has(index)) return cache.get(index);
  const promise = (async () => {
    const packed = data.live ? await ask('api/state/' + index) : data.frames[index];
    const out = { time: packed.time, fields: {} };
    if (packed.mesh) out.mesh = await unpackMesh(packed.mesh);
    for (const [name, field] of Object.entries(packed.fields)) out.fields[name] = await shares(field);
    if (packed.position) out.position = await unpack(packed.position, 4, Float32Array);
    if (packed.grain_speed) out.speed = await shares(packed.grain_speed);
    if (packed.grain_id) out.id = await unpack(packed.grain_id, 4, Uint32Array);
    return out;
  })();
  cache.set(index, promise);
  if (cache.size > 60) cache.delete(cache.keys().next().value);
  promise.catch(() => cache.delete(index));
  return promise;
}
async function unpackMesh(mesh) {
  return { points: await unpack(mesh.points, 4, Float32Array), triangles: await unpack(mesh.triangles, 4, Uint32Array) };
}
async function ask(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(path + ': ' + await answer.text());
  return answer.json();
}

// ---- the animation, which plane.js or space.js draws ------------------------------------------------------
const canvas = $('canvas');
const film = { index: 0, field: null, playing: false, stage: null, view: null, shown: null, frames: [] };
async function setStage() {
  const from = data.stage;
  if (!from || film.stage) return;
  const stage = { window: from.window };
  stage.outline = await unpack(from.outline, 4, Float32Array);
  stage.radius = await unpack(from.radius, 4, Float32Array);
  stage.mesh = from.mesh && await unpackMesh(from.mesh);
  film.stage = stage;
}
function chooseFields() {
  const names = Object.keys(FIELDS).filter(name => data.frames.some(f => f.usual[name]));
  if (names.length === $('fields').children.length) return;
  $('fields').replaceChildren(...names.map((name, i) => {
    const input = node('input', { type: 'radio', name: 'field', value: name });
    input.checked = i === 0;
    input.addEventListener('change', () => { film.field = name; draw(); });
    return node('label', {}, input, FIELDS[name].label);
  }));
  film.field = names[0] || null;
}
function fieldRange(name) {
  let lo = Infinity, hi = -Infinity;
  for (const frame of data.frames) if (frame.usual[name]) { lo = Math.min(lo, frame.usual[name][0]); hi = Math.max(hi, frame.usual[name][1]); }
  return FIELDS[name].range(lo, hi);
}
const grainRange = () => [0, Math.max(1e-30, ...data.frames.map(f => f.speed_high || 0))];
let legendNow = '';
function drawLegend() {
  const field = film.field && FIELDS[film.field];
  const range = field ? fieldRange(film.field) : grainRange(), map = field ? field.map() : 'dry';
  const flat = innerWidth <= 640, key = [film.field, range, map, flat, canvas.clientHeight].join();
  if (key === legendNow) return;
  legendNow = key;
  const unit = unitFor(Math.max(-range[0], range[1]), field ? field.unit : 'm/s');
  $('legend-name').textContent = (field ? field.long : 'grain speed') + (unit.name ? ` [${unit.name}]` : '');
  const bar = $('legend-bar'), colours = table(map), context = bar.getContext('2d');
  bar.width = flat ? 256 : 1; bar.height = flat ? 1 : 256;
  const image = context.createImageData(bar.width, bar.height);
  for (let i = 0; i < 256; i++) { const k = flat ? i : 255 - i; image.data.set([colours[3 * k], colours[3 * k + 1], colours[3 * k + 2], 255], 4 * i); }
  context.putImageData(image, 0, 0);
  const [lo, hi] = range.map(v => v / unit.factor);
  $('legend-marks').replaceChildren(...ticks(lo, hi, flat ? 4 : 6).map(t => {
    const mark = node('b', {}, minus(String(+t.toPrecision(6))));
    mark.style[flat ? 'left' : 'bottom'] = 100 * (hi > lo ? (t - lo) / (hi - lo) : 0) + '%';
    return mark;
  }));
}
function stepOf(time) {
  const times = data.steps.time || [], steps = data.steps.step || [];
  let best = 0, found = 0;
  for (let i = 0; i < times.length && times[i] <= time * (1 + 1e-9); i++) { best = i; found = steps[i]; }
  return found;
}
async function show(index) {
  const count = data.frames.length;
  if (!count) return;
  film.index = Math.max(0, Math.min(index, count - 1));
  const wanted = film.index;
  try {
    const shown = await state(wanted);
    if (wanted !== film.index) return;
    film.shown = shown;
  } catch (error) { stop(); $('counter').textContent = 'This state cannot be shown: ' + error.message; return; }
  $('scrub').value = wanted;
  const time = data.frames[wanted].time;
  $('scrub').setAttribute('aria-valuetext', `t = ${quantity(time, 's')}`);
  $('counter').textContent = `step ${stepOf(time)} · t = ${quantity(time, 's')} · state ${wanted + 1} of ${count}`;
  canvas.dataset.step = stepOf(time);
  draw(); moveNow(time);
  if (wanted + 1 < count) state(wanted + 1).catch(() => {});
}
let timer = 0;
async function tick() {
  if (!film.playing) return;
  const begun = performance.now();
  if (film.index + 1 >= data.frames.length) return stop();
  await show(film.index + 1);
  timer = setTimeout(tick, Math.max(0, 1000 / +$('pace').value - (performance.now() - begun)));
}
function play() {
  if (film.index + 1 >= data.frames.length) film.index = -1;
  film.playing = true; $('play').textContent = 'Pause'; $('play').setAttribute('aria-label', 'Pause'); tick();
}
function stop() { film.playing = false; clearTimeout(timer); $('play').textContent = 'Play'; $('play').setAttribute('aria-label', 'Play'); }
function listen() {
  $('play').onclick = () => film.playing ? stop() : play();
  $('scrub').oninput = () => { stop(); show(+$('scrub').value); };
  $('grains').onchange = draw;
  $('home').onclick = home;
  handle();
  canvas.addEventListener('keydown', event => {
    const keys = {
      ' ': () => $('play').click(), ArrowRight: () => { stop(); show(film.index + 1); }, ArrowLeft: () => { stop(); show(film.index - 1); },
      Home: () => { stop(); show(0); }, End: () => { stop(); show(1e9); }, '+': () => zoom(1.25), '=': () => zoom(1.25), '-': () => zoom(0.8), 0: home,
      w: () => move(0, 1), s: () => move(0, -1), a: () => move(-1, 0), d: () => move(1, 0),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  new ResizeObserver(() => { if (film.stage) { fit(); draw(); } charts(); }).observe(document.body);
  dark.addEventListener('change', () => { legendNow = ''; draw(); });
}

// ---- time series ------------------------------------------------------------------------------
const CHARTS = [
  { title: 'Fall velocity', unit: 'm/s', lines: { fall_speed: 'mean of the grains' } },
  { title: 'Fluid', unit: 'm/s', lines: { fluid_speed_max: 'largest speed' } },
  { title: 'Front and centre', unit: 'm', lines: { rear: 'highest grain', centre_y: 'centre', front: 'lowest grain' } },
  { title: 'Grains', unit: '', whole: true, lines: { grains: 'in the fluid', removed_grains: 'have left' } },
  { title: 'Width', unit: 'm', lines: { width: 'all grains', width98: '98 % of them' } },
  { title: 'Pressure drop', unit: 'Pa', lines: { pressure_drop: 'inflow to outflow' } },
  { title: 'Flow', unit: inSpace() ? 'm³/s' : 'm²/s', lines: { inflow: 'in, as asked for', outflow: 'out by open sides' } },
  { title: 'Mean pressure gradient', unit: 'Pa/m', lines: { mean_pressure_gradient_x: 'x', mean_pressure_gradient_y: 'y' } },
  { title: 'Porosity', unit: '', lines: { porosity_min: 'smallest' } },
  { title: 'Defects of the budgets', unit: '', log: true, lines: { volume_defect: 'volume', third_law_defect: 'action = reaction', momentum_defect: 'momentum carried on', energy_defect: 'energy' } },
  { title: 'Residuals', unit: '', log: true, lines: { interaction_defect: 'interaction', contact_residual: 'contacts, of |g|Δt', penetration_max: 'penetration, of a radius' } },
  { title: 'Passes and sub-steps', unit: '', whole: true, lines: { passes: 'passes', sub_steps: 'sub-steps' } },
  { title: 'Contacts', unit: '', whole: true, lines: { contacts: 'active' } },
  { title: 'Wall time of a step', unit: 's', lines: { wall_fluid: 'fluid', wall_particles: 'grains', wall_coupler: 'coupler', wall_exchange: 'exchange' } },
];
const drawn = [];
function charts() {
  const width = Math.round(($('charts').clientWidth - 16) / Math.max(1, Math.floor($('charts').clientWidth / 432))) - 34;
  const forces = Object.keys(data.steps).filter(name => name.startsWith('force_'));
  const list = forces.length && forces.length <= 6 && !data.run.scene.grains ? [...CHARTS, { title: 'Forces on boundaries', unit: inSpace() ? 'N' : 'N/m', lines: Object.fromEntries(forces.map(f => [f, f.slice(6).replace('_', ' ')])) }] : CHARTS;
  drawn.length = 0;
  $('charts').replaceChildren(...list.map(chart => plot(chart, Math.max(width, 250))).filter(Boolean));
  if (data.frames.length) moveNow(data.frames[Math.max(film.index, 0)].time);
}
function plot(chart, W) {
  const time = data.steps.time;
  const lines = Object.entries(chart.lines).filter(([name]) => (data.steps[name] || []).some(v => v !== null && (chart.log ? v !== 0 : true)));
  if (!time || time.length < 2 || !lines.length) return null;
  if (lines.every(([name]) => data.steps[name].every(v => v === 0))) return null;
  const H = 210, left = 58, right = 8, top = 8, bottom = 34;
  let lo = Infinity, hi = -Infinity;
  const value = v => chart.log ? (v === null || v === 0 ? NaN : Math.log10(Math.abs(v))) : v === null ? NaN : v;
  for (const [name] of lines) for (const v of data.steps[name]) { const u = value(v); if (Number.isFinite(u)) { lo = Math.min(lo, u); hi = Math.max(hi, u); } }
  if (chart.log) { lo = Math.max(Math.floor(lo), -18); hi = Math.max(Math.ceil(hi), lo + 1); } else {
    if (chart.whole || lo > 0 && lo < .4 * hi) lo = Math.min(lo, 0);
    if (hi <= lo) { const d = Math.abs(hi) * .05 || 1; lo -= d; hi += d; }
    const d = (hi - lo) * .04; hi += d; if (lo !== 0) lo -= d;
  }
  const unit = chart.log ? { factor: 1, name: '' } : unitFor(Math.max(Math.abs(lo), Math.abs(hi)), chart.unit);
  const clock = unitFor(time[time.length - 1], 's'), t0 = Math.min(0, time[0]), t1 = time[time.length - 1];
  const X = t => left + (t - t0) / (t1 - t0) * (W - left - right), Y = v => H - bottom - (v - lo) / (hi - lo) * (H - top - bottom);
  let svg = `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${chart.title} over time">`;
  const rows = chart.log ? ticks(lo, hi, 5).filter(Number.isInteger) : ticks(lo / unit.factor, hi / unit.factor, 4).filter(t => !chart.whole || Number.isInteger(t));
  for (const t of rows) { const y = Y(chart.log ? t : t * unit.factor); svg += `<line class="grid" x1="${left}" x2="${W - right}" y1="${y}" y2="${y}"/><text x="${left - 6}" y="${y + 4}" text-anchor="end">${chart.log ? ten(t) : number(t)}</text>`; }
  for (const t of ticks(t0 / clock.factor, t1 / clock.factor, W / 90)) { const x = X(t * clock.factor); svg += `<line class="grid" x1="${x}" x2="${x}" y1="${top}" y2="${H - bottom}"/><text x="${x}" y="${H - bottom + 16}" text-anchor="middle">${number(t)}</text>`; }
  svg += `<text x="${(left + W - right) / 2}" y="${H - 3}" text-anchor="middle">time [${clock.name}]</text>`;
  lines.forEach(([name], i) => {
    let path = '', open = false;
    data.steps[name].forEach((v, k) => { const u = value(v); if (!Number.isFinite(u)) { open = false; return; } path += (open ? 'L' : 'M') + X(time[k]).toFixed(1) + ' ' + Y(Math.max(u, lo)).toFixed(1); open = true; });
    svg += `<path d="${path}" stroke="var(--c${i % 6})"/>`;
  });
  svg += `<line class="now" x1="-9" x2="-9" y1="${top}" y2="${H - bottom}"/></svg>`;
  const figure = node('figure', { class: 'chart card' });
  const caption = node('figcaption', {}, chart.title + ' '), small = node('small', {}, unit.name ? `[${unit.name}]` : '');
  caption.append(small);
  const keys = node('div', { class: 'keys' }, ...lines.map(([, label], i) => node('span', { style: `--k:var(--c${i % 6})` }, label)));
  figure.append(caption, keys);
  figure.insertAdjacentHTML('beforeend', svg);
  drawn.push({ line: figure.querySelector('.now'), X });
  return figure;
}
function moveNow(time) { for (const { line, X } of drawn) { line.setAttribute('x1', X(time)); line.setAttribute('x2', X(time)); } }

// ---- the rest ---------------------------------------------------------------------------------
const rows = (list, heads) => {
  const body = node('table');
  if (heads) body.append(node('tr', {}, ...heads.map((h, i) => node('th', i ? { class: 'number', scope: 'col' } : { scope: 'col' }, h))));
  for (const cells of list) body.append(node('tr', {}, ...cells.map((c, i) => i ? node('td', { class: typeof c === 'string' && cells.length < 3 && c.length > 24 ? '' : 'number' }, c) : node('th', { scope: 'row' }, c))));
  return body;
};
const NAMES = { fluid: 'fluid engine', particles: 'particle engine', coupler: 'coupler', exchange: 'exchange' };
function words() {
  const run = data.run, exit = run.exit, cost = run.cost || {}, badge = $('state');
  $('title').textContent = run.scene.name;
  const grains = run.scene.grains, steps = run.steps;
  const gone = (data.steps.removed_grains || []).at(-1);
  const live = data.steps.step ? data.steps.step[data.steps.step.length - 1] : 0;
  $('summary').textContent = `${exit ? steps : live} steps to t = ${quantity(exit ? run.time_reached : (data.steps.time || [0]).at(-1), 's')}` + (grains ? `, ${grains} grain${grains > 1 ? 's' : ''}` : ', no grains') + (gone ? `, ${gone} of them left` : '') + ((run.resumed || []).length ? `, resumed after step ${run.resumed.map(r => r.step).join(', ')}` : '') + (cost.wall_total ? `, ${quantity(cost.wall_total, 's', 3)} on ${run.machine.cores} cores` : '');
  badge.className = 'badge' + (!exit ? ' runs' : exit.code ? ' bad' : '');
  badge.textContent = !exit ? (data.live ? 'running' : 'not finished when this was written') : exit.code ? `exit ${exit.code}, ${(exit.why || '').startsWith(exit.meaning) ? exit.why : exit.meaning + ': ' + exit.why}` : 'finished';
  const cpu = cost.cpu_process || {}, phases = ['fluid', 'particles', 'coupler', 'exchange'].filter(p => cost['wall_' + p] !== undefined);
  const total = phases.reduce((sum, p) => sum + cost['wall_' + p], 0) || 1;
  const list = phases.map(p => { const share = cost['wall_' + p] / total, meter = node('div', { class: 'meter', style: `width:${100 * share}%` });
    return [NAMES[p], meter, quantity(cost['wall_' + p], 's', 3), cpu[p] === undefined ? '–' : quantity(cpu[p], 's', 3), ((run.cost.memory_peak || {})[p] ? quantity(run.cost.memory_peak[p], 'B', 3) : '–')]; });
  const table = rows(list, ['phase', '', 'wall', 'CPU', 'peak memory']);
  table.querySelectorAll('td:nth-child(2)').forEach(cell => { cell.className = ''; cell.style.width = '26%'; });
  $('cost').replaceChildren(list.length ? node('div', { class: 'wide' }, table) : node('p', { class: 'muted' }, 'Known when the run has ended.'));
  const worst = run.worst || {}, meaning = { volume_defect: 'volume deposited', third_law_defect: 'action = reaction', momentum_defect: 'momentum carried to the next step', energy_defect: 'energy', interaction_defect: 'interaction', contact_residual: 'contact residual, of |g|Δt', penetration_max: 'penetration, of a radius', porosity_min: 'smallest porosity' };
  const balance = Object.entries(meaning).filter(([k]) => worst[k] !== undefined).map(([k, label]) => [label, number(worst[k], 3)]);
  $('worst').replaceChildren(balance.length ? rows(balance, ['worst of all steps', '']) : node('p', { class: 'muted' }, 'Known when the run has ended.'));
  const plan = run.plan, part = (title, list) => list && list.length ? [node('h3', {}, title), node('ul', {}, ...list.map(t => node('li', {}, t)))] : [];
  $('plan').replaceChildren(...(plan ? [...part('Processes', plan.processes.map(p => p.seat + ': ' + p.command.join(' '))), ...part('Sizes', plan.sizes), ...part('Terms', plan.terms), ...part('Left out', plan.left_out), ...part('Chosen', (plan.choices || []).map(c => c.part + ': ' + c.chosen + ': ' + c.reason)), ...part('Kept', plan.kept), ...part('Warnings', plan.warnings)] : [node('p', { class: 'muted' }, 'This run was made by a version that did not write its plan.')]));
  const versions = [['sillage', `${run.versions.sillage}, commit ${run.versions.commit || 'unknown'}`], ['protocol', String(run.versions.protocol)], ...(run.engines || []).map(e => [e.role.toLowerCase(), `${e.engine} ${e.version}`]), ['machine', `${run.machine.cpu}, ${run.machine.cores} cores, ${quantity(run.machine.memory, 'B', 3)}`], ['system', run.machine.system], ['written', new Date(run.written * 1000).toISOString().replace('T', ' ').slice(0, 16) + ' UTC']];
  $('versions').replaceChildren(rows(versions));
  $('scene').textContent = data.scene; $('resolved').textContent = JSON.stringify(run.scene.resolved, null, 2);
}
function take() {
  for (const frame of data.frames) if (frame.grain_speed) frame.speed_high = frame.grain_speed.high;
  $('scrub').max = Math.max(0, data.frames.length - 1);
  $('film').hidden = !data.frames.length; $('empty').hidden = !!data.frames.length;
}
async function refresh() {
  const atEnd = film.index + 1 >= data.frames.length, playing = film.playing;
  try {
    const fresh = await ask('api/run');
    const changed = JSON.stringify(fresh.run) !== JSON.stringify(data.run) || (fresh.steps.time || []).length !== (data.steps.time || []).length || fresh.frames.length !== data.frames.length || (fresh.steps.time || []).at(-1) !== (data.steps.time || []).at(-1);
    if (fresh.frames.length < data.frames.length) { cache.clear(); film.stage = null; film.view = null; }
    data = fresh;
    if (changed) {
      await setStage(); take(); chooseFields(); words(); charts();
      if (film.stage && !film.view) fit();
      if (!playing && film.stage) show(atEnd || !film.shown ? data.frames.length - 1 : film.index);
    }
  } catch (error) { $('state').className = 'badge bad'; $('state').textContent = 'no answer from sillage view'; }
  setTimeout(refresh, 2000);
}
async function start() {
  if (data.live) data = await ask('api/run');
  take(); words();
  await setStage();
  chooseFields(); listen();
  if (film.stage) { fit(); await show(0); }
  charts();
  document.documentElement.dataset.ready = 'yes';
  if (data.live) setTimeout(refresh, 2000);
}
/// The last line of what draws the animation.
function begin() {
  start().catch(error => { $('state').className = 'badge bad'; $('state').textContent = 'This page failed: ' + error.message; });
}
